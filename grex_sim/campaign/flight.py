"""One run of a campaign: a mission in this process, nothing recorded, and the figures that are kept of it."""

import msgspec

from grex_sim.campaign.definition import Job
from grex_sim.run import simulate_in_process
from grex_sim.summary import Summary


class Figures(msgspec.Struct, frozen=True, kw_only=True):
    """What is kept of a run; metres, radians, seconds. None where there is none."""

    seed: int
    fd: float | None
    """Formation deviation (eqs. 4 and 5)."""
    fd_distance: float | None
    fd_angle: float | None
    fd_xte: float | None
    duration_s: float
    """Of mission."""
    wall_s: float
    messages_sent: int
    bytes_sent: int
    delivered: int
    """Summed over the receivers."""
    lost: int
    refused: int
    age_mean_s: float | None
    """Age of information, mean of the directed links that carried anything."""
    age_worst_s: float | None
    """Of the worst link."""
    silent_links: int
    """Directed links that carried nothing."""
    bad_frames: int
    adrift_steps: int
    """Steps times craft in which the current was too strong."""
    unhealthy_steps: int
    """Steps times craft in which an agent reported that something was wrong."""
    ledger_faults: int
    digest: str


def fly(job: Job) -> dict[str, float | int | str | None]:
    """Fly a job's scenario."""
    return msgspec.structs.asdict(figures(simulate_in_process(job.scenario, None, lambda _: None)))


def figures(summary: Summary) -> Figures:
    """Keep of a summary what a campaign compares."""
    ages = [path.age_mean_s for path in summary.paths.values() if path.age_mean_s >= 0.0]
    return Figures(
        seed=summary.seed,
        fd=summary.fd,
        fd_distance=summary.fd_distance,
        fd_angle=summary.fd_angle,
        fd_xte=summary.fd_xte,
        duration_s=summary.duration_s,
        wall_s=summary.wall_s,
        messages_sent=summary.messages_sent,
        bytes_sent=summary.bytes_sent,
        delivered=summary.delivered,
        lost=summary.lost,
        refused=summary.refused,
        age_mean_s=sum(ages) / len(ages) if ages else None,
        age_worst_s=max(ages, default=None),
        silent_links=len(summary.paths) - len(ages),
        bad_frames=sum(summary.bad_frames.values()),
        adrift_steps=sum(summary.adrift_steps.values()),
        unhealthy_steps=sum(sum(words.values()) for words in summary.unhealthy_steps.values()),
        ledger_faults=len(summary.ledger_faults),
        digest=summary.digest,
    )
