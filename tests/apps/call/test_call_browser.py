"""A call in a real browser with a camera and a microphone of its own: one button, a person who answers, a display."""

from collections.abc import Iterator
from typing import Any

import pytest

from tests.support import needs

needs.modules("playwright", "aiortc")

from playwright.sync_api import Browser, Page, expect  # noqa: E402

from tests.apps.call.call_robot import CallRobot  # noqa: E402
from tests.apps.web.page_robot import page_robot, token  # noqa: E402
from tests.apps.web.test_page_tasks import AXE, FOUND  # noqa: E402

pytestmark = [needs.program("chromium", "chromium")]
PATIENT_MS = 20_000
"""A browser that encodes and decodes on a busy machine is slow; nothing here is about how fast."""
ARGUMENTS = (
    "--no-sandbox",
    "--disable-gpu",
    "--use-fake-ui-for-media-stream",
    "--use-fake-device-for-media-stream",
    "--allow-loopback-in-peer-connection",
    "--autoplay-policy=no-user-gesture-required",
)
PLAYS = "(chosen) => { const one = document.querySelector(chosen); return one && one.videoWidth > 0 && one.currentTime > 0.2; }"


@pytest.fixture(scope="module")
def served() -> Iterator[tuple[CallRobot, str]]:
    with page_robot(CallRobot()) as found:
        yield found


@pytest.fixture(autouse=True)
def patient(monkeypatch):
    """Have the robot wait longer for a page's word: a busy machine starves browsers, and nothing here is about that."""
    monkeypatch.setattr("lbr.apps.call.desk.SILENT_S", 60.0)
    monkeypatch.setattr("lbr.apps.call.desk.CONNECT_S", 60.0)


class Opened:
    def __init__(self, browser: Browser, url: str) -> None:
        self._browser, self._url = browser, url
        self._contexts: list[Any] = []
        self.errors: list[str] = []

    def page(self, path: str = "/#call", *, by: str = "ann", devices: bool = True, init: str = "", **more: Any) -> Page:
        """Open the robot's page by a token of that name, or as its owner."""
        given = {"locale": "en-GB", "viewport": {"width": 390, "height": 844}, **more}
        context = self._browser.new_context(permissions=["camera", "microphone"] if devices else [], **given)
        self._contexts.append(context)
        if init:
            context.add_init_script(init)
        if by:
            context.add_init_script(f"localStorage.setItem('lbr.token', '\"{token(by)}\"')")
        page = context.new_page()
        page.set_default_timeout(PATIENT_MS)
        page.on("pageerror", lambda err: self.errors.append(str(err)))
        page.goto(self._url + path)
        return page

    def close(self) -> None:
        for context in self._contexts:
            context.close()


@pytest.fixture
def robot(served) -> Iterator[CallRobot]:
    found = served[0]
    yield found
    found.away, found.camera_on = False, True


@pytest.fixture
def opened(browser, served, robot) -> Iterator[Opened]:
    found = Opened(browser, served[1])
    yield found
    found.close()
    robot.over()
    assert found.errors == []


def told(page: Page, text: str) -> None:
    expect(page.locator(".call-told")).to_contain_text(text, timeout=PATIENT_MS)


def plays(page: Page, chosen: str) -> None:
    page.wait_for_function(PLAYS, arg=chosen, timeout=PATIENT_MS)


def button(page: Page, name: str) -> Any:
    return page.get_by_role("button", name=name, exact=True)


def test_one_button_calls_a_person_answers_and_the_display_shows_the_caller(opened, robot):
    robot.row(answer="ask")
    display = opened.page("/display", by="", viewport={"width": 1024, "height": 600})
    expect(display.locator(".display-face")).to_be_visible()
    page = opened.page()
    button(page, "Call").click()
    told(page, "It rings at the robot")
    expect(display.get_by_role("alert")).to_contain_text("ann at 127.0.0.1 calls")
    button(display, "Answer").click()
    told(page, "In a call")
    plays(page, ".call-stage video.drive-picture")
    plays(display, "video.display-film")
    expect(page.locator(".call-words")).to_contain_text("Shown at the robot", timeout=PATIENT_MS)
    expect(page.locator(".call-words")).to_contain_text("You hear a test tone")
    assert display.evaluate("document.querySelector('video').srcObject.getAudioTracks().length") == 1
    assert display.evaluate("document.querySelector('video').muted") is False
    page.evaluate("location.hash = 'drive'")
    plays(page, ".drive-stage video.drive-picture")
    button(page, "Hang up").click()
    expect(display.locator(".display-face")).to_be_visible(timeout=PATIENT_MS)
    expect(page.locator(".drive-stage img.drive-picture")).to_be_visible(timeout=PATIENT_MS)
    assert [kind for kind, _ in robot.ctx.events] == ["call_rings", "call_answered", "call_connected", "call_ended"]


def test_without_a_camera_of_its_own_a_page_calls_and_says_that_it_is_not_seen(opened, robot):
    robot.row(answer="at_once")
    page = opened.page(init="Object.defineProperty(navigator, 'mediaDevices', {value: undefined});")
    button(page, "Call").click()
    told(page, "In a call")
    plays(page, ".call-stage video.drive-picture")
    expect(page.locator(".call-words")).to_contain_text("You are neither seen nor heard")
    expect(page.locator(".call-words")).to_contain_text("No display is open at the robot")
    robot.camera_on = False
    expect(page.locator(".call-nopicture")).to_contain_text("The robot's camera is off", timeout=PATIENT_MS)
    assert robot.state.phase == "talking"


def test_a_second_caller_is_told_who_was_first_and_may_watch_and_a_third_gets_mjpeg(opened, robot):
    robot.row(answer="at_once")
    first = opened.page()
    button(first, "Call").click()
    told(first, "In a call")
    second = opened.page(by="tablet", devices=False, locale="de-DE", viewport={"width": 1280, "height": 900})
    expect(second.locator(".call-words")).to_contain_text("ann at 127.0.0.1 spricht gerade über den Roboter")
    button(second, "Nur zusehen").click()
    told(second, "Sie sehen zu")
    plays(second, ".call-stage video.drive-picture")
    third = opened.page(by="", devices=False)
    button(third, "Only watch").click()
    expect(third.get_by_role("alert")).to_contain_text("2 get the picture by WebRTC already")
    expect(third.get_by_role("alert")).to_contain_text("The picture comes as MJPEG, without sound")
    expect(third.locator("img.drive-picture")).to_be_visible()


def test_a_process_that_is_gone_a_browser_without_webrtc_and_a_role_that_looks_get_mjpeg(opened, robot):
    robot.row(answer="at_once")
    robot.away = True
    page = opened.page()
    button(page, "Call").click()
    expect(page.get_by_role("alert")).to_contain_text("'call' does not answer")
    expect(page.locator("img.drive-picture")).to_be_visible()
    robot.away = False
    button(page, "Call again").click()
    told(page, "In a call")
    robot.row(answer="at_once")  # its process was killed, and has started again
    expect(page.get_by_role("alert")).to_contain_text("there is no such call", timeout=PATIENT_MS)
    expect(page.locator("img.drive-picture")).to_be_visible()
    old = opened.page(init="delete window.RTCPeerConnection;")
    button(old, "Call").click()
    expect(old.get_by_role("alert")).to_contain_text("this browser has no WebRTC")
    looks = opened.page(by="eve")
    expect(button(looks, "Call")).to_be_disabled()
    expect(looks.locator(".call-words")).to_contain_text("Your role only looks")


@pytest.mark.parametrize("size", [(390, 844), (1280, 900)], ids=["phone", "desk"])
def test_axe_finds_nothing_moderate_before_and_in_a_call(opened, robot, size):
    robot.row(answer="at_once")
    page = opened.page(viewport={"width": size[0], "height": size[1]}, reduced_motion="reduce")
    expect(button(page, "Call")).to_be_visible()
    page.evaluate(AXE)
    assert page.evaluate(FOUND) == []
    button(page, "Call").click()
    told(page, "In a call")
    assert page.evaluate(FOUND) == []
