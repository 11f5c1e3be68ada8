"""``grex report``, ``grex replay`` and ``grex export``: what is done with runs that are over."""

from pathlib import Path
from typing import Annotated, Literal

import tyro

Run = Annotated[
    Path, tyro.conf.Positional, tyro.conf.arg(metavar="RUN", help="The run's folder, or its run.mcap; cut off will do.")
]
Runs = Annotated[
    tuple[Path, ...], tyro.conf.Positional, tyro.conf.arg(metavar="RUN…", help="Folders of runs, or their run.mcap.")
]


def replay(
    run: Run,
    craft: Annotated[str, tyro.conf.arg(metavar="NAME")],
    estimator: Annotated[str | None, tyro.conf.arg(metavar="NAME")] = None,
    out: Annotated[Path | None, tyro.conf.arg(metavar="PNG")] = None,
) -> None:
    """Feed what a recorded craft saw to an agent again, and compare what it does; or try another estimator on it.

    Parameters
    ----------
    run
        The run.
    craft
        Which craft is replayed.
    estimator
        Show what this estimator would have believed, against the truth, instead of comparing.
    out
        Where the picture of that goes; default beside the recording.
    """
    from grex_link.errors import ConfigError
    from grex_sim.replay_text import compare, reconsider

    if estimator is None:
        if out is not None:
            raise ConfigError("--out", "there is a picture only with --estimator")
        print(compare(run, craft))  # noqa: T201
    else:
        print(reconsider(run, craft, estimator, out))  # noqa: T201


def export(
    run: Run,
    to: Annotated[Literal["csv", "parquet"], tyro.conf.arg(metavar="csv|parquet")],
    out: Annotated[Path | None, tyro.conf.arg(metavar="DIR")] = None,
) -> None:
    """Write a recording as tables: one file a topic, a row a message, units in the names of the columns.

    Parameters
    ----------
    run
        The run.
    to
        What kind of files; parquet needs the extra: pip install 'grex[campaign]'.
    out
        Their folder; default: a folder csv or parquet beside the recording.
    """
    from grex_link.recording import Recording
    from grex_sim.export import export as write

    recording = Recording(run)
    folder = out or recording.path.parent / to
    counts = write(recording, folder, to)
    if recording.remark:
        print(recording.remark)  # noqa: T201
    print("\n".join([*(f"{count:8d} rows  {name}" for name, count in counts.items()), f"files in {folder}"]))  # noqa: T201


def report(
    runs: Runs,
    out: Annotated[Path | None, tyro.conf.arg(metavar="FILE")] = None,
) -> None:
    """Write one HTML page about a run, or about several side by side; it has everything in it.

    Parameters
    ----------
    runs
        The runs; differences are to the first.
    out
        The page; default: report.html beside the recording, or here if there are several.
    """
    from grex_link.errors import ConfigError
    from grex_link.recording import recording_file
    from grex_sim.report_page import REPORT_FILE, write_report

    if not runs:
        raise ConfigError("RUN", "which run? Name one folder or more")
    path = out or (recording_file(runs[0]).with_name(REPORT_FILE) if len(runs) == 1 else Path(REPORT_FILE))
    print("\n".join([*write_report(runs, path), f"report {path}"]))  # noqa: T201
