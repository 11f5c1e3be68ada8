"""The page of a recorded run, in a real browser: plan view, slider, playback, keyboard."""

import pytest
from missions import fly
from msgspec.structs import replace
from recordings import recorded_messages
from watching import AUV1, LOST, cell, pixels, viewing

from grex_link.recorder import Recorder
from grex_link.recording import Recording, run_metadata


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A run of ten minutes, half of whose messages are lost."""
    folder = tmp_path_factory.mktemp("recorded")
    fly("paper-d", "duration_s=600", "link.burst={loss=0.5,mean_length_s=60}", out=folder)
    return folder


@pytest.fixture(scope="module")
def address(folder):
    with viewing(str(folder)) as address:
        yield address


def seek(page, seconds):
    """Move the slider, as a hand does, and wait until the figures are those of that time."""
    drawn = page.locator("#slider").evaluate(
        "(slider, to) => { slider.value = to; slider.dispatchEvent(new Event('input')); return grexPage.drawn; }",
        seconds,
    )
    shown = f"{seconds // 60}:{seconds % 60:02d}"
    page.wait_for_function(
        "([shown, drawn]) => document.getElementById('time').textContent === shown && grexPage.drawn > drawn",
        arg=[shown, drawn],
    )


def test_the_slider_moves_the_plan_view(address, folder, open_page):
    """Where the slider stands, table and plan view show the recorded places of that moment."""
    page = open_page(address)
    page.locator("#whole").click()
    seek(page, 0)
    _, _, low = pixels(page, AUV1)
    truths = {truth.t_ns // 10**9: truth for truth in recorded_messages(folder, "truth")}
    for time_s in (100, 300):
        seek(page, time_s)
        for pose in truths[time_s].poses:
            assert cell(page, pose.craft, 0) == pytest.approx(pose.north_m, abs=0.06)
            assert cell(page, pose.craft, 1) == pytest.approx(pose.east_m, abs=0.06)
    count, _, high = pixels(page, AUV1)
    assert count > 40
    assert high < low - 20  # it has gone north, which is up
    seek(page, 0)
    assert cell(page, "auv1", 0) == 0.0


def test_a_message_is_drawn_and_dies_with_its_cause(address, folder, open_page):
    """A lost message is on its way first, then a red cross and its cause are at the receiver; later it is gone."""
    lost = next(event for event in recorded_messages(folder, "link_event") if event.kind == "lost")
    end_s = lost.t_ns // 10**9
    page = open_page(address)
    seek(page, end_s - 4)
    assert pixels(page, LOST)[0] == 0
    assert page.locator("#messages li").first.inner_text().endswith("on the air …")
    assert page.locator("#speaker").inner_text() == f"{lost.source} speaking"
    seek(page, end_s + 1)
    assert pixels(page, LOST)[0] > 20
    row = page.locator("#messages li", has_text=f"✕ {lost.destination}: burst")
    assert lost.source in row.inner_text()
    seek(page, end_s + 8)
    assert pixels(page, LOST)[0] == 0


def test_it_plays_pauses_and_keeps_to_its_speed(address, open_page):
    """Play runs at the chosen speed, pause holds, and all of it goes without a mouse."""
    page = open_page(address)
    page.locator("#pace").select_option("50")
    page.locator("#play").focus()
    page.keyboard.press("Enter")
    page.wait_for_function("() => document.getElementById('slider').value > 100")
    page.keyboard.press("Enter")
    assert page.locator("#play").inner_text() == "Play"
    held = float(page.locator("#slider").input_value())
    drawn = page.evaluate("grexPage.drawn")
    page.wait_for_timeout(300)
    assert float(page.locator("#slider").input_value()) == held
    assert page.evaluate("grexPage.drawn") <= drawn + 1
    page.locator("#slider").focus()
    page.keyboard.press("Home")
    page.wait_for_function("() => document.getElementById('time').textContent === '0:00'")
    page.locator("body").press(" ")
    assert page.locator("#play").inner_text() == "Pause"


def test_the_plan_view_is_moved_with_keys(address, open_page):
    """Arrows, plus, minus, 0 and T move the plan view; what can be reached can be seen to have the focus."""
    page = open_page(address)
    page.locator("#plan").focus()
    page.keyboard.press("ArrowUp")
    assert page.locator("#team").get_attribute("aria-pressed") == "false"
    scale = page.evaluate("grexPage.plan.camera.scale")
    page.keyboard.press("+")
    assert page.evaluate("grexPage.plan.camera.scale") > scale
    page.keyboard.press("0")
    assert page.locator("#whole").get_attribute("aria-pressed") == "true"
    page.keyboard.press("t")
    assert page.locator("#team").get_attribute("aria-pressed") == "true"
    reached = set()
    for _ in range(25):
        page.keyboard.press("Tab")
        reached.add(page.evaluate("document.activeElement.id || document.activeElement.tagName"))
    assert {"play", "slider", "pace", "observer", "team", "whole", "closer", "farther", "plan", "messages"} <= reached


@pytest.mark.parametrize(("width", "height"), [(1440, 900), (1024, 768), (390, 844)])
def test_it_fits(address, open_page, width, height):
    """On a desk, on a small screen and on a phone nothing is wider than the screen, and every part is there."""
    page = open_page(address, width, height)
    page.wait_for_function("() => document.querySelectorAll('.plot canvas').length === 4")
    assert page.evaluate("document.documentElement.scrollWidth") == width
    for part in ("plan", "craft", "messages", "wheel", "health"):
        box = page.locator(f"#{part}").bounding_box()
        assert box["width"] > 100
        assert box["height"] > 60


def test_what_is_no_number_is_a_gap(tmp_path, folder, open_page):
    """NaN in the data, which JSON writes as null, is a dash and a gap; everything else goes on."""
    recorder = Recorder(tmp_path / "run.mcap", run_metadata(Recording(folder).scenario))
    for truth in recorded_messages(folder, "truth"):
        first, *others = truth.poses
        nowhere = replace(truth, poses=[replace(first, north_m=float("nan")), *others])
        recorder.write("truth", "", truth.t_ns, nowhere if 100 <= truth.tick < 200 else truth)
    recorder.close()
    with viewing(str(tmp_path)) as address:
        page = open_page(address)
        seek(page, 150)
        assert page.locator("#craft tr[data-name=auv1] td").nth(0).inner_text() == "–"
        assert page.locator("#fd").inner_text() == "–"
        assert cell(page, "auv2", 0) > 100.0
        seek(page, 300)
        assert cell(page, "auv1", 0) > 200.0
