"""The page's view of behaviours on a whole robot, in a browser: a table is imported, run, watched, and edited while it runs."""

import re
import sqlite3
import tempfile
from contextlib import closing
from pathlib import Path

import pytest

from tests.support import needs
from tests.support.robot import prepare, running
from tests.support.waiting import until

needs.modules("playwright")

from playwright.sync_api import Locator, Page, expect  # noqa: E402

pytestmark = [needs.program("chromium", "chromium"), pytest.mark.slow_start]
SLOWLY_MS = 20_000
WAITS = """Type,Current State,Time,Forward,O:speech,Next State
start,Waiting,>= 3600,,,Done
,Waiting,,< 1,,Done
end,Done,,,,
fail,Stuck,,,,
"""
FORKS = "Type,Current State,Time,Next State\nstart,Waiting,> 9,A\n" + "".join(
    f",Waiting,> {9 - n},{state}\n" for n, state in enumerate("BCDEFGH", start=1)
)
FIRST_IN_SIGHT = """() => {
    const graph = document.querySelector(".behaviours-graph"), first = document.querySelector(".behaviours-start");
    if (!graph || !first || graph.scrollWidth <= graph.clientWidth) return false;
    const [around, inside] = [graph, first].map((one) => one.getBoundingClientRect());
    return around.left <= inside.left && inside.right <= around.right && around.top <= inside.top;
}"""
"""Looked at in one go: the page may be laid out anew between two looks."""
WIDE = FORKS + "".join(f",{state},> 1,Done\n" for state in "ABCDEFGH") + "end,Done,,\nfail,Stuck,,\n"


@pytest.fixture(scope="module")
def robot():
    with (
        tempfile.TemporaryDirectory(prefix="lbr-") as folder,
        running(prepare(Path(folder) / "h", "behaviour", "web")) as one,
    ):
        until(lambda: one.capability("behaviour")["phase"] == one.capability("web")["phase"] == "ready")
        yield one


@pytest.fixture
def page(browser, robot):
    found = browser.new_page(viewport={"width": 1280, "height": 900}, locale="en-GB")
    found.set_default_timeout(SLOWLY_MS)
    errors: list[str] = []
    found.on("pageerror", lambda error: errors.append(str(error)))
    found.goto(f"{robot.web}/#behaviours")
    expect(found.get_by_role("heading", name="Tables", exact=True)).to_be_visible(timeout=SLOWLY_MS)
    yield found
    robot.line("/behaviour/stop")
    found.close()
    assert not errors


def take(page: Page, name: str, content: str) -> None:
    """Give the page a file."""
    page.locator("input[type=file]").set_input_files({"name": name, "mimeType": "text/csv", "buffer": content.encode()})


def cell(page: Page, column: str, row: int) -> Locator:
    return page.get_by_label(f"{column}, row {row}", exact=True)


def kept(robot, step: int) -> str | None:
    with closing(sqlite3.connect(robot.home / "robot.db")) as database:
        query = "SELECT conditions FROM behaviour_row WHERE behaviour = 'wait_here' AND step = ?"
        found = database.execute(query, (step,)).fetchone()
    return found[0] if found else None


def test_a_table_from_a_file_is_run_watched_and_edited_while_it_runs(page, robot):
    take(page, "wait here.csv", WAITS)
    expect(page.get_by_label("Name")).to_have_value("wait_here")
    page.get_by_role("button", name="Take it").click()
    expect(page.get_by_role("heading", name="wait here")).to_be_visible()
    page.get_by_role("button", name="Run", exact=True).click()
    expect(page.get_by_text("in “Waiting”")).to_be_visible()
    expect(page.get_by_role("button", name="Waiting, the robot is here")).to_be_visible()
    expect(page.get_by_text(re.compile(r"off by 3,\d\d\d")).first).to_be_visible()
    time = cell(page, "Time", 1)
    time.fill(">> 4")
    time.press("Enter")
    expect(page.get_by_role("alert").first).to_be_visible()
    assert ">= 3600" in (kept(robot, 1) or "")  # what cannot be read is not kept, and stays to be mended
    near = cell(page, "Forward", 2)
    near.fill("< 2")
    near.press("Enter")
    until(lambda: "< 2" in (kept(robot, 2) or ""), what="the robot's rows")
    expect(time).to_have_attribute("aria-invalid", "true")  # also when another cell was kept since
    time.fill(">= 1800")
    time.press("Enter")
    expect(time).to_have_attribute("aria-invalid", "false")
    expect(page.get_by_text("it counts from the next time")).to_be_visible()
    until(lambda: ">= 1800" in (kept(robot, 1) or ""), what="the robot's rows")
    page.get_by_role("button", name="Pause").click()
    expect(page.get_by_text("paused in “Waiting”")).to_be_visible()
    page.get_by_role("button", name="End it").click()
    expect(page.get_by_role("button", name="Run", exact=True)).to_be_enabled()


def test_a_file_that_is_no_table_is_told_by_its_lines_and_not_taken(page, robot):
    take(page, "<b>bad</b>.csv", WAITS.replace(">= 3600", ">> <i>4</i>"))
    expect(page.get_by_text("Line 2, Time")).to_be_visible()
    expect(page.get_by_role("button", name="Take it")).to_be_disabled()
    page.get_by_role("button", name="Cancel").click()
    take(page, "nothing.csv", "")
    expect(page.get_by_text("this column is missing").first).to_be_visible()


def test_a_name_that_is_taken_says_so_and_another_may_be_typed_as_words(page, robot):
    page.get_by_role("button", name="New table").click()
    form = page.get_by_role("dialog")
    form.get_by_label("Name").fill("patrol")
    expect(form.get_by_role("alert")).to_contain_text("There is a table “patrol” already")
    expect(form.get_by_role("button", name="Begin it")).to_be_disabled()
    form.get_by_label("Name").fill("my table")
    expect(form.get_by_role("alert")).to_have_count(0)
    expect(form.get_by_role("button", name="Begin it")).to_be_enabled()


def test_a_cell_takes_no_more_than_the_robot_does(page, robot):
    page.get_by_role("button", name="New table").click()
    page.get_by_label("Name").fill("long_names")
    page.get_by_role("button", name="Begin it").click()
    for column, most in (("Current State", 80), ("Next State", 80)):
        expect(cell(page, column, 1)).to_have_attribute("maxlength", str(most))


def test_a_graph_that_is_wider_than_the_page_opens_with_its_first_state_in_sight(page, robot):
    take(page, "forks.csv", WIDE)
    page.get_by_role("button", name="Take it").click()
    expect(page.get_by_role("heading", name="forks")).to_be_visible()
    page.wait_for_function(FIRST_IN_SIGHT)


def test_a_table_that_is_taken_away_while_it_is_looked_at_leaves_the_page_whole(page, robot):
    page.get_by_role("button", name="New table").click()
    page.get_by_label("Name").fill("short_one")
    page.get_by_role("button", name="Begin it").click()
    expect(page.get_by_role("heading", name="short one")).to_be_visible()
    robot.edit("DELETE FROM behaviour_row WHERE behaviour = 'short_one'")
    robot.edit("DELETE FROM behaviour WHERE name = 'short_one'")
    expect(page.get_by_role("heading", name="Choose a table")).to_be_visible()
