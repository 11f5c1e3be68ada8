"""Which craft is called what, and in which order they stand in the file, is no matter.

::

    auv2 ─────►          b ─────►
       auv1 ─────►    =     a ─────►       each keeps its place, its slot and its fault
    auv3 ─────►          c ─────►
"""

import numpy as np
import pytest

from grex_link.scenario import loads
from grex_sim.logbook import Logbook
from grex_sim.run import simulate_in_process

PLACES = {"auv1": (0.0, 0.0), "auv2": (-6.0, -25.0), "auv3": (-6.0, 25.0)}
ESTIMATORS = ["first_level", "second_level", "biased_planar", "along_track", "dead_reckoning"]


def scenario(estimator, order, names, seed=1, loss=0.0):
    """The paper's team on short legs at a stiff gain, in some order and under some names, each with its own slot."""
    slots = ", ".join(
        f'{{ craft = "{names[craft]}", start_s = {10.0 * place}, length_s = 10.0 }}'
        for place, craft in enumerate(PLACES)
    )
    formation = "\n".join(f"{names[craft]} = [{PLACES[craft][0]}, {PLACES[craft][1]}, 0.0]" for craft in order)
    fault = "vehicle = { speed_error_relative = 0.05 }"
    tables = "\n".join(f"[craft.{names[craft]}]\n{fault if craft == 'auv1' else ''}" for craft in order)
    return loads(f"""
seed = {seed}
duration_s = 240
[team]
estimator = "{estimator}"
gain_mps = 8.0
[mission]
type = "lawnmower"
legs = 2
leg_length_m = 100.0
[mission.formation_m]
{formation}
[link]
loss = {loss}
[link.mac]
type = "tdma"
slots = [{slots}]
{tables}
""")


def tracks(made, monkeypatch):
    """True positions of each craft: name to array of (ticks, 2)."""
    books = []
    keep = Logbook.close
    monkeypatch.setattr(Logbook, "close", lambda book: (books.append(book), keep(book)))
    simulate_in_process(made, None, lambda _: None)
    positions = books[-1].positions
    return {craft: positions[:, place] for place, craft in enumerate(made.craft)}


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_other_names(estimator, monkeypatch):
    """When craft swap their names, their tracks swap with them."""
    same = {craft: craft for craft in PLACES}
    other = {"auv1": "auv3", "auv2": "auv1", "auv3": "auv2"}
    one = tracks(scenario(estimator, list(PLACES), same), monkeypatch)
    two = tracks(scenario(estimator, list(PLACES), other), monkeypatch)
    assert np.ptp(one["auv1"][:, 0] - one["auv2"][:, 0]) > 0.1
    for craft in PLACES:
        np.testing.assert_allclose(two[other[craft]], one[craft], atol=1e-9)


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_another_order(estimator, monkeypatch):
    """When the team stands in another order in the file, everybody goes the same way, with the same messages lost."""
    same = {craft: craft for craft in PLACES}
    one = tracks(scenario(estimator, list(PLACES), same, 3, 0.4), monkeypatch)
    two = tracks(scenario(estimator, ["auv3", "auv1", "auv2"], same, 3, 0.4), monkeypatch)
    for craft in PLACES:
        np.testing.assert_allclose(two[craft], one[craft], atol=1e-9)
