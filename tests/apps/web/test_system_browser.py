"""The page's System view on a whole robot, in a browser: rows in forms, tokens, logs."""

import json
import re
import sqlite3
import tempfile
from contextlib import closing
from pathlib import Path

import pytest

from lbr.testing.device import plugged
from tests.support import needs
from tests.support.robot import Robot, lbr, prepare, running
from tests.support.waiting import until

needs.modules("playwright")

from playwright.sync_api import Page, expect  # noqa: E402

pytestmark = [needs.program("chromium", "chromium"), pytest.mark.slow_start]
SLOWLY_MS = 20_000
"""Bounds waiting on a machine that has much else to do."""


@pytest.fixture(scope="module")
def robot():
    with (
        tempfile.TemporaryDirectory(prefix="lbr-") as folder,
        running(prepare(Path(folder) / "h", "web", "box")) as one,
    ):
        until(lambda: one.capability("web")["phase"] == "ready")
        yield one


@pytest.fixture(params=[(390, 844), (1280, 900)], ids=["phone", "desktop"])
def page(request, browser, robot):
    width, height = request.param
    found = browser.new_page(viewport={"width": width, "height": height}, locale="en-GB")
    found.set_default_timeout(SLOWLY_MS)
    errors: list[str] = []
    found.on("pageerror", lambda error: errors.append(str(error)))
    found.goto(f"{robot.web}/#system")
    expect(found.get_by_role("heading", name="drive", exact=True)).to_be_visible(timeout=SLOWLY_MS)
    yield found
    found.close()
    assert not errors


def row(page: Page, table: str, name: str) -> None:
    """Open a row's form."""
    page.get_by_role("radio", name="Settings").click()
    page.get_by_label("Table").select_option(table)
    page.locator(".row", has=page.get_by_text(name, exact=True)).first.click()


def setting(robot: Robot, column: str) -> str:
    with closing(sqlite3.connect(robot.home / "robot.db")) as database:
        query = f"SELECT {column} FROM capability WHERE robot = 'lbr' AND name = 'drive'"
        return str(database.execute(query).fetchone()[0])


def test_a_limit_is_changed_in_a_form_that_says_what_is_wrong_and_what_restarts(page, robot):
    row(page, "capability", "drive")
    form = page.get_by_role("dialog")
    power = form.get_by_label("Top speed")
    power.fill("7")
    expect(form.get_by_text("At most 1")).to_be_visible()
    expect(form.get_by_role("button", name="Save")).to_be_disabled()
    power.fill("")
    form.get_by_text("Name, kind and start").click()
    form.get_by_label("kind").fill("No Such")
    expect(form.get_by_text("'No Such' is not a name")).to_be_visible(timeout=SLOWLY_MS)
    expect(form.get_by_text("Something below is not right yet")).to_be_visible()
    form.get_by_label("kind").fill("drive")
    wanted = "0.55" if page.viewport_size["width"] < 500 else "0.65"
    power.fill(wanted)
    expect(form.get_by_text("Restarts drive.")).to_be_visible(timeout=SLOWLY_MS)
    form.get_by_role("button", name="Save").click()
    expect(form).to_have_count(0, timeout=SLOWLY_MS)
    assert f'"max_power": {wanted}' in setting(robot, "settings")
    until(lambda: robot.capability("drive")["phase"] == "ready")


def test_what_is_typed_key_by_key_is_what_is_meant(page, robot):
    row(page, "capability", "drive")
    form = page.get_by_role("dialog")
    form.get_by_text("Name, kind and start").click()
    power, joined = form.get_by_label("Top speed"), form.get_by_label("needs")
    wanted = "0.05" if page.viewport_size["width"] < 500 else "0.06"
    power.fill("")
    power.press_sequentially(wanted)
    expect(power).to_have_value(wanted)
    joined.fill("[")
    with page.expect_response("**/api/rows*", timeout=SLOWLY_MS):  # looked up anew, and the form drawn again
        robot.edit("UPDATE capability SET help = help || '.' WHERE robot = 'lbr' AND name = 'box'")
    expect(form.get_by_text("JSON")).to_be_visible()
    joined.press_sequentially('"motors" , "ranges"]')
    expect(joined).to_have_value('["motors" , "ranges"]')
    expect(form.get_by_text("Restarts drive.")).to_be_visible(timeout=SLOWLY_MS)
    form.get_by_role("button", name="Save").click()
    expect(form).to_have_count(0, timeout=SLOWLY_MS)
    assert f'"max_power": {wanted}' in setting(robot, "settings")
    assert json.loads(setting(robot, "needs")) == ["motors", "ranges"]


def test_a_row_that_changed_under_an_open_form_is_told_and_either_is_kept(page, robot):
    row(page, "capability", "drive")
    form = page.get_by_role("dialog")
    width = page.viewport_size["width"]
    robot.edit("UPDATE capability SET help = ? WHERE robot = 'lbr' AND name = 'drive'", f"by another, {width}")
    form.get_by_text("Name, kind and start").click()
    form.get_by_label("help").fill("mine")
    expect(form.get_by_text("Another changed or deleted it meanwhile")).to_be_visible(timeout=SLOWLY_MS)
    form.get_by_role("button", name="Show the new row").click()
    expect(form.get_by_label("help")).to_have_value(f"by another, {width}", timeout=SLOWLY_MS)
    form.get_by_label("help").fill(f"mine after all, {width}")
    form.get_by_role("button", name="Save").click()
    expect(form).to_have_count(0, timeout=SLOWLY_MS)
    assert setting(robot, "help") == f"mine after all, {width}"


def test_what_people_ask_for_first_is_saved_with_what_restarts_and_taken_back(page, robot):
    page.get_by_role("radio", name="Settings").click()
    before = setting(robot, "settings")
    kept = page.get_by_label("Distance kept, left")
    kept.fill("0.37")
    expect(page.get_by_text("Restarts drive.")).to_be_visible(timeout=SLOWLY_MS)
    page.get_by_role("button", name="Save").click()
    expect(page.get_by_text("Saved: Distance kept, left")).to_be_visible(timeout=SLOWLY_MS)
    assert '"stop_m": 0.37' in setting(robot, "settings")
    page.get_by_role("button", name="Undo").click()
    expect(page.get_by_text("Taken back")).to_be_visible(timeout=SLOWLY_MS)
    assert json.loads(setting(robot, "settings")) == json.loads(before)
    until(lambda: robot.capability("drive")["phase"] == "ready")


def test_what_was_typed_outlives_a_row_that_is_deleted_and_a_robot_that_does_not_answer(page, robot):
    robot.edit("INSERT OR REPLACE INTO phrase (name, language, text) VALUES ('brief', 'en', 'old')")
    row(page, "phrase", "brief / en")
    form = page.get_by_role("dialog")
    form.get_by_label("text").fill("mine")
    robot.edit("DELETE FROM phrase WHERE name = 'brief'")
    form.get_by_role("button", name="Save").click()
    expect(form.get_by_text("changed or deleted it meanwhile")).to_be_visible(timeout=SLOWLY_MS)
    assert form.evaluate("it => it.scrollWidth <= it.clientWidth")
    page.context.set_offline(True)
    form.get_by_role("button", name="Keep my changes").click()
    expect(form.get_by_text("does not answer")).to_be_visible(timeout=SLOWLY_MS)
    page.context.set_offline(False)
    form.get_by_role("button", name="Keep my changes").click()
    expect(form.get_by_text("changed or deleted it meanwhile")).to_have_count(0, timeout=SLOWLY_MS)
    expect(form.get_by_label("text")).to_have_value("mine")
    form.get_by_role("button", name="Save").click()
    expect(form).to_have_count(0, timeout=SLOWLY_MS)
    with closing(sqlite3.connect(robot.home / "robot.db")) as database:
        assert database.execute("SELECT text FROM phrase WHERE name = 'brief'").fetchall() == [("mine",)]


def test_a_token_is_locked_out_by_a_tap(page, robot):
    name = f"visitor{page.viewport_size['width']}"
    assert lbr(robot.home, "token", "add", name, "--role", "view").returncode == 0
    page.get_by_role("radio", name="Access").click()
    page.get_by_role("button", name=f"Lock out: {name}").click(timeout=SLOWLY_MS)
    page.get_by_role("dialog").get_by_role("button", name="Lock out").click()
    told = page.get_by_role("listitem").filter(has_text=name)
    expect(told.get_by_text("locked out")).to_be_visible(timeout=SLOWLY_MS)


def test_one_button_connects_a_phone_and_closes_the_robot_again(page, robot):
    page.get_by_role("button", name="Connect a phone").first.click()
    dialog = page.get_by_role("dialog")
    picture = dialog.get_by_role("img")
    expect(picture).to_be_visible(timeout=SLOWLY_MS)
    expect(dialog.get_by_text("browser warns once")).to_be_visible()
    name, digits = f"phone{page.viewport_size['width']}", str(picture.get_attribute("alt")).partition("#pair=")[2]
    paired = page.request.post(f"{robot.web}/api/pair", data={"code": digits, "name": name})
    assert paired.json()["role"] == "operate"
    assert any(one["name"] == name for one in json.loads(lbr(robot.home, "token", "list", "--json").stdout))
    dialog.get_by_role("button", name="Close it to the network").click()
    until(lambda: (robot.ask("web/address", {}) or {}).get("open") is False, what="the robot is closed")


def test_a_log_is_read_and_stop_stays_within_reach(page, robot):
    (robot.home / "logs" / "lbr-base.log").write_text("what it has written\n")
    page.get_by_role("button", name="drive", exact=True).click()
    page.get_by_role("button", name="Log: drive").click()
    expect(page.get_by_role("dialog").get_by_text("what it has written")).to_be_visible(timeout=SLOWLY_MS)
    stop = page.locator("#stop")
    stop.click()
    page.keyboard.press("Escape")
    expect(page.get_by_role("dialog")).to_have_count(0)


def test_what_was_is_drawn_exported_and_explained_for_a_moment(page):
    page.get_by_role("radio", name="History").click()
    nearest = page.locator(".past-chart", has=page.get_by_text("Nearest", exact=True))
    expect(nearest.locator(".u-over")).to_be_visible(timeout=SLOWLY_MS)
    expect(nearest).to_contain_text(re.compile(r"\d m"))
    with page.expect_download() as kept:
        page.get_by_role("button", name="Export CSV").click()
    head, *lines = Path(kept.value.path()).read_text().splitlines()
    assert head == "time,nearest (m)"
    assert lines
    nearest.locator(".u-over").click(position={"x": 60, "y": 20})
    expect(page.locator(".past-moment strong").first).to_be_visible(timeout=SLOWLY_MS)


def test_a_moment_is_marked_and_a_recording_made_ended_and_saved(page, robot):
    until(lambda: robot.capability("box")["phase"] == "ready")
    until(lambda: robot.line("/mark/before")["code"] == 0)  # it runs when all others leave it time
    box = page.get_by_role("group", name="Black box")
    box.get_by_role("button", name="Mark this moment").click()
    expect(page.get_by_text("are kept").first).to_be_visible(timeout=SLOWLY_MS)
    before = len(list((robot.home / "recordings" / "lbr").glob("*.mcap")))
    box.get_by_role("button", name="Record", exact=True).click()
    end = box.get_by_role("button", name="End recording")
    expect(end).to_be_visible(timeout=SLOWLY_MS)
    end.click()
    made = page.get_by_role("dialog").get_by_role("link")
    expect(made).to_have_count(before + 1, timeout=SLOWLY_MS)
    with page.expect_download() as kept:
        made.first.click()
    newest = max((robot.home / "recordings" / "lbr").glob("*.mcap"))
    assert kept.value.suggested_filename == newest.name
    assert Path(kept.value.path()).read_bytes() == newest.read_bytes()
    page.keyboard.press("Escape")
    expect(box.get_by_role("button", name="Record", exact=True)).to_be_visible(timeout=SLOWLY_MS)


def test_what_is_plugged_in_is_shown_with_a_preview_and_written_on_a_yes(page, robot, tmp_path):
    with plugged("riox", tmp_path, name="unit") as found:
        at = found.device.address
        said = json.loads(lbr(robot.home, "devices", "--json", "--robot", "lbr", "--port", at).stdout)
    told = {"accepted": True, "reason": "", "code": "", "problems": [], "touched": None, "data": said}
    page.route("**/api/devices", lambda route: route.fulfill(json=told))  # the one door to ports of this machine's own
    page.get_by_role("radio", name="Devices").click()
    page.get_by_role("button", name="Look what is plugged in").click()
    device = page.get_by_role("listitem").filter(has_text="RIOX inertial unit")
    expect(device.get_by_text(at)).to_be_visible()
    device.get_by_role("button", name="Add").click()
    preview = page.get_by_role("dialog")
    expect(preview.get_by_text("added").or_(preview.get_by_text("changed")).first).to_be_visible()
    assert at not in addresses(robot)
    preview.get_by_role("button", name="Yes, write").click()
    until(lambda: at in addresses(robot))
    assert lbr(robot.home, "db", "undo").returncode == 0
    assert at not in addresses(robot)


def addresses(robot: Robot) -> list[str]:
    with closing(sqlite3.connect(robot.home / "robot.db")) as database:
        return [one for (one,) in database.execute("SELECT address FROM device WHERE robot = 'lbr'")]
