"""The rows of `grex study team` under the paper's law, eq. (2).

A row is a name, what it is about, a figure over missions, and what is to be reached. The missions are files of
deploy/scenarios with overrides; those under ``conditions/`` are S1 to S6, and S0 is the paper's own mission.
"""

from collections.abc import Iterator

from grex_sim.study.consistency import RUNS, Consistency
from grex_sim.study.figures import Flight, deviation, mean_age, nees, ratio
from grex_sim.study.table import AtMost, InBand, Row

S0, S1, S2, S3 = "paper-d", "conditions/dgps", "conditions/ins", "conditions/current"
S4, S5, S6 = "conditions/wander", "conditions/slow-mate", "conditions/all-errors"
CONDITIONS = {
    "s0": (S0, "paper's mission"),
    "s1": (S1, "DGPS noise"),
    "s2": (S2, "drifting INS"),
    "s3": (S3, "unknown current"),
    "s4": (S4, "wandering speeds"),
    "s5": (S5, "slow mate"),
    "s6": (S6, "S1 + S3 + 2 % wander"),
}
#: What an estimator has to beat, and the ends of the scale.
COMPARED = ("none", "ideal", "hold_last", "dead_reckoning", "first_level", "second_level", "biased_planar")
ESTIMATORS = (
    *("hold_last", "dead_reckoning", "first_level", "second_level", "biased_planar_first", "biased_planar"),
    *("along_track_first", "along_track", "own_filter"),
)
#: A formation 200 m wide, and the modem that fits it: 0.05 s a message instead of 10 s.
WIDE = (
    "mission.formation_m.auv2=[-6.0, -100.0, 0.0]",
    "mission.formation_m.auv3=[-6.0, 100.0, 0.0]",
    "mission.turn_radius_m=150.0",
)


def p_law(
    condition: str, estimator: str, *, gain: float = 0.8, loss: float = 0.0, more: tuple[str, ...] = ()
) -> Flight:
    """Fly a condition under the paper's law, eq. (2)."""
    method = f"team.estimator={estimator}", f"team.gain_mps={gain}"
    return Flight(condition, (*method, *((f"link.loss={loss}",) if loss else ()), *more))


def _estimators() -> Iterator[Row]:
    for name, condition, gain, loss, limit, about in (
        ("estimator_ratio_loss0", S0, 0.8, 0.0, 1.01, "S0, K 0.8, no loss"),
        ("estimator_ratio_loss50", S0, 0.8, 0.5, 1.02, "S0, K 0.8, 50 % loss"),
        ("estimator_ratio_slow_loss0", S5, 8.0, 0.0, 1.15, "S5 slow mate, K 8, no loss"),
    ):
        flight, ideal = (p_law(condition, estimator, gain=gain, loss=loss) for estimator in ("along_track", "ideal"))
        yield Row(name, f"{about}: FD of along_track / FD of ideal", ratio(flight, ideal), AtMost(limit))
    for name, condition, gain, about in (("loss", S0, 0.8, "S0, K 0.8"), ("slow_loss", S5, 8.0, "S5 slow mate, K 8")):
        for estimator in ("hold_last", "dead_reckoning", "first_level", "second_level", "biased_planar"):
            for loss in (0.0, 0.5):
                flight, ideal = (p_law(condition, each, gain=gain, loss=loss) for each in (estimator, "ideal"))
                row = f"{estimator}_ratio_{name}{100 * loss:.0f}"
                yield Row(
                    row, f"{about}, {100 * loss:.0f} % loss: FD of {estimator} / FD of ideal", ratio(flight, ideal)
                )


def _conditions() -> Iterator[Row]:
    for short, (condition, about) in CONDITIONS.items():
        for estimator in (*COMPARED, "along_track"):
            flight = p_law(condition, estimator)
            yield Row(f"{short}_{estimator}_fd_loss0", f"{about}, K 0.8, {estimator}: FD", deviation(flight))
    for short in ("s1", "s6"):
        condition, about = CONDITIONS[short]
        flight = p_law(condition, "along_track", more=("team.own_filter={}",))
        yield Row(
            f"{short}_own_filter_fd_loss0", f"{about}, K 0.8, along_track, own fixes filtered: FD", deviation(flight)
        )


def _modem() -> Iterator[Row]:
    for profile in ("grex2008", "s2c_im"):
        for estimator in ("second_level", "along_track"):
            flight = p_law(S0, estimator, more=(*WIDE, f"link.profile={profile}"))
            where = f"200 m formation, {profile}, {estimator}"
            yield Row(f"{profile}_{estimator}_fd_loss0", f"{where}: FD", deviation(flight))
        yield Row(f"{profile}_age_s", f"200 m formation, {profile}: mean age of information, s", mean_age(flight))
    yield Row(
        "wide_ideal_fd_loss0", "200 m formation, ideal communication: FD", deviation(p_law(S0, "ideal", more=WIDE))
    )


def _consistency() -> Iterator[Row]:
    for estimator in ESTIMATORS:
        for loss in (0.0, 0.3, 0.5):
            of = "fixes" if estimator == "own_filter" else "messages"
            about = f"NEES of {estimator}, errors drawn as it models them, {100 * loss:.0f} % of {of} lost"
            # Of the own filter it is north and east, of the others the place along the path.
            band = InBand(2 * RUNS if estimator == "own_filter" else RUNS)
            yield Row(f"nees_{estimator}_loss{100 * loss:.0f}", about, nees(Consistency(estimator, loss)), band)
    for estimator in ("second_level", "along_track_first", "along_track"):
        claimed = InBand(RUNS) if estimator == "along_track" else None
        for loss in (0.0, 0.3, 0.5):
            about = f"NEES of {estimator} at K 8, {100 * loss:.0f} % of messages lost"
            row = f"nees_{estimator}_stiff_loss{100 * loss:.0f}"
            yield Row(row, about, nees(Consistency(estimator, loss, 8.0)), claimed)


PAPERS_LAW = (*_estimators(), *_conditions(), *_modem(), *_consistency())
