"""A tilted phone that steers the base, and what stops it."""

from collections.abc import Iterator

import pytest

from tests.support import browsers, needs
from tests.support.browsers import within

needs.modules("playwright")

from playwright.sync_api import Browser, Page, expect, sync_playwright  # noqa: E402

from tests.apps.web.test_page_browser import HIDE, opened, robot, served, stands  # noqa: E402
from tests.apps.web.test_page_drive import newest, shown  # noqa: E402

__all__ = ["opened", "robot", "served"]
pytestmark = [needs.program("chromium", "chromium")]
TILT = """([beta, gamma]) => window.dispatchEvent(new DeviceOrientationEvent("deviceorientation", {alpha: 0, beta, gamma}))"""
TILTING = """([from, to]) => {
  const tell = ([beta, gamma]) => window.dispatchEvent(new DeviceOrientationEvent("deviceorientation", {alpha: 0, beta, gamma}));
  tell(from);
  window.tilting = setInterval(() => tell(to), 30);
}"""
STILL = "clearInterval(window.tilting)"
LYING, AHEAD, RIGHT = [20, 0], [2, 0], [20, 18]


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    """Chromium as it is: the one without windows tells a page of no tilt."""
    with sync_playwright() as started:
        found = browsers.start_windowed(started)
        yield found
        found.close()


@pytest.fixture
def tilted(opened, robot):
    """A phone whose tilt is to steer."""
    page = opened.page("phone")
    shown(page)
    page.get_by_role("switch", name="Tilt to steer").check()
    return page


def hold(page: Page) -> None:
    box = page.locator(".drive-stick").bounding_box()
    assert box is not None
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    page.mouse.down()


def test_a_tilted_phone_drives_while_a_thumb_is_on_the_stick_and_not_a_moment_longer(tilted, robot):
    page = tilted
    page.evaluate(TILTING, [LYING, AHEAD])
    page.wait_for_timeout(150)
    assert not robot.held, "no thumb is on the stick"
    page.evaluate(STILL)
    hold(page)
    page.evaluate(TILTING, [LYING, AHEAD])
    assert within(page, lambda: robot.moves)
    assert newest(robot)[1]["angle_deg"] == 0
    page.mouse.up()
    assert stands(page, robot)
    page.evaluate(STILL)
    hold(page)
    page.evaluate(TILTING, [LYING, RIGHT])
    assert within(page, lambda: robot.moves and newest(robot)[1]["angle_deg"] == 90)
    page.mouse.up()
    assert within(page, lambda: not robot.moves)


@pytest.mark.parametrize("how", ["hide", "close", "silent", "nonsense"])
def test_a_tilted_phone_stops_when_its_page_goes_away_or_its_sensor_falls_silent(opened, tilted, robot, how):
    page, other = tilted, opened.blank()
    hold(page)
    page.evaluate(TILTING, [LYING, AHEAD])
    assert within(page, lambda: robot.moves)
    if how == "close":
        page.close()
        assert stands(other, robot)
        return
    if how == "hide":
        page.evaluate(HIDE)
        assert stands(other, robot)
        page.wait_for_timeout(150)
        assert not robot.moves, "it tilts on, and moves nothing"
    else:
        page.evaluate(STILL)
        if how == "nonsense":
            page.evaluate(TILT, [None, None])
        assert within(page, lambda: not robot.moves)
        assert robot.sockets == 1


def test_tilt_is_off_with_each_page_and_a_phone_held_upright_does_not_jump(tilted, robot):
    page = tilted
    hold(page)
    page.evaluate(TILTING, [[70, 0], [100, 0]])
    assert within(page, lambda: robot.moves and newest(robot)[1]["angle_deg"] == 180)
    page.mouse.up()
    page.evaluate(STILL)
    page.evaluate("Object.defineProperty(screen.orientation, 'angle', {value: 90, configurable: true})")
    hold(page)
    page.evaluate(TILTING, [[0, -80], [180, 80]])
    assert within(page, lambda: robot.held and newest(robot)[1]["angle_deg"] in {0, 180} and robot.moves)
    assert newest(robot)[1]["power"] <= 0.4
    page.mouse.up()
    page.reload()
    expect(page.get_by_role("switch", name="Tilt to steer")).not_to_be_checked()
