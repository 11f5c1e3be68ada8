"""What the estimators beside the paper's are worth, under the paper's law and messages; see README for 20 seeds."""

import pytest
from missions import fly

SLOW = ("team.gain_mps=8.0", "craft.auv3.vehicle.speed_limits=[{start_s=1000.0, end_s=1400.0, max_mps=0.8}]")


def fd(estimator, *overrides):
    """FD of the paper's mission."""
    return fly("paper-d", f"team.estimator={estimator}", *overrides).fd


@pytest.fixture(scope="module")
def ideal():
    """FD of ideal communication under the paper's conditions."""
    return fd("ideal")


@pytest.mark.parametrize(("estimator", "worst"), [("along_track", 1.01), ("along_track_first", 1.01),
                                                  ("biased_planar", 1.02), ("dead_reckoning", 1.02)])  # fmt: skip
def test_nearly_as_good_as_ideal(estimator, worst, ideal):
    """A filter that learns the speed error loses next to nothing against perfect communication."""
    assert fd(estimator) / ideal < worst


def test_half_of_the_messages(ideal):
    """With half of the messages lost the along-track filter is within 2 % of ideal communication."""
    figures = [fd("along_track", "link.loss=0.5", f"seed={seed}") for seed in (1, 2, 3)]
    assert sum(figures) / 3.0 / ideal < 1.02


def test_a_mate_that_cannot_keep_up():
    """At K = 8 a mate that is slow for 400 s is followed by the along-track filter, and not by the paper's."""
    ideal = fd("ideal", *SLOW)
    assert fd("along_track", *SLOW) / ideal < 1.15
    assert fd("second_level", *SLOW) / ideal > 3.0


def test_holding_the_last_fix_is_no_method(ideal):
    """The last position heard is far worse than any model."""
    assert fd("hold_last") / ideal > 1.5


def test_the_own_filter_helps_with_noisy_fixes():
    """With 1 m of noise on every fix the filtered position leaves less cross-track error."""
    noisy = [f"craft.{craft}.navigation.white_m=1.0" for craft in ("auv1", "auv2", "auv3")]
    raw, filtered = (fly("paper-d", "team.estimator=along_track", *noisy, *more)
                     for more in ((), ("team.own_filter={}",)))  # fmt: skip
    assert filtered.fd < raw.fd
    assert filtered.fd_xte < raw.fd_xte
