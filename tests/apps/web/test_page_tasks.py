"""What people do on the page, on a phone and at a desk: each finds what it needs by the names that a screen reader reads.

The robots are shared by all, and a page by all that suit its robot and size; `axe` looks at every view there.
"""

import re
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

from tests.support import browsers, needs
from tests.support.browsers import within

needs.modules("playwright")

from playwright.sync_api import Browser, Locator, Page, expect  # noqa: E402

from tests.apps.web.jointed_robot import JointedRobot  # noqa: E402
from tests.apps.web.page_robot import page_robot  # noqa: E402

pytestmark = [needs.program("chromium", "chromium")]
needs_mujoco = pytest.mark.skipif(
    find_spec("mujoco") is None and not needs.IN_CI, reason="mujoco is not installed here"
)
SIZES: dict[str, dict[str, Any]] = {
    "phone": {"viewport": {"width": 390, "height": 844}, "has_touch": True, "is_mobile": True},
    "desk": {"viewport": {"width": 1280, "height": 900}},
}
LONG_MS = 20_000
VIEWS = {
    "lbr": ["drive", "system"],
    "bioloid": ["joints", "motions", "system"],
    "uxa90": ["joints", "motions", "system"],
}
AXE = (Path(__file__).parent / "axe/axe.min.js").read_text()
FOUND = """async () => {
  await new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
  await Promise.allSettled(document.getAnimations().map((one) => one.finished));
  return (await axe.run(document, {resultTypes: ["violations"]})).violations
  .filter((one) => ["moderate", "serious", "critical"].includes(one.impact))
  .flatMap((one) => one.nodes.map((node) => `${one.id}: ${node.target.join(" ")}: ${node.failureSummary}`)); }"""
SEEN_FOCUS = """async () => {
  await new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
  await Promise.allSettled(document.getAnimations().map((one) => one.finished));
  const one = document.activeElement;
  if (!one || one === document.body) return ["", true];
  const rings = (shown) => (shown.outlineStyle !== "none" && parseFloat(shown.outlineWidth) > 0) || shown.boxShadow !== "none";
  const line = one.parentElement?.parentElement ?? one;  // a field shows it around its unit, too; a part's name around its line
  const ring = [one, one.parentElement, line].some((place) => rings(getComputedStyle(place)));
  return [one.getAttribute("aria-label") || one.textContent.trim() || one.id, ring || one.id === "main"];
}"""


class House:
    """Three robots, a browser, and the page that is open."""

    def __init__(self, browser: Browser) -> None:
        self.browser = browser
        self.robots: dict[str, tuple[Any, str]] = {}
        self.errors: list[str] = []
        self._until_end = ExitStack()
        self._open: tuple[str, str] | None = None
        self._page: Page | None = None

    def served(self, name: str) -> tuple[Any, str]:
        """Return a robot and its address; it is there until the end."""
        if name not in self.robots:
            served = page_robot(None if name == "lbr" else JointedRobot(name))
            self.robots[name] = self._until_end.enter_context(served)
        return self.robots[name]

    def own_page(self, name: str, size: str, path: str = "/#system", at: str = "127.0.0.1", **more: Any) -> Page:
        """Return a page in a browser of its own, which nothing has remembered; `at` a name of the robot."""
        context = self.browser.new_context(
            **(SIZES[size] | {"locale": "en-GB", "service_workers": "block", "reduced_motion": "reduce"} | more)
        )
        page = context.new_page()
        page.on("pageerror", lambda err: self.errors.append(str(err)))
        page.goto(self.served(name)[1].replace("127.0.0.1", at) + path)
        return page

    def page(self, name: str, size: str, view: str) -> Page:
        """Return the page of a robot at a view, loaded once for all tests in a row that want it."""
        if self._open != (name, size) or self._page is None:
            self.leave()
            self._open, self._page = (name, size), self.own_page(name, size, f"/#{view}")
        self._page.evaluate("view => { location.hash = view }", view)
        expect(self._page.locator(f'main[data-view="{view}"]')).to_be_visible(timeout=LONG_MS)
        expect(self._page.get_by_text("Connected", exact=True).first).to_be_attached(timeout=LONG_MS)
        return self._page

    def leave(self) -> None:
        """Close the page."""
        if self._page is not None:
            self._page.context.close()
        self._open = self._page = None

    def close(self) -> None:
        self.leave()
        self._until_end.close()


@pytest.fixture(scope="module")
def house(browser) -> Iterator[House]:
    found = House(browser)
    yield found
    found.close()


@pytest.fixture(scope="module", params=list(SIZES))
def size(request) -> str:
    return str(request.param)


@pytest.fixture
def at(house, size) -> Iterator[Callable[..., tuple[Page, Any]]]:
    def go(name: str, view: str) -> tuple[Page, Any]:
        robot = house.served(name)[0]
        robot.asked.clear()
        robot.held.clear()
        return house.page(name, size, view), robot

    yield go
    for robot, _ in house.robots.values():
        robot.refusal, robot.estop = None, ""
        robot.stop("the test is over")
    errors, house.errors = house.errors, []
    assert errors == []


def press(page: Page, name: str | re.Pattern[str], **more: Any) -> None:
    page.get_by_role("button", name=name, **more).first.click()


def asked(page: Page) -> Locator:
    return page.get_by_role("dialog")


# on wheels


def test_pair_by_the_link_of_the_code(house, size):
    page = house.own_page("lbr", size, "/#pair=123456", browsers.ELSEWHERE)
    expect(page.get_by_role("application")).to_be_visible(timeout=LONG_MS)
    assert "123456" not in page.url
    page.context.close()


def test_find_the_part_that_is_not_well(at):
    page, _ = at("lbr", "system")
    expect(page.get_by_text("no loudspeaker").first).to_be_visible(timeout=LONG_MS)


def test_read_what_happened_to_a_part(at):
    page, _ = at("lbr", "system")
    page.get_by_role("radio", name="Events").click()
    events = page.locator(".system-events li")
    for text in ("drive is ready", "no loudspeaker", "crashed an hour ago"):
        expect(events.filter(has_text=text)).to_have_count(1)
    page.get_by_label("Part").select_option("motors")
    expect(events).to_have_text(re.compile("crashed an hour ago"))
    page.get_by_role("radio", name="Parts").click()


def test_restart_a_part(at):
    page, robot = at("lbr", "system")
    page.get_by_role("button", name="drive", exact=True).click()
    press(page, "Restart: drive")
    asked(page).get_by_role("button", name="Restart").click()
    assert within(page, lambda: ("console", {"line": "/restart/drive"}) in robot.asked)


def test_save_the_numbers_of_a_chart(at):
    page, _ = at("lbr", "system")
    page.get_by_role("radio", name="Chart").click()
    page.get_by_label("Stream").select_option("attitude/state")
    expect(page.get_by_role("button", name="heading deg")).to_be_visible()
    with page.expect_download() as kept:
        press(page, "Export CSV")
    assert kept.value.suggested_filename == "attitude-state.csv"
    page.get_by_role("radio", name="Parts").click()


def test_have_the_page_speak_german_in_a_light_room(house, size, at):
    at("lbr", "system")
    page = house.own_page("lbr", size)
    press(page, "Settings")
    page.get_by_role("radio", name="Light").click()
    page.get_by_role("radio", name="Deutsch").click()
    expect(page.get_by_role("link", name="Fahren")).to_be_visible()
    page.reload()
    expect(page.get_by_role("link", name="Fahren")).to_be_visible()
    assert page.evaluate("[document.documentElement.lang, document.documentElement.dataset.theme]") == ["de", "light"]
    page.context.close()


# humanoids


@needs_mujoco
def test_build_a_bow_and_have_it_played(at):
    page, robot = at("bioloid", "motions")
    page.get_by_role("radio", name="Build").click()
    press(page, "Add a pose")
    press(page, "Add a pose")
    page.get_by_label("Joint", exact=True).select_option("left_hip_pitch")
    page.get_by_label("Angle in degrees").fill("-5")
    page.keyboard.press("Enter")
    press(page, "Play on the robot")
    assert within(page, lambda: robot.held or asked(page).count())
    if asked(page).count():
        asked(page).get_by_role("button", name="Play it").click()
    assert within(page, lambda: robot.held)
    frames = robot.held[-1]["message"]["frames"]
    assert frames[-1]["positions"]["left_hip_pitch"] == pytest.approx(-0.0873, abs=0.01)
    page.get_by_role("radio", name="Play", exact=True).click()


def test_arm_the_shutdown_guard(at):
    page, robot = at("bioloid", "joints")
    press(page, "Arm", exact=True)
    asked(page).get_by_role("button", name="Arm", exact=True).click()
    assert within(page, lambda: robot.armed)
    press(page, "Disarm")
    assert within(page, lambda: not robot.armed)


def test_have_it_stand_up(at):
    page, robot = at("uxa90", "motions")
    press(page, "Play walking stance", exact=True)
    assert within(page, lambda: robot.held and robot.held[-1]["message"]["motion"] == "basic_motion")


def test_press_a_key_of_the_remote_control(at):
    page, robot = at("uxa90", "motions")
    page.get_by_role("region", name="Remote control").get_by_role("button", name="kick with the right foot").click()
    assert within(page, lambda: robot.held and robot.held[-1]["message"]["motion"] == "kick_right")


# for everybody


@pytest.mark.parametrize("name", VIEWS)
@pytest.mark.parametrize("theme", ["dark", "light"])
def test_axe_finds_nothing_moderate(at, name, theme):
    found = []
    for view in VIEWS[name]:
        page, _ = at(name, view)
        page.emulate_media(color_scheme=theme, reduced_motion="reduce")  # no colour on its way to another
        page.evaluate(AXE)
        found += [f"{view}: {one}" for one in page.evaluate(FOUND)]
        page.emulate_media(color_scheme="dark", reduced_motion="no-preference")
    assert found == []


@pytest.mark.parametrize("name", VIEWS)
def test_no_view_is_wider_than_its_screen(at, name, size):
    """A phone would zoom out, and put the stop aside."""
    for view in VIEWS[name]:
        page, _ = at(name, view)
        assert (view, page.evaluate("innerWidth")) == (view, SIZES[size]["viewport"]["width"])


@pytest.mark.parametrize("name", VIEWS)
def test_the_keyboard_reaches_all_shows_where_it_is_and_stops(house, name):
    robot = house.served(name)[0]
    for view in VIEWS[name][:2]:
        page = house.page(name, "desk", view)
        robot.asked.clear()
        page.evaluate("document.activeElement?.blur()")
        seen = []
        for _ in range(14):
            page.keyboard.press("Tab")
            seen.append(page.evaluate(SEEN_FOCUS))
        assert [one for one, ring in seen if not ring] == []
        page.get_by_role("button", name=re.compile("^Stop.* the robot")).focus()
        page.keyboard.press("Escape")
        assert within(page, lambda: ("stop", None) in robot.asked)
