"""Three boats at once, each of another family: behind one router, and each on a port of its own."""

import json
import re
from contextlib import ExitStack

import pytest
from frontseat_runs import HEAD, autopilot, fixes, free_port
from launching import running
from mavlink_router import router

#: Minutes of wall time: `pytest -m slow tests/processes`.
pytestmark = pytest.mark.slow

FAMILIES = {"auv1": "rover", "auv2": "px4", "auv3": "sub"}
EAST_M = {"auv1": 0.0, "auv2": 20.0, "auv3": 40.0}
PACE = 3.0


@pytest.fixture(scope="module", params=["one router", "a port each"])
def flown(request, tmp_path_factory):
    """A run of three autopilots, and what came of it."""
    folder = tmp_path_factory.mktemp("team")
    text = HEAD.format(duration_s=100, pace=PACE)
    text += "".join(f"{craft} = [0, {east}, 0]\n" for craft, east in EAST_M.items())
    with ExitStack() as stack:
        shared = stack.enter_context(router()) if request.param == "one router" else None
        for number, (craft, family) in enumerate(FAMILIES.items()):
            port = shared or free_port()
            kind = "udpout" if shared else "udpin"
            options = ["--family", family, "--sysid", str(number + 1), "--ready", "4", "--speedup", f"{PACE:g}"]
            url, log = f"udpout:127.0.0.1:{port}", folder / f"{craft}.log"
            stack.enter_context(autopilot(url, log, *options, start=(0.0, EAST_M[craft])))
            text += f'[craft.{craft}.frontseat]\ntype = "mavlink"\nurl = "{kind}:127.0.0.1:{port}"\narm = true\n'
            text += f"system = {number + 1}\nown_component = {191 + number}\n"
        (folder / "team.toml").write_text(text)
        out = folder / "run"
        launcher = stack.enter_context(running("run", str(folder / "team.toml"), "--json", "--out", str(out)))
        printed, err = launcher.communicate(timeout=150)
    assert (launcher.returncode, err) == (0, "")
    assert json.loads(printed)["complete"]
    return folder


@pytest.mark.parametrize("craft", FAMILIES)
def test_speed_and_track(flown, craft: str):
    """Each of three boats at once holds 1 m/s within 0.2 m/s in any five seconds, and its line within 3 m."""
    found = [fix for fix in fixes(flown / "run", craft) if fix.valid and fix.tick >= 40]
    assert len(found) >= 50
    assert all(abs(fix.east_m - EAST_M[craft]) < 3.0 for fix in found)
    later = zip(found, found[5:], strict=False)
    made_good = [(then.north_m - fix.north_m) / (then.tick - fix.tick) for fix, then in later]
    assert made_good == pytest.approx([1.0] * len(made_good), abs=0.2)


@pytest.mark.parametrize(("craft", "mode"), [("auv1", "HOLD"), ("auv2", "AUTO.LOITER"), ("auv3", "POSHOLD")])
def test_each_is_handed_back(flown, craft: str, mode: str):
    """At the end each holds, and its own adapter alone has changed its modes."""
    said = (flown / "run" / f"frontseat-{craft}.log").read_text()
    assert f"the craft is with its autopilot, in {mode}, armed" in said
    number = list(FAMILIES).index(craft)
    changed = re.findall(r" by (\d+/\d+)$", (flown / f"{craft}.log").read_text(), re.MULTILINE)
    assert set(changed) == {f"255/{191 + number}"}
