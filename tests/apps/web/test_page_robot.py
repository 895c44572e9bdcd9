"""The page against a whole robot, down to its motors' bytes."""

import signal
import time
from collections.abc import Callable
from contextlib import suppress

import psutil
import pytest

from tests.support import browsers, needs
from tests.support.robot import Robot, prepare, running
from tests.support.waiting import until

needs.modules("playwright")

from playwright.sync_api import Page, expect, sync_playwright  # noqa: E402

pytestmark = [needs.program("chromium", "chromium"), pytest.mark.slow_start]
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
    end = time.monotonic() + 1.0
    while time.monotonic() < end:
        if turns(robot):
            return True
        page.wait_for_timeout(10)
    page.mouse.up()
    return False


def chromium() -> list[psutil.Process]:
    """Return the browser's processes; some may be gone."""
    return [one for one in psutil.Process().children(recursive=True) if "chrom" in one.name()]


def signalled(number: int) -> None:
    for process in chromium():
        with suppress(psutil.Error):
            process.send_signal(number)


def stands_in_time(robot: Robot, lost: Callable[[], object]) -> None:
    """Lose the page; the motors stand."""
    lost()
    until(lambda: not turns(robot), what="motors that stand")


def test_the_thumb_moves_the_motors_and_a_page_that_is_lost_stops_them(tmp_path):
    home = prepare(tmp_path / "home", "web")
    with running(home) as robot, sync_playwright() as started:
        browser = browsers.start_windowed(started)

        def opened() -> Page:
            page = browser.new_page(locale="en-GB", service_workers="block")
            page.goto(f"{robot.web}/#drive")
            expect(page.locator(".drive-why")).to_contain_text("Ready", timeout=15_000)
            assert any(push(page) or drives(page, robot) for _ in range(TRIES))
            return page

        page = opened()
        page.mouse.up()
        until(lambda: not turns(robot), what="motors that stand once the thumb is lifted")
        assert any(push(page) or drives(page, robot) for _ in range(TRIES))
        stands_in_time(robot, page.close)
        page = opened()
        stands_in_time(robot, lambda: signalled(signal.SIGSTOP))  # as a phone that is locked
        before = robot.trace.read_text()
        signalled(signal.SIGCONT)
        page.mouse.move(600, 300, steps=3)
        page.wait_for_timeout(300)
        assert not turns(robot), robot.trace.read_text()[len(before) :]
        page.close()
        opened()
        stands_in_time(robot, lambda: signalled(signal.SIGKILL))
