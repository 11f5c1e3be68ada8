"""What ``grex replay`` shows: that a replay is the recording, or what another estimator would have believed."""

from collections.abc import Mapping
from itertools import islice
from pathlib import Path

import msgspec
import numpy as np

from grex_link.config import Scenario
from grex_link.errors import GrexError
from grex_link.recording import Recording
from grex_sim.belief_errors import BeliefErrors, belief_errors
from grex_sim.canvas import colour, dash, new_figure, save, thin
from grex_sim.layout import table
from grex_sim.replay import TOLERANCE, Tape, first_difference, read_tape, replay

_PANELS_MAX = 6
_SAMPLES_MAX = 4000


def compare(run: Path, craft: str) -> str:
    """Replay a craft, and say that its core does again what it did.

    Raises
    ------
    GrexError
        With the first difference, if there is one.
    """
    recording = Recording(run)
    tape = read_tape(recording, craft)
    difference = first_difference(tape, recording.scenario, craft)
    if difference is not None:
        raise GrexError(f"{craft} replays otherwise from {difference}")
    lines = [recording.remark] if recording.remark else []
    found = f"{len(tape.states)} steps, {len(tape.events)} modem events and {len(tape.requests)} requests"
    return "\n".join([*lines, f"{craft}: {found} replayed; every output is the recorded one within {TOLERANCE:g}"])


def reconsider(run: Path, craft: str, estimator: str, picture: Path | None) -> str:
    """Show what another estimator would have believed of what a craft heard; it moves as it did.

    Parameters
    ----------
    run : Path
        Folder or file of the run.
    craft : str
        Whose beliefs.
    estimator : str
        As in the scenario.
    picture : Path or None
        Where the picture goes; left out: beside the recording.

    Raises
    ------
    ConfigError
        If there is no such recording, craft or estimator.
    """
    recording = Recording(run)
    tape = read_tape(recording, craft)
    before = recording.scenario.team.estimator
    changed = with_estimator(recording.scenario, estimator)
    errors = {
        f"{before} (recorded)": belief_errors(tape.states, tape.truths),
        f"{estimator} (replayed)": _errors_of(tape, changed, craft),
    }
    path = picture or recording.path.with_name(f"replay-{craft}.png")
    lines = [recording.remark] if recording.remark else []
    lines += [f"what {craft} believed of its mates, against the truth; it moves as it did, whatever it believes"]
    lines += [*_table(errors), f"picture {_draw(path, craft, errors)}"]
    return "\n".join(lines)


def with_estimator(scenario: Scenario, estimator: str) -> Scenario:
    """Return a scenario with another estimator of the mates."""
    return msgspec.structs.replace(scenario, team=msgspec.structs.replace(scenario.team, estimator=estimator))


def _errors_of(tape: Tape, scenario: Scenario, craft: str) -> dict[str, BeliefErrors]:
    return belief_errors((step.state for step in replay(tape, scenario, craft)), tape.truths)


def _table(errors: Mapping[str, Mapping[str, BeliefErrors]]) -> list[str]:
    headings = ["mate", "estimator", "error r.m.s. m", "largest m", "mean sigma m", "mean NEES (2)", "inside (95 %)"]
    mates = dict.fromkeys(mate for found in errors.values() for mate in found)
    rows = [
        [mate, name, *_figures(found[mate])] if mate in found else [mate, name, *["-"] * 5]
        for mate in mates
        for name, found in errors.items()
    ]
    return list(table(headings, rows, 2))


def _figures(errors: BeliefErrors) -> list[str]:
    sigmas = errors.sigma_m[np.isfinite(errors.sigma_m)]
    distances = errors.distance_m[np.isfinite(errors.distance_m)]
    claimed = (
        [f"{sigmas.mean():.3f}", str(errors.mean_nees), f"{100 * errors.inside:.1f} %"] if len(sigmas) else ["-"] * 3
    )
    return [f"{errors.rms_m:.3f}", f"{distances.max(initial=0.0):.3f}", *claimed]


def _draw(path: Path, craft: str, errors: Mapping[str, Mapping[str, BeliefErrors]]) -> Path:
    mates = list(islice(dict.fromkeys(mate for found in errors.values() for mate in found), _PANELS_MAX))
    figure = new_figure(12.0, 1.5 + 2.6 * max(len(mates), 1))
    panels = figure.subplots(max(len(mates), 1), 1, sharex=True, squeeze=False)[:, 0]
    for axes, mate in zip(panels, mates, strict=False):
        for place, (name, found) in enumerate(errors.items()):
            if mate in found:
                one = found[mate]
                time_s, distance = thin(one.t_s, _SAMPLES_MAX), thin(one.distance_m, _SAMPLES_MAX)
                axes.plot(time_s, distance, color=colour(place), linestyle=dash(7 * place), linewidth=1.0, label=name)
                axes.plot(time_s, 2 * thin(one.sigma_m, _SAMPLES_MAX), color=colour(place), linewidth=0.6, alpha=0.5)
        axes.set_title(f"What {craft} believes of {mate}: distance from the truth; thin: twice the sigma it claims")
        axes.set(ylabel="error (m)", axisbelow=True)
        axes.set_ylim(bottom=0.0)
        axes.grid(visible=True, color="0.9", linewidth=0.6)
    panels[-1].set_xlabel("mission time (s)")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=2, frameon=False)
    return save(figure, path)
