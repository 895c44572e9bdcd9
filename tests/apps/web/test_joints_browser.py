"""Joints and motions in a browser: what a hand on the page moves, what is asked before the robot falls, what is red."""

import json
import re
from collections.abc import Callable, Iterator
from importlib.util import find_spec
from typing import Any

import pytest

from tests.support import needs
from tests.support.browsers import within

needs.modules("playwright")

from playwright.sync_api import Page, expect  # noqa: E402

from tests.apps.web.jointed_robot import JointedRobot  # noqa: E402
from tests.apps.web.page_robot import page_robot  # noqa: E402

pytestmark = [needs.program("chromium", "chromium")]
needs_mujoco = pytest.mark.skipif(
    find_spec("mujoco") is None and not needs.IN_CI, reason="mujoco is not installed here"
)
PHONE = {"viewport": {"width": 390, "height": 844}, "has_touch": True, "is_mobile": True}
DESK = {"viewport": {"width": 1280, "height": 900}}
READY = '.joints-stage[data-ready="true"]'
WHERE = "joint => document.querySelector('canvas').stage.whereIs(joint)"
SOLID = "localStorage.setItem('lbr.solid', 'true')"
"""This browser's user chose three dimensions, which no graphics card draws here."""
FLAT = "localStorage.setItem('lbr.solid', 'false')"
NO_WEBGL = "HTMLCanvasElement.prototype.getContext = () => null"
ARGUMENTS = ("--no-sandbox", "--enable-unsafe-swiftshader")
LONG_MS = 20_000
both = pytest.mark.parametrize("size", [DESK, PHONE], ids=["desk", "phone"])


@pytest.fixture(scope="module")
def served() -> Iterator[tuple[JointedRobot, str]]:
    with page_robot(JointedRobot()) as found:
        yield found


@pytest.fixture
def robot(served) -> JointedRobot:
    found: JointedRobot = served[0]
    found.stop("the test is over")
    found.refusal = None
    found.asked.clear()
    found.held.clear()
    found.broken.clear()
    found.fallen = ""
    found.torque |= dict.fromkeys(found.torque, 0.9)
    found.angles |= dict.fromkeys(found.angles, 0.0)
    found.goals = dict(found.angles)
    found.kept.clear()
    return found


@pytest.fixture
def opened(browser, served, robot) -> Iterator[Callable[..., Page]]:
    errors: list[str] = []
    contexts: list[Any] = []

    def page(view: str, size: dict[str, Any], script: str = SOLID) -> Page:
        context = browser.new_context(**size, locale="en-GB")
        contexts.append(context)
        found = context.new_page()
        found.on("pageerror", lambda err: errors.append(str(err)))
        found.add_init_script(script)
        found.goto(f"{served[1]}/#{view}")
        if view == "joints" and script == SOLID:
            expect(found.locator(READY)).to_be_visible(timeout=LONG_MS)
        if view == "joints":
            expect(found.locator(".joints-row").first).not_to_have_attribute("data-tone", "unread", timeout=LONG_MS)
        return found

    yield page
    for context in contexts:
        context.close()
    assert errors == []


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
    assert within(page, lambda: positions(robot))
    assert {name for one in positions(robot) for name in one} == {"left_elbow"}
    goal = positions(robot)[-1]["left_elbow"]
    assert abs(goal) > 0.05
    assert within(page, lambda: abs(robot.angles["left_elbow"] - goal) < 0.03 and robot.holder is None)


def test_a_limb_that_is_only_tapped_is_chosen_and_moves_nothing(opened, robot):
    page = opened("joints", PHONE)
    box, (x, y) = page.locator("canvas").bounding_box(), page.evaluate(WHERE, "left_knee")
    page.mouse.click(box["x"] + x, box["y"] + y)
    expect(page.locator('.joints-row[data-joint="left_knee"] .joints-details')).to_be_visible()
    drag(page, "left_knee", 0, -60)
    page.wait_for_timeout(300)
    assert robot.held == []


def test_a_slider_sends_a_joint_to_its_goal_where_it_is_green(opened, robot):
    page = opened("joints", DESK, FLAT)
    row = page.locator('.joints-row[data-joint="right_knee"]')
    row.locator("input[type=range]").fill("-0.6")
    assert within(page, lambda: positions(robot))
    assert positions(robot)[-1]["right_knee"] == pytest.approx(-0.6, abs=0.01)
    assert within(page, lambda: abs(robot.angles["right_knee"] + 0.6) < 0.03)
    expect(row).to_have_attribute("data-tone", "near")
    assert within(page, lambda: robot.holder is None)


@both
def test_a_number_is_sent_within_the_limits_and_not_beyond(opened, robot, size):
    page = opened("joints", size, FLAT)
    number = page.locator('.joints-row[data-joint="right_elbow"] .joints-number')
    number.fill("900")
    expect(number).to_have_attribute("aria-invalid", "true")
    number.press("Enter")
    page.wait_for_timeout(200)
    assert robot.held == []
    number.fill("-30")
    number.press("Enter")
    assert within(page, lambda: positions(robot))
    assert positions(robot)[-1]["right_elbow"] == pytest.approx(-0.5236, abs=1e-3)


def test_a_slider_under_a_finger_does_not_heed_what_was_measured(opened, robot):
    page = opened("joints", DESK, FLAT)
    slider = page.locator('.joints-row[data-joint="right_knee"] input[type=range]')
    slider.scroll_into_view_if_needed()
    expect(slider).to_be_enabled()
    box = slider.bounding_box()
    page.mouse.move(box["x"] + box["width"] * 0.94, box["y"] + box["height"] / 2)
    page.mouse.down()
    page.mouse.move(box["x"] + box["width"] * 0.5, box["y"] + box["height"] / 2, steps=3)
    held = float(slider.input_value())
    page.wait_for_timeout(400)
    assert float(slider.input_value()) == held
    page.mouse.up()


@both
def test_releasing_all_is_asked_before_and_one_side_is_not(opened, robot, size):
    page = opened("joints", size, FLAT)
    page.get_by_role("button", name="Switch all off").click()
    dialog = page.get_by_role("dialog")
    expect(dialog).to_contain_text("falls")
    dialog.get_by_role("button", name="Cancel").click()
    assert robot.asked == []
    page.get_by_role("button", name="Switch off: Left").click()
    assert within(page, lambda: robot.asked)
    what, given = robot.asked.pop()
    assert (what, given["on"], len(given["joints"])) == ("joints/torque", False, 9)
    page.get_by_role("button", name="Switch all off").click()
    page.get_by_role("dialog").get_by_role("button", name="Switch all off").click()
    assert within(page, lambda: robot.asked)
    assert robot.asked[-1] == ("joints/torque", {"on": False, "confirmed": True})
    expect(page.locator('.joints-row[data-tone="limp"]')).to_have_count(18)


def test_an_overload_is_said_in_words_and_can_be_recovered(opened, robot):
    robot.broken["left_knee"] = "overload"
    page = opened("joints", PHONE, FLAT)
    row = page.locator('.joints-row[data-joint="left_knee"]')
    expect(row).to_have_attribute("data-tone", "fault")
    row.locator(".joints-name").click()
    expect(row.locator(".joints-fault")).to_contain_text("overload")
    row.get_by_role("button", name="Recover").click()
    expect(row).not_to_have_attribute("data-tone", "fault")


def test_without_a_graphics_card_the_body_is_flat_until_its_user_wants_three_dimensions(opened, robot):
    page = opened("joints", DESK, "")
    expect(page.locator(".joints-flat polygon").last).to_be_attached(timeout=LONG_MS)
    page.locator(".joints-flat polygon").first.dispatch_event("click")
    expect(page.locator(".joints-details")).to_be_visible()
    page.get_by_role("button", name="Show in 3D").click()
    expect(page.locator(READY)).to_be_visible(timeout=LONG_MS)
    page.reload()
    expect(page.locator(READY)).to_be_visible(timeout=LONG_MS)
    page.get_by_role("button", name="Flat").click()
    expect(page.locator(".joints-flat polygon").last).to_be_attached()
    expect(page.locator("canvas")).to_have_count(0)


def test_without_webgl_the_body_is_flat_whatever_was_chosen(opened, robot):
    page = opened("joints", DESK, f"{SOLID}; {NO_WEBGL}")
    expect(page.get_by_text("This browser has no 3D")).to_be_visible(timeout=LONG_MS)
    expect(page.locator(".joints-flat polygon").last).to_be_attached()
    expect(page.get_by_role("button", name="Show in 3D")).to_have_count(0)


LIMB = "polygon[data-joint=left_elbow]"
SEEN = """limb => {
  for (const one of document.querySelectorAll(limb)) {
    const box = one.getBoundingClientRect();
    const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
    if (document.elementFromPoint(x, y)?.matches(limb)) return [x, y];
  }
}"""
"""A point at which a limb is drawn, and no other over it."""


def test_a_limb_of_the_flat_body_is_dragged_and_its_joint_goes_there(opened, robot):
    page = opened("joints", DESK, f"{SOLID}; {NO_WEBGL}")
    row = page.locator(".joints-row[data-joint=left_elbow]")
    expect(row).to_have_attribute("data-tone", re.compile("near|held"), timeout=LONG_MS)
    x, y = page.evaluate(SEEN, LIMB)
    page.mouse.move(x, y)
    page.mouse.down()
    for step in (0.25, 0.5, 0.75, 1.0):
        page.mouse.move(x + 60 * step, y - 20 * step)
    assert within(page, lambda: positions(robot))
    page.mouse.up()
    assert {name for one in positions(robot) for name in one} == {"left_elbow"}
    assert within(page, lambda: robot.holder is None)


def test_a_refusal_has_the_button_that_mends_it(opened, robot):
    page = opened("motions", PHONE)
    robot.refusal = {"code": "no_torque", "reason": "18 joints have no torque: /torque/on first"}
    page.get_by_role("button", name="Play wave", exact=True).click()
    expect(page.locator(".notice")).to_contain_text("Joints are off.")
    expect(page.locator(".notice")).not_to_contain_text("/torque")
    page.locator(".notice").get_by_role("button", name="Switch on").click()
    assert within(page, lambda: ("joints/torque", {"on": True}) in robot.asked)
    robot.refusal = {"code": "held", "reason": "console holds it", "holder": "console"}
    page.get_by_role("button", name="Play wave", exact=True).click()
    expect(page.locator(".held")).to_contain_text("console moves it")
    robot.refusal = None
    page.get_by_role("button", name="Take over").click()
    assert within(page, lambda: robot.playing == "wave")
    assert robot.held[-1]["message"]["take_over"] is True


@both
def test_a_motion_is_played_and_ended_and_moves_no_button_away(opened, robot, size):
    page = opened("motions", size)
    place = "document.querySelector('.motions-list').offsetTop"
    page.get_by_role("radio", name="Build").wait_for()
    stands = page.evaluate(place)
    page.get_by_role("button", name="Play wave", exact=True).click()
    assert within(page, lambda: robot.held)
    assert robot.held[-1]["to"] == "motions/play"
    assert robot.held[-1]["message"] == {"motion": "wave", "times": 1, "speed": 1, "mirror": False}
    expect(page.locator(".motions-playing")).to_contain_text("wave")
    expect(page.locator(".motions-playing polygon").first).to_be_visible()
    assert page.evaluate(place) == stands
    page.get_by_role("button", name="End it").click()
    assert within(page, lambda: not robot.playing)


def test_a_motion_goes_on_in_another_view_and_its_end_is_told_once(opened, robot):
    page = opened("joints", PHONE, FLAT)
    page.get_by_role("button", name="wave", exact=True).click()
    assert within(page, lambda: robot.playing == "wave")
    page.evaluate("location.hash = 'motions'")
    page.get_by_role("button", name="End it").click()
    assert within(page, lambda: not robot.playing)
    expect(page.locator(".notice")).to_have_text(re.compile("^Stopped"))
    expect(page.locator(".motions-why")).to_have_count(0)


def frame(duration_s: float = 0.6, **positions: float) -> dict[str, Any]:
    return {"positions": positions, "duration_s": duration_s}


STANDS = [frame(left_elbow=-0.5), frame(left_elbow=-1.0), frame(left_elbow=-0.2)]
FALLS = [*STANDS[:2], frame(left_ankle_pitch=0.5, right_ankle_pitch=0.5), STANDS[2]]


@pytest.fixture
def building(opened, robot) -> Callable[..., Page]:
    def page(size: dict[str, Any], frames: list[dict[str, Any]], name: str = "nod") -> Page:
        draft = json.dumps(json.dumps({"name": name, "help": "", "frames": frames}))
        found = opened(
            "motions",
            size,
            f"localStorage.getItem('lbr.motion.draft') || localStorage.setItem('lbr.motion.draft', {draft})",
        )
        found.get_by_role("radio", name="Build").click()
        expect(found.locator(READY)).to_be_visible(timeout=LONG_MS)
        return found

    return page


def draft(page: Page) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = page.evaluate("JSON.parse(localStorage.getItem('lbr.motion.draft')).frames")
    return found


def test_a_motion_that_is_being_built_moves_the_drawing_alone(opened, robot):
    page = opened("motions", DESK)
    page.get_by_role("radio", name="Build").click()
    expect(page.locator(READY)).to_be_visible(timeout=LONG_MS)
    page.get_by_role("button", name="Add a pose").click()
    page.get_by_role("button", name="Add a pose").click()
    drag(page, "left_elbow", 60, -10)
    assert robot.held == []
    assert abs(draft(page)[1]["positions"]["left_elbow"]) > 0.05
    page.get_by_role("button", name="Play on the robot").click()
    assert within(page, lambda: robot.held)
    frames = robot.held[-1]["message"]["frames"]
    assert len(frames) == 2
    assert frames[0]["positions"]["left_elbow"] == 0.0
    assert abs(frames[1]["positions"]["left_elbow"]) > 0.05


def test_a_pose_is_turned_beside_its_drawing_on_a_phone(building):
    page = building(PHONE, STANDS)
    page.get_by_label("Joint", exact=True).select_option("left_elbow")
    drawn = page.locator(".motions-puppet").bounding_box()
    turned = page.get_by_label("Angle in degrees").bounding_box()
    assert drawn is not None
    assert turned is not None
    assert 0 < turned["y"] - drawn["y"] < PHONE["viewport"]["height"] - 2 * 80


def test_key_frames_are_copied_moved_taken_out_and_taken_back_by_the_keyboard(building):
    page = building(DESK, STANDS)
    page.locator(".motions-frame").nth(1).click()
    angles = lambda: [one["positions"].get("left_elbow") for one in draft(page)]  # noqa: E731
    for keys, expected in (
        ("Control+d", [-0.5, -1.0, -1.0, -0.2]),
        ("Delete", [-0.5, -1.0, -0.2]),
        ("Alt+ArrowRight", [-0.5, -0.2, -1.0]),
        ("Control+c", [-0.5, -0.2, -1.0]),
        ("ArrowLeft", [-0.5, -0.2, -1.0]),
        ("Control+v", [-0.5, -0.2, -1.0, -1.0]),
        ("Control+z", [-0.5, -0.2, -1.0]),
        ("Control+z", [-0.5, -1.0, -0.2]),
        ("Control+y", [-0.5, -0.2, -1.0]),
    ):
        page.keyboard.press(keys)
        assert within(page, lambda expected=expected: angles() == expected), (keys, angles())


def test_a_key_frame_is_dragged_to_another_time_and_those_behind_it_stay(building):
    page = building(DESK, STANDS)
    knot = page.locator(".motions-knot").nth(1).bounding_box()
    lane = page.locator(".motions-lane").bounding_box()
    assert knot is not None
    assert lane is not None
    y = knot["y"] + knot["height"] / 2
    page.mouse.move(knot["x"] + 22, y)
    page.mouse.down()
    page.mouse.move(lane["x"] + lane["width"] * 1.5 / 1.8, y, steps=4)
    page.mouse.up()
    assert within(page, lambda: [one["duration_s"] for one in draft(page)] == [0.6, 0.9, 0.3])
    page.get_by_role("button", name="Undo").click()
    assert within(page, lambda: [one["duration_s"] for one in draft(page)] == [0.6, 0.6, 0.6])


def test_the_last_key_frame_stays_under_the_pointer_that_drags_it(building):
    page = building(DESK, STANDS)
    knot = page.locator(".motions-knot").last
    box = knot.bounding_box()
    assert box is not None
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    for left in (40, 80, 120):
        page.mouse.move(x - left, y)
    assert within(page, lambda: abs((at := knot.bounding_box())["x"] + at["width"] / 2 - (x - 120)) < 8)
    page.mouse.up()
    assert draft(page)[-1]["duration_s"] < STANDS[-1]["duration_s"]


@needs_mujoco
def test_what_stands_is_checked_and_then_played(building, robot):
    page = building(PHONE, STANDS)
    page.get_by_role("button", name="Play on the robot").click()
    assert within(page, lambda: robot.held)
    expect(page.locator(".motions-verdict")).to_contain_text("It stands")
    assert len(robot.held[-1]["message"]["frames"]) == 3


@needs_mujoco
def test_what_falls_is_drawn_and_asked_about_once_more(building, robot):
    page = building(DESK, FALLS)
    page.get_by_role("button", name="Play on the robot").click()
    dialog = page.get_by_role("dialog")
    expect(dialog).to_contain_text("falls after", timeout=LONG_MS)
    assert robot.held == []
    dialog.get_by_role("button", name="Cancel").click()
    expect(page.locator(".motions-fell")).to_be_visible()
    expect(page.locator(".motions-verdict")).to_contain_text("key frame")
    page.get_by_role("button", name="Play on the robot").click()
    dialog.get_by_role("button", name="Play it").click()
    assert within(page, lambda: robot.held)
    page.get_by_role("button", name="Slower").click()
    expect(page.locator(".motions-fell")).to_have_count(0)


def test_a_motion_is_saved_and_comes_back_from_a_file(building, robot, tmp_path):
    page = building(DESK, [*STANDS[:2], frame(left_elbow=-0.2, right_elbow=-0.2)], "nod_twice")
    page.get_by_role("button", name="Save", exact=True).click()
    assert within(page, lambda: robot.kept)
    assert [len(row.positions) for row in robot.kept[-1]] == [1, 1, 2]
    with page.expect_download() as started:
        page.get_by_role("button", name="Save as a .mtn file").click()
    file = tmp_path / "nod_twice.mtn"
    started.value.save_as(file)
    dialog = page.get_by_role("dialog")
    expect(dialog).to_contain_text("What that form cannot say")
    dialog.get_by_role("button", name="Close").click()
    page.get_by_role("button", name="New").click()
    assert within(page, lambda: draft(page) == [])
    page.locator("input[type=file]").set_input_files(file)
    page.get_by_role("button", name="Open", exact=True).or_(page.locator(".motions-frame").first).first.click()
    assert within(page, lambda: len(draft(page)) == 3)
    page.locator("input[type=file]").set_input_files({"name": "photo.mtn", "mimeType": "image/png", "buffer": b"no motion"})  # fmt: skip
    expect(page.locator(".notices, [role=status], [role=alert]").filter(has_text="is no motion").first).to_be_visible()


def test_one_side_is_posed_by_hand_and_the_robots_pose_becomes_a_key_frame(building, robot):
    page = building(DESK, STANDS[:1])
    page.get_by_role("button", name="Switch off", exact=True).click()
    assert within(page, lambda: robot.asked)
    what, given = robot.asked.pop()
    assert (what, given["on"], len(given["joints"])) == ("joints/torque", False, 9)
    expect(page.locator(".motions-live")).to_be_visible()
    robot.angles["left_elbow"] = -1.2
    page.wait_for_timeout(500)
    page.get_by_role("button", name="Add the robot's pose").click()
    assert within(page, lambda: len(draft(page)) == 2)
    assert draft(page)[1]["positions"]["left_elbow"] == pytest.approx(-1.2, abs=0.01)


def test_a_thousand_key_frames_are_shown_and_ten_thousand_are_refused_in_words(building, robot):
    page = building(DESK, [frame(0.1, left_elbow=-0.001 * at) for at in range(1000)])
    expect(page.locator(".motions-rest")).to_have_text("+952")
    page.keyboard.press("End")
    expect(page.locator('.motions-frame[aria-selected="true"]')).to_contain_text("1000 ·")
    page.get_by_role("button", name="Play on the robot").click()
    big = json.dumps({"format": "lbr-motion", "robot": "bioloid", "version": 1, "motion": {"name": "big", "frames": [frame(0.1, left_elbow=-0.1)] * 10_000}})  # fmt: skip
    page.locator("input[type=file]").set_input_files({"name": "big.json", "mimeType": "application/json", "buffer": big.encode()})  # fmt: skip
    expect(page.get_by_text("1000 may be").first).to_be_visible(timeout=LONG_MS)


def test_torque_that_nobody_has_read_is_shown_as_unknown(opened, robot):
    robot.torque |= dict.fromkeys(robot.torque, None)
    page = opened("joints", DESK, FLAT)
    summary = page.get_by_role("region", name="Torque")
    count = len(robot.torque)
    expect(summary.get_by_text(f"On or off unknown: {count} of {count}")).to_be_visible()
    expect(summary.get_by_text(f"All {count} joints are on")).to_have_count(0)
    expect(summary.get_by_role("button", name="Switch all on")).to_be_enabled()
    expect(summary.get_by_role("button", name="Switch all off")).to_be_enabled()


@both
def test_a_robot_that_lies_is_shown_above_every_view_with_what_gets_it_up(opened, robot, size):
    robot.fallen = "face"
    page = opened("system", size)
    banner = page.get_by_role("alert").filter(has_text="It has fallen: it lies on its face")
    expect(banner).to_be_visible()
    assert banner.locator("p").bounding_box()["width"] > 180, "in two lines at most"
    banner.get_by_role("button", name="Get up").click()
    assert within(page, lambda: robot.held and robot.held[-1]["message"]["motion"] == "get_up_face")
    rises = page.get_by_role("alert").filter(has_text="It gets up")
    expect(rises).to_be_visible()
    robot.fallen = ""
    expect(rises).to_have_count(0)


@pytest.mark.parametrize("scrolled", [0, 5000])
def test_no_alarm_lies_over_the_drawing_of_the_builder(building, robot, scrolled):
    page = building({"viewport": {"width": 1280, "height": 800}}, STANDS)
    robot.fallen = "face"
    alarm = page.get_by_role("alert").filter(has_text="It has fallen")
    expect(alarm).to_be_visible()
    page.evaluate("y => window.scrollTo(0, y)", scrolled)
    above, drawn = alarm.bounding_box(), page.locator(".motions-puppet").bounding_box()
    assert above is not None
    assert drawn is not None
    assert above["y"] + above["height"] <= drawn["y"]
