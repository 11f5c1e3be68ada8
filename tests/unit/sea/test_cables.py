"""Cables are measured in the truth, in three dimensions."""

from task_bench import habitat

from grex_link.messages import Pose, Truth
from grex_sim.cables import Cable, CableWatch


def truth(tick: int, **places) -> Truth:
    return Truth(tick, tick, [Pose(craft, *place, 0.0, 0.0, 0.0, 0.0) for craft, place in places.items()])


def test_longest_and_over():
    """The greatest distance is kept, and steps beyond the length are counted; others do not matter."""
    watch = CableWatch(habitat())
    far = {"aid": (900.0, 0.0, 0.0), "ship": (0.0, 900.0, 0.0)}
    watch.see(truth(0, top=(0.0, 0.0, 0.0), low=(3.0, 4.0, 12.0), **far))
    assert watch.cables == [Cable(("top", "low"), 15.0, 13.0, 0)]
    watch.see(truth(1, top=(0.0, 0.0, 0.0), low=(12.0, 0.0, 16.0), **far))
    watch.see(truth(2, top=(0.0, 0.0, 0.0), low=(0.0, 0.0, 10.0), **far))
    assert watch.cables == [Cable(("top", "low"), 15.0, 20.0, 1)]
