"""The page against a whole robot, down to its motors' bytes."""

import shutil

import pytest

from tests.support import machine, needs
from tests.support.robot import Robot, prepare, running, until

needs.modules("playwright")

from playwright.sync_api import Page, expect, sync_playwright  # noqa: E402

pytestmark = [needs.program("chromium", "chromium"), pytest.mark.slow_start, pytest.mark.timeout(60)]
STANDS_S = 0.4
TRIES = 4
"""A machine that is kept busy starves a browser, whose motion lapses; then the thumb pushes again, as a person's would."""


def turns(robot: Robot) -> bool:
    """Say whether the newest order to the motors has them turn."""
    orders = [line.split()[-2:] for line in robot.trace.read_text().splitlines() if "!M " in line]
    return bool(orders) and orders[-1] != ["0", "0"]


def push(page: Page) -> None:
    stick = page.locator(".drive-stick").bounding_box()
    assert stick is not None
    x, y = stick["x"] + stick["width"] / 2, stick["y"] + stick["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x, y - 0.3 * stick["height"], steps=3)


def drives(page: Page, robot: Robot) -> bool:
    watch = machine.Stopwatch()
    while not watch.over(1.0):
        if turns(robot):
            return True
        page.wait_for_timeout(10)
    page.mouse.up()
    return False


def test_the_thumb_moves_the_motors_and_a_closed_page_stops_them(tmp_path):
    home = prepare(tmp_path / "home", "web")
    with running(home) as robot, sync_playwright() as started:
        browser = started.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox", "--disable-gpu"])  # fmt: skip
        page = browser.new_page(locale="en-GB")
        page.goto(f"{robot.web}/#drive")
        expect(page.locator(".drive-why")).to_contain_text("Ready", timeout=15_000)
        assert any(push(page) or drives(page, robot) for _ in range(TRIES))
        page.mouse.up()
        until(lambda: not turns(robot), what="motors that stand once the thumb is lifted")
        assert any(push(page) or drives(page, robot) for _ in range(TRIES))
        watch = machine.Stopwatch()
        page.close()
        until(lambda: not turns(robot), what="motors that stand once the page is closed")
        assert not watch.over(STANDS_S), watch
        browser.close()
