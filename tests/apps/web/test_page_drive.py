"""What the Drive view moves besides its stick, and what stops it: sideways and round, moves by values, songs, distances, the map."""

import re

import pytest

from tests.apps.web.page_robot import MECANUM
from tests.support import needs
from tests.support.browsers import within

needs.modules("playwright")

from playwright.sync_api import Page, expect  # noqa: E402

from tests.apps.web.test_page_browser import HIDE, grip, opened, robot, served, stands  # noqa: E402

__all__ = ["opened", "robot", "served"]
pytestmark = [needs.program("chromium", "chromium")]


def shown(page: Page) -> None:
    expect(page.locator(".drive-stick")).to_be_visible()
    expect(page.locator('.linkdot[data-link="open"]')).to_be_visible()


def turn(page: Page, right: float) -> None:
    """Put a finger on the bar that turns the base, and push it; as a part of its width."""
    bar = page.locator(".drive-turner")
    expect(bar).to_be_visible()
    bar.scroll_into_view_if_needed()
    box = bar.bounding_box()
    assert box is not None
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + right * box["width"], y, steps=3)


@pytest.fixture
def crab(robot):
    """The robot on wheels that go sideways."""
    robot.rebuild(MECANUM)
    yield robot
    robot.rebuild(None)


def newest(robot) -> tuple[str, dict]:
    return robot.held[-1]["to"], robot.held[-1]["message"]


def test_a_base_that_goes_sideways_does_and_turns_by_a_control_of_its_own(opened, crab):
    page = opened.page("phone")
    grip(page, ahead=0.0, right=0.3)
    assert within(page, lambda: crab.moves)
    to, message = newest(crab)
    assert (to, message["vx_mps"], message["vy_mps"] < 0, message["wz_rps"]) == ("drive/twist", 0, True, 0)
    expect(page.locator(".drive-gauge", has_text="Speed")).not_to_contain_text("0.00")
    page.mouse.up()
    assert within(page, lambda: not crab.moves)
    turn(page, 0.3)
    assert within(page, lambda: crab.moves)
    to, message = newest(crab)
    assert (to, message["vx_mps"], message["vy_mps"], message["wz_rps"] < 0) == ("drive/twist", 0, 0, True)
    assert -message["wz_rps"] <= 0.4 * MECANUM["max_turn_rps"], "no faster than the chosen power"
    page.mouse.up()
    assert stands(page, crab)


def test_keys_go_sideways_and_turn_at_once(opened, crab):
    page = opened.page()
    shown(page)
    page.keyboard.down("a")
    page.keyboard.down("e")
    assert within(page, lambda: crab.held and newest(crab)[1]["vy_mps"] > 0 and newest(crab)[1]["wz_rps"] < 0)
    page.keyboard.up("a")
    assert within(page, lambda: newest(crab)[1]["vy_mps"] == 0 and crab.moves)
    page.keyboard.up("e")
    assert within(page, lambda: not crab.moves)


@pytest.mark.parametrize("how", ["hide", "close", "blur", "stop"])
def test_a_base_that_goes_sideways_or_turns_stands_when_its_page_goes_away(opened, crab, how):
    other = opened.blank()
    page = opened.page()
    shown(page)
    turn(page, 0.3) if how in {"hide", "stop"} else grip(page, ahead=0.0, right=-0.3)
    assert within(page, lambda: crab.moves)
    if how == "close":
        page.close()
    elif how == "stop":
        page.keyboard.press("Escape")
    else:
        page.evaluate(HIDE if how == "hide" else "window.dispatchEvent(new Event('blur'))")
    assert stands(other, crab)
    if how in {"hide", "stop"}:
        held = len(crab.held)
        page.mouse.move(700, 500, steps=4)
        page.wait_for_timeout(150)
        assert (crab.moves, len(crab.held)) == (False, held), "a finger that stayed has to be lifted first"


def test_a_base_that_cannot_go_sideways_has_no_control_to_turn_and_q_does_nothing(opened, robot):
    page = opened.page()
    shown(page)
    expect(page.locator(".drive-turner")).to_have_count(0)
    page.keyboard.down("q")
    page.wait_for_timeout(150)
    page.keyboard.up("q")
    assert not robot.held


def test_moves_are_made_by_values_that_are_typed_or_stepped_and_kept(opened, robot):
    page = opened.page()
    shown(page)
    field = page.get_by_role("textbox", name="Distance")
    field.fill("120")
    field.press("Enter")
    page.get_by_role("button", name="Ahead 120 cm").click()
    assert within(page, lambda: robot.held and newest(robot)[1]["distance_cm"] == 120)
    assert within(page, lambda: not robot.moves)
    page.get_by_role("button", name="Angle: less").click()
    page.get_by_role("button", name="Turn -60°").click()
    assert within(page, lambda: newest(robot) == ("drive/turn", {"angle_deg": -60}))
    assert within(page, lambda: not robot.moves)
    heading = page.get_by_role("textbox", name="Heading")
    heading.fill("9999")
    heading.press("Enter")
    page.get_by_role("button", name="Turn to 359°").click()
    assert within(page, lambda: newest(robot) == ("drive/heading", {"heading_deg": 359}))
    page.reload()
    expect(page.get_by_role("button", name="Ahead 120 cm")).to_be_visible()
    expect(page.get_by_role("textbox", name="Heading")).to_have_value("359")


def test_nonsense_in_a_value_changes_nothing(opened, robot):
    page = opened.page()
    shown(page)
    field = page.get_by_role("textbox", name="Distance")
    for text in ("far", "", "1e999", "--5"):
        field.fill(text)
        field.press("Enter")
        expect(field).to_have_value(re.compile("^(50|1000)$"))
    assert not robot.held


@pytest.mark.parametrize("how", ["close", "hide"])
def test_a_move_by_a_value_ends_with_its_page(opened, robot, how):
    robot.lasts_s = 20.0
    other = opened.blank()
    page = opened.page()
    shown(page)
    page.get_by_role("button", name="Ahead 50 cm").click()
    assert within(page, lambda: robot.moves)
    page.close() if how == "close" else page.evaluate(HIDE)
    assert stands(other, robot)


@pytest.mark.parametrize("size", ["desk", "phone"])
def test_a_slow_link_says_how_slow_it_drives_and_how_late_all_comes(opened, robot, size):
    robot.link_age_s = 0.31
    page = opened.page(size)
    grip(page)
    why = page.locator(".drive-why")
    expect(why).to_contain_text("Slow link: half speed")
    expect(why).to_contain_text("You see what you do 0.3 s later")
    expect(page.locator(".drive-stick")).to_have_attribute("data-slow", "true")
    robot.link_age_s = 0.03
    page.mouse.move(page.viewport_size["width"] / 2, 0, steps=4)
    expect(why).to_contain_text("You drive")
    page.mouse.up()
    assert stands(page, robot)


def test_a_move_below_the_stick_tells_how_it_goes(opened, robot):
    robot.lasts_s = 60.0
    page = opened.page("phone")
    page.get_by_role("button", name="Dock").scroll_into_view_if_needed()
    page.get_by_role("button", name="Turn 90°", exact=True).click()
    expect(page.locator(".drive-why[data-away]")).to_contain_text("drive")
    expect(page.locator(".drive-why")).to_be_in_viewport()
    page.get_by_role("application").scroll_into_view_if_needed()
    expect(page.locator(".drive-why[data-away]")).to_have_count(0)


def test_songs_are_played_and_danced_to(opened, robot):
    page = opened.page()
    shown(page)
    page.get_by_role("button", name="Play blue moon").click()
    assert within(page, lambda: ("speech/play", {"song": "blue_moon"}) in robot.asked)
    page.get_by_role("button", name="Dance to metronome").click()
    assert within(page, lambda: ("dance/play", {"song": "metronome"}) in robot.asked)


def test_each_sensor_says_what_it_reads_or_why_it_reads_nothing(opened, robot):
    robot.blind = {"left": "invalid", "right": "missing", "back": "over_range"}
    page = opened.page()
    lines = page.locator(".drive-distances")
    expect(lines.locator('[data-sensor="left"]')).to_contain_text("no valid reading")
    expect(lines.locator('[data-sensor="right"]')).to_contain_text("does not answer")
    expect(lines.locator('[data-sensor="back"]')).to_contain_text("nothing near")
    expect(lines.locator('[data-sensor="forward"]')).to_contain_text(re.compile(r"\d (c?)m"))
    expect(page.locator(".drive-gauges")).to_contain_text("Not known: left, right")
    robot.muted |= {"ranges"}
    expect(lines.locator('[data-status="stale"]').first).to_contain_text(re.compile(r"\d s old"))


def test_the_map_is_drawn_zoomed_dragged_and_cleared_and_none_of_that_moves_the_robot(opened, robot):
    page = opened.page()
    shown(page)
    page.get_by_role("radio", name="Map").click()
    whole = page.get_by_role("button", name="Show all")
    expect(whole).to_have_attribute("aria-pressed", "true")
    page.get_by_role("button", name="Zoom in").click()
    expect(whole).to_have_attribute("aria-pressed", "false")
    box = page.locator(".drive-map canvas").bounding_box()
    assert box is not None
    page.mouse.move(box["x"] + 300, box["y"] + 200)
    page.mouse.wheel(0, 200)
    page.mouse.down()
    page.mouse.move(box["x"] + 360, box["y"] + 260, steps=4)
    page.mouse.up()
    page.get_by_role("button", name="Zoom out").click()
    whole.click()
    expect(whole).to_have_attribute("aria-pressed", "true")
    page.get_by_role("button", name="Clear the map").click()
    assert not robot.held
