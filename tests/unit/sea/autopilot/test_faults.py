"""Behaviour 13: what goes wrong on a link, to order."""

import pytest
from autopilots import ARM, SET_MODE, Bench

from grex_link.errors import ConfigError
from grex_sim.autopilot.faults import parse
from grex_sim.autopilot.message import Message


def faulty(*script: str, **more) -> Bench:
    return Bench(faults=tuple(parse(text) for text in script), **more)


def test_silence():
    """silence@5:10: nothing is said or heard from 5 to 15 s, then all goes on."""
    bench = faulty("silence@5:10").run(5.0)
    since = bench.now
    bench.run(10.0)
    bench.send("COMMAND_LONG", command=SET_MODE, target_system=1, param1=1.0, param2=4.0)
    bench.run(14.9)
    assert [t for t, _, _ in bench.heard if t > since + 0.1] == []
    bench.run(17.0)
    assert bench.shown == 0


def test_silence_by_parameter():
    """GREX_SILENCE = 3 is three seconds of silence."""
    bench = Bench().run(3.0)
    bench.set_parameter("GREX_SILENCE", 3.0)
    since = bench.now
    assert [t for t, _, _ in bench.run(since + 2.9).heard if t > since + 0.05] == []
    assert bench.run(since + 4.5).said("HEARTBEAT", since + 2.9)


def test_deafness():
    """deaf@5:5: it goes on talking and obeys nothing."""
    bench = faulty("deaf@5:5").run(6.0)
    assert bench.command(SET_MODE, 1, 4) is None
    assert bench.run(9.0).said("HEARTBEAT", 6.0)
    assert bench.run(11.0).command(SET_MODE, 1, 4) == 0


def test_loss():
    """loss@0=0.3 loses about three of ten messages each way."""
    bench = faulty("loss@0=0.3").run(3.0)
    since = bench.now
    bench.run(103.0)
    assert 55 <= len(bench.said("HEARTBEAT", since)) <= 85
    answered = 0
    for _ in range(100):
        answered += bench.command(SET_MODE, 1, 4) is not None
    assert 35 <= answered <= 63, "about half come through both ways"


def test_duplicates():
    """duplicate@0=1 sends everything twice."""
    once, twice = Bench().run(10.0), faulty("duplicate@0=1").run(10.0)
    assert len(twice.heard) == 2 * len(once.heard)


def test_garbage():
    """garbage@3:2=10 puts ten pieces of random bytes a second on the link for two seconds."""
    bench = faulty("garbage@3:2=10").run(3.0)
    bench.run(6.0)
    pieces = [m for t, _, m in bench.heard if t > 3.0 and isinstance(m, bytes)]
    assert 18 <= len(pieces) <= 22
    assert len(set(pieces)) == len(pieces)


def test_late_acks():
    """late@3:10=5: an ACK takes five seconds more; what was asked for is done at once."""
    bench = faulty("late@3:10=5").run(4.0)
    assert bench.command(SET_MODE, 1, 4, wait=4.9) is None
    assert bench.shown == 4
    assert bench.run(9.2).said("COMMAND_ACK")


def test_refused_arming():
    """refuse@0:10: arming fails with a reason until 10 s."""
    bench = faulty("refuse@0:10").run(5.0)
    assert bench.command(ARM, 1) == 4
    assert "Arm: Logging failed" in bench.texts()
    assert bench.run(10.1).command(ARM, 1) == 0


@pytest.mark.parametrize(("script", "mode"), [("pilot@12=HOLD", 4), ("pilot@12=0", 0), ("pilot@12", 4)])
def test_a_pilot_takes_over(script, mode):
    """pilot@12=HOLD: the mode changes without a command, and set-points are in vain."""
    bench = faulty(script).guided().drive(15.0, 1.0, 0.0)
    assert bench.shown == mode
    assert bench.speed < 0.2


def test_a_pilot_by_parameter():
    """GREX_PILOT = 4 is a pilot who takes over into mode 4; -1 is none."""
    bench = Bench().guided()
    bench.set_parameter("GREX_PILOT", -1.0)
    assert bench.run(bench.now + 1.1).shown == 15
    bench.set_parameter("GREX_PILOT", 4.0)
    assert bench.run(bench.now + 1.1).shown == 4


def test_power_loss_under_way():
    """reboot@12 restarts an armed craft: disarmed, at the place where it was, counting from zero."""
    bench = faulty("reboot@12").guided().drive(8.0, 2.0, 0.0)
    bench.run(20.0)
    assert (bench.shown, bench.armed) == (0, False)
    assert bench.truth.north_m > 10.0
    assert bench.last("SYSTEM_TIME")["time_boot_ms"] < 8100


def test_a_jump_of_the_date():
    """jump@5:5=3600 puts the date an hour ahead for five seconds; the time since boot goes on."""
    bench = faulty("jump@5:5=3600", epoch_unix_s=1e9).run(8.0)
    assert bench.last("SYSTEM_TIME")["time_unix_usec"] == pytest.approx((1e9 + 3607) * 1e6, abs=1e6)
    bench.run(12.0)
    assert bench.last("SYSTEM_TIME")["time_unix_usec"] == pytest.approx((1e9 + 11) * 1e6, abs=1e6)
    assert 10_500 < bench.last("SYSTEM_TIME")["time_boot_ms"] < 12_000


def test_satellites_by_script():
    """gps@10:30 is the same as SIM_GPS_DISABLE."""
    bench = faulty("gps@10:30").guided().drive(20.0, 1.0, 0.0)
    assert bench.shown == 4
    assert "EKF failsafe" in bench.texts()


def test_disarmed_by_chance():
    """disarm@12: it is disarmed, without a word."""
    bench = faulty("disarm@12").guided().drive(10.0, 1.0, 0.0)
    assert not bench.armed


def test_two_craft_with_one_id_give_two_acks():
    """Two vehicles with one system id both answer."""
    both = [Bench(seed=1).run(3.0), Bench(seed=2).run(3.0)]
    assert [bench.command(SET_MODE, 1, 4) for bench in both] == [0, 0]


def test_long_texts_come_in_pieces():
    """A text of 120 characters is three messages with one id, numbered from 0; a short one has id 0."""
    bench = Bench().run(3.0)
    bench.pilot.brain.text("x" * 120, 3.0)
    pieces = bench.run(3.1).said("STATUSTEXT", 3.0)
    assert [(m["chunk_seq"], len(m["text"])) for m in pieces] == [(0, 50), (1, 50), (2, 20)]
    assert len({m["id"] for m in pieces}) == 1
    assert pieces[0]["id"] > 0


@pytest.mark.parametrize("text", ["storm@3", "loss", "loss@x", "loss@1:2=much", "silence@1.2.3", "pilot@=HOLD"])
def test_a_script_that_cannot_be_read(text):
    """A fault that cannot be read is one line with the form to write."""
    with pytest.raises(ConfigError, match="--fault"):
        parse(text)


def test_the_same_seed_gives_the_same_autopilot():
    """Two autopilots with one seed say the same, with loss and noise; another seed says something else."""

    def said(seed):
        bench = faulty("loss@0=0.3", "garbage@1:5", seed=seed, noise_m=0.5).run(8.0)
        return [(t, str(m)) for t, _, m in bench.heard]

    assert said(3) == said(3) != said(4)


def test_nothing_breaks_it():
    """Messages it does not know, from itself or with odd values, are passed over."""
    bench = Bench().run(3.0)
    bench.send("DEBUG", value=1.0)
    bench.pilot.heard(Message("HEARTBEAT", {"type": 6}, 1, 1), 0, bench.now)
    assert bench.command(SET_MODE, 1, 4) == 0
