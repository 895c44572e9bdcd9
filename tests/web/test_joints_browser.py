"""Joints and motions in a browser: what a hand on the page moves, what is asked before the robot falls, what is red."""

import shutil
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from tests.support import needs

needs.modules("playwright")

from playwright.sync_api import Browser, Page, expect, sync_playwright  # noqa: E402

from tests.web.jointed_robot import JointedRobot, jointed_robot  # noqa: E402

pytestmark = [needs.program("chromium", "chromium"), pytest.mark.timeout(60)]
PHONE = {"viewport": {"width": 390, "height": 844}, "has_touch": True, "is_mobile": True}
DESK = {"viewport": {"width": 1280, "height": 900}}
READY = '.joints-stage[data-ready="true"]'
WHERE = "joint => document.querySelector('canvas').stage.whereIs(joint)"
NO_WEBGL = "HTMLCanvasElement.prototype.getContext = () => null"
SOFT = ["--no-sandbox", "--enable-unsafe-swiftshader"]
LONG_MS = 20_000


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with sync_playwright() as started:
        found = started.chromium.launch(executable_path=shutil.which("chromium"), args=SOFT)
        yield found
        found.close()


@pytest.fixture(scope="module")
def served() -> Iterator[tuple[JointedRobot, str]]:
    with jointed_robot("bioloid") as found:
        yield found


@pytest.fixture
def robot(served) -> JointedRobot:
    found: JointedRobot = served[0]
    found.halt()
    found.asked.clear()
    found.held.clear()
    found.broken.clear()
    found.torque |= dict.fromkeys(found.torque, 0.9)
    found.angles |= dict.fromkeys(found.angles, 0.0)
    found.goals = dict(found.angles)
    return found


@pytest.fixture
def opened(browser, served, robot) -> Iterator[Callable[..., Page]]:
    errors: list[str] = []
    contexts: list[Any] = []

    def page(view: str, size: dict[str, Any], script: str = "") -> Page:
        context = browser.new_context(**size, locale="en-GB")
        contexts.append(context)
        found = context.new_page()
        found.on("pageerror", lambda err: errors.append(str(err)))
        if script:
            found.add_init_script(script)
        found.goto(f"{served[1]}/#{view}")
        if view == "joints" and not script:
            expect(found.locator(READY)).to_be_visible(timeout=LONG_MS)
        return found

    yield page
    for context in contexts:
        context.close()
    assert errors == []


def until_true(page: Page, true: Callable[[], Any], s: float = 15.0) -> bool:
    """Say whether something comes true while the page goes on."""
    end = time.monotonic() + s
    while time.monotonic() < end:
        if true():
            return True
        page.wait_for_timeout(30)
    return bool(true())


def drag(page: Page, joint: str, right: float, down: float) -> None:
    """Take hold of a limb on the drawing and pull it aside, in pixels."""
    box = page.locator("canvas").bounding_box()
    assert box is not None
    x, y = page.evaluate(WHERE, joint)
    page.mouse.move(box["x"] + x, box["y"] + y)
    page.mouse.down()
    for step in (0.25, 0.5, 0.75, 1.0):
        page.mouse.move(box["x"] + x + step * right, box["y"] + y + step * down)
    page.wait_for_timeout(200)
    page.mouse.up()


def positions(robot: JointedRobot) -> list[dict[str, float]]:
    return [hold["message"]["positions"] for hold in robot.held if hold["to"] == "joints/command"]


def test_a_dragged_limb_moves_its_joint_until_it_is_there(opened, robot):
    page = opened("joints", DESK)
    drag(page, "left_elbow", 60, -10)
    assert until_true(page, lambda: positions(robot))
    assert {name for one in positions(robot) for name in one} == {"left_elbow"}
    goal = positions(robot)[-1]["left_elbow"]
    assert abs(goal) > 0.05
    assert until_true(page, lambda: abs(robot.angles["left_elbow"] - goal) < 0.03 and robot.holder is None)


def test_a_limb_that_is_only_tapped_is_chosen_and_moves_nothing(opened, robot):
    page = opened("joints", PHONE)
    box, (x, y) = page.locator("canvas").bounding_box(), page.evaluate(WHERE, "left_knee")
    page.mouse.click(box["x"] + x, box["y"] + y)
    expect(page.locator('.joints-row[data-joint="left_knee"] .joints-details')).to_be_visible()
    drag(page, "left_knee", 0, -60)
    page.wait_for_timeout(300)
    assert robot.held == []


def test_a_slider_sends_a_joint_to_its_goal_where_it_is_green(opened, robot):
    page = opened("joints", DESK)
    row = page.locator('.joints-row[data-joint="right_knee"]')
    row.locator("input[type=range]").fill("-0.6")
    assert until_true(page, lambda: positions(robot))
    assert positions(robot)[-1]["right_knee"] == pytest.approx(-0.6, abs=0.01)
    assert until_true(page, lambda: abs(robot.angles["right_knee"] + 0.6) < 0.03)
    expect(row).to_have_attribute("data-tone", "near")
    assert until_true(page, lambda: robot.holder is None)


def test_a_number_is_sent_within_the_limits_and_not_beyond(opened, robot):
    page = opened("joints", DESK)
    number = page.locator('.joints-row[data-joint="right_elbow"] .joints-number')
    number.fill("900")
    expect(number).to_have_attribute("aria-invalid", "true")
    number.press("Enter")
    page.wait_for_timeout(200)
    assert robot.held == []
    number.fill("-30")
    number.press("Enter")
    assert until_true(page, lambda: positions(robot))
    assert positions(robot)[-1]["right_elbow"] == pytest.approx(-0.5236, abs=1e-3)


def test_a_slider_under_a_finger_does_not_heed_what_was_measured(opened, robot):
    page = opened("joints", DESK)
    slider = page.locator('.joints-row[data-joint="right_knee"] input[type=range]')
    slider.scroll_into_view_if_needed()
    box = slider.bounding_box()
    page.mouse.move(box["x"] + box["width"] * 0.94, box["y"] + box["height"] / 2)
    page.mouse.down()
    page.mouse.move(box["x"] + box["width"] * 0.5, box["y"] + box["height"] / 2, steps=3)
    held = float(slider.input_value())
    page.wait_for_timeout(400)
    assert float(slider.input_value()) == held
    page.mouse.up()


def test_releasing_all_is_asked_before_and_one_side_is_not(opened, robot):
    page = opened("joints", DESK)
    page.get_by_role("button", name="Release all").click()
    dialog = page.get_by_role("dialog")
    expect(dialog).to_contain_text("falls")
    dialog.get_by_role("button", name="Cancel").click()
    assert robot.asked == []
    page.get_by_role("button", name="Release: Left").click()
    assert until_true(page, lambda: robot.asked)
    what, given = robot.asked.pop()
    assert (what, given["on"], len(given["joints"])) == ("joints/torque", False, 9)
    page.get_by_role("button", name="Release all").click()
    page.get_by_role("dialog").get_by_role("button", name="Release all").click()
    assert until_true(page, lambda: robot.asked)
    assert robot.asked[-1] == ("joints/torque", {"on": False, "confirmed": True})
    expect(page.locator('.joints-row[data-tone="limp"]')).to_have_count(18)


def test_an_overload_is_said_in_words_and_can_be_recovered(opened, robot):
    robot.broken["left_knee"] = "overload"
    page = opened("joints", PHONE)
    row = page.locator('.joints-row[data-joint="left_knee"]')
    expect(row).to_have_attribute("data-tone", "fault")
    row.locator(".joints-name").click()
    expect(row.locator(".joints-fault")).to_contain_text("overload")
    row.get_by_role("button", name="Recover").click()
    expect(row).not_to_have_attribute("data-tone", "fault")


def test_without_webgl_the_body_is_drawn_flat(opened, robot):
    page = opened("joints", DESK, NO_WEBGL)
    limb = page.locator(".joints-flat polygon").last
    expect(limb).to_be_attached(timeout=LONG_MS)
    page.locator(".joints-flat polygon").first.dispatch_event("click")
    expect(page.locator(".joints-details")).to_be_visible()


def test_a_motion_is_played_and_ended(opened, robot):
    page = opened("motions", PHONE)
    page.get_by_role("button", name="Play wave", exact=True).click()
    assert until_true(page, lambda: robot.held)
    assert robot.held[-1]["to"] == "motions/play"
    assert robot.held[-1]["message"] == {"motion": "wave", "times": 1, "speed": 1, "mirror": False}
    expect(page.locator(".motions-playing")).to_contain_text("wave")
    page.get_by_role("button", name="End it").click()
    assert until_true(page, lambda: not robot.playing)


def test_a_motion_that_is_being_built_moves_the_drawing_alone(opened, robot):
    page = opened("motions", DESK)
    page.get_by_role("radio", name="Build").click()
    expect(page.locator(READY)).to_be_visible(timeout=LONG_MS)
    page.get_by_role("button", name="Add a pose").click()
    page.get_by_role("button", name="Add a pose").click()
    drag(page, "left_elbow", 60, -10)
    assert robot.held == []
    page.get_by_role("button", name="Play on the robot").click()
    assert until_true(page, lambda: robot.held)
    frames = robot.held[-1]["message"]["frames"]
    assert len(frames) == 2
    assert frames[0]["positions"]["left_elbow"] == 0.0
    assert abs(frames[1]["positions"]["left_elbow"]) > 0.05
