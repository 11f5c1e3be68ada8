"""Errors of believed positions against a literal truth."""

import math

import numpy as np
import pytest

from grex_link.messages import AgentState, PlaceBelief
from grex_sim.navigation_errors import BelievedPlaces

TRUTH = np.array([[[0.0, 0.0], [9.0, 9.0]], [[1.0, 0.0], [9.0, 9.0]], [[2.0, 0.0], [9.0, 9.0]]])


def state(tick, *places):
    """A state with nothing in it but positions."""
    return AgentState(tick, tick, 0, 0.0, 0.0, 1.0, 1.0, 0.0, [], [], 0, list(places))


def test_errors_of_one_craft():
    """3 m and 4 m off, with 1 m² and 4 m²: rms, greatest, last, what was claimed, and NEES."""
    places = BelievedPlaces()
    places.note("auv1", state(0))
    places.note("auv1", state(1, PlaceBelief("auv1", 4.0, 0.0, (1.0, 1.0, 0.0))))
    places.note("auv1", state(2, PlaceBelief("auv1", 2.0, 4.0, (4.0, 4.0, 0.0))))
    errors = places.errors(TRUTH, ["auv1", "auv2"])
    assert list(errors) == ["auv1"]
    found = errors["auv1"]
    assert (found.steps, found.max_m, found.last_m) == (2, 4.0, 4.0)
    assert found.rms_m == pytest.approx(math.sqrt(12.5))
    assert found.sigma_m == pytest.approx(math.sqrt(5.0))
    assert found.nees == pytest.approx((9.0 + 4.0) / 2.0)


def test_nees_with_correlation():
    """The covariance counts as a whole: an error along its long axis is less of a surprise than across."""
    p = np.array([[2.0, 1.5], [1.5, 2.0]])
    for wrong in ([1.0, 1.0], [1.0, -1.0]):
        places = BelievedPlaces()
        places.note("auv1", state(0, PlaceBelief("auv1", *wrong, (2.0, 2.0, 1.5))))
        expected = np.array(wrong) @ np.linalg.solve(p, wrong)
        assert places.errors(TRUTH, ["auv1", "auv2"])["auv1"].nees == pytest.approx(expected)


def test_what_a_base_believes_has_its_own_name():
    """A base's error is that of the craft it watches."""
    places = BelievedPlaces()
    places.note("base", state(0, PlaceBelief("auv2", 9.0, 10.0, (1.0, 1.0, 0.0))))
    errors = places.errors(TRUTH, ["base", "auv2"])
    assert list(errors) == ["base>auv2"]
    assert errors["base>auv2"].rms_m == pytest.approx(1.0)


def test_no_claim_no_nees():
    """A position without any variance claimed has an error, and no NEES; a tick after the end is left out."""
    places = BelievedPlaces()
    places.note("auv1", state(0, PlaceBelief("auv1", 1.0, 0.0, (0.0, 0.0, 0.0))))
    places.note("auv1", state(7, PlaceBelief("auv1", 1.0, 0.0, (0.0, 0.0, 0.0))))
    found = places.errors(TRUTH, ["auv1", "auv2"])["auv1"]
    assert found.steps == 1
    assert found.nees is None
