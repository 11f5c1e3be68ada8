"""Rows of `grex study team` for what goes beyond the paper's law: the shared reference, and ranges."""

from collections.abc import Iterator

from grex_sim.study.figures import Flight, deviation, worst_place_error
from grex_sim.study.rows import CONDITIONS, WIDE
from grex_sim.study.table import AtMost, Row

#: The best law, as in deploy/scenarios/shared-reference.toml: every craft tracks its copy of a team reference; the own
#: speed error and the unknown current are removed aboard. One set of parameters for all conditions.
BEST = (
    "team.controller=shared_reference",
    "team.estimator=none",
    "team.reference={gain_per_s=0.5}",
    "team.speed_model={error_relative=0.0155, error_time_s=800.0}",
    "team.own_filter={place_noise_m=0.001, current_sigma_mps=0.15, current_noise_mps=1e-6}",
    'team.talk={type="event", threshold_m=0.5, heartbeat_slots=9}',
    "guidance.cross_track_gain_rad_per_m=0.2",
    "guidance.curvature_feedforward=1.27",
)
_TARGETS = (
    ("best_fd_loss0", "s0", 0.0, 0.008),
    ("best_fd_loss50", "s0", 0.5, 0.010),
    ("slow_mate_fd_loss0", "s5", 0.0, 0.16),
    ("slow_mate_fd_loss50", "s5", 0.5, 0.35),
    ("wander_fd_loss0", "s4", 0.0, 0.030),
    ("dgps_fd_loss0", "s1", 0.0, 0.20),
    ("current_fd_loss0", "s3", 0.0, 0.015),
)


def best(condition: str, loss: float = 0.0, more: tuple[str, ...] = ()) -> Flight:
    """Fly a condition under the best law."""
    return Flight(CONDITIONS[condition][0], (*BEST, f"link.loss={loss}", *more))


def _best() -> Iterator[Row]:
    for name, condition, loss, limit in _TARGETS:
        about = f"{CONDITIONS[condition][1]}, best law, {100 * loss:.0f} % loss: FD"
        yield Row(name, about, deviation(best(condition, loss)), AtMost(limit))
    for condition, (_, about) in CONDITIONS.items():
        yield Row(f"{condition}_silent_fd", f"{about}, best law, no message ever: FD", deviation(best(condition, 1.0)))
    for condition in ("s2", "s6"):
        about = f"{CONDITIONS[condition][1]}, best law: FD"
        yield Row(f"{condition}_best_fd_loss0", about, deviation(best(condition)))
    for profile in ("grex2008", "s2c_im"):
        flight = best("s0", more=(*WIDE, f"link.profile={profile}"))
        yield Row(f"{profile}_best_fd_loss0", f"200 m formation, {profile}, best law: FD", deviation(flight))


def _ranges() -> Iterator[Row]:
    drifting = "auv1", "auv2"
    about = "INS drift of 0.5 m/min on two of three craft, 2 h, ranges to the third"
    flight = Flight("ins-drift")
    yield Row("ins_drift_rms_m", f"{about}: position error, m rms", worst_place_error(flight, drifting), AtMost(5.0))
    without = Flight("ins-drift", ("team.ranging.mode=off",))
    yield Row("ins_drift_no_ranging_rms_m", "the same without ranges", worst_place_error(without, drifting))


BEYOND = (*_best(), *_ranges())
