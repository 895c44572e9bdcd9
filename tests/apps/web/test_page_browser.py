"""The page in a browser, on a phone's screen and a desk's: what a hand on it moves, and what stops when the hand is off."""

import math
import re
import time
from collections.abc import Iterator
from typing import Any

import pytest

from tests.apps.web.page_robot import PageRobot, capability, outputs, page_robot, token
from tests.support import browsers, needs
from tests.support.browsers import within
from tests.support.waiting import STOPS_S, until

needs.modules("playwright")

from playwright.sync_api import Browser, BrowserContext, Page, expect  # noqa: E402

pytestmark = [needs.program("chromium", "chromium")]
REFUSED = ("401", "403", "HTTP Authentication failed")
"""How a browser names what a page without a token asks for."""
SIZES: dict[str, dict[str, Any]] = {
    "phone": {"viewport": {"width": 390, "height": 844}, "has_touch": True, "is_mobile": True},
    "desk": {"viewport": {"width": 1280, "height": 800}},
}
both = pytest.mark.parametrize("size", SIZES)
HIDE = """() => {
  Object.defineProperty(document, "hidden", {value: true, configurable: true});
  document.dispatchEvent(new Event("visibilitychange"));
}"""
PAD = """
  let pad = null;
  navigator.getGamepads = () => [pad];
  window.unplugged = () => { pad = null; };
  window.lean = (x) => {
    const anew = pad === null;
    pad = { id: "pad", connected: true, axes: [x, 0, 0, 0], buttons: [] };
    if (anew) dispatchEvent(new Event("gamepadconnected"));
  };"""
SLOWLY = "const now = performance.now.bind(performance); performance.now = () => now() / 10;"
"""A page ends its hold, and marks its streams old, after a second in which it or its server is held up. Here it is ten."""
FRAMES = "async () => { for (let n = 0; n < 6; n++) await new Promise(requestAnimationFrame); }"
UNNAMED = """() => [...document.querySelectorAll("button, a, input, select, [role=application]")]
  .filter((one) => one.offsetParent !== null || one.id === "stop")
  .filter((one) => !(one.getAttribute("aria-label") || one.textContent.trim() || one.labels?.length))
  .map((one) => one.outerHTML)"""
SMALL = """() => [...document.querySelectorAll("button, select, input:not([type=range]):not([type=checkbox]), .nav a")]
  .filter((one) => one.offsetParent !== null).map((one) => [one.className, one.getBoundingClientRect()])
  .filter(([, box]) => Math.min(box.width, box.height) < 37.5).map(([name, box]) => `${name} ${box.width}x${box.height}`)"""


@pytest.fixture(scope="module")
def served() -> Iterator[tuple[PageRobot, str]]:
    with page_robot() as found:
        yield found


@pytest.fixture
def robot(served) -> Iterator[PageRobot]:
    found = served[0]
    found.asked.clear()
    found.held.clear()
    yield found
    found.refusal, found.estop, found.link_age_s = None, "", 0.03
    found.blind, found.lasts_s = {}, 0.6
    found.muted.clear()
    found.stop("the test is over")


class Opened:
    """Contexts of one test, and what went wrong in their pages."""

    def __init__(self, browser: Browser, url: str) -> None:
        self._browser, self._url = browser, url
        self._contexts: list[BrowserContext] = []
        self.errors: list[str] = []

    def page(
        self,
        size: str = "desk",
        path: str = "/#drive",
        *,
        at: str = "127.0.0.1",
        by: str = "",
        script: str = SLOWLY,
        **more: Any,
    ) -> Page:
        """Open the robot's page, at a name of the robot, by a token of that name, after a script of the test."""
        context = self._browser.new_context(**(SIZES[size] | {"locale": "en-GB", "service_workers": "block"} | more))
        self._contexts.append(context)
        page = context.new_page()
        if by:
            page.add_init_script(f"localStorage.setItem('lbr.token', '\"{token(by)}\"')")
        page.add_init_script(script)
        page.on("pageerror", lambda err: self.errors.append(str(err)))
        page.on("console", lambda said: self.errors.append(said.text) if said.type == "error" else None)
        page.goto(self._url.replace("127.0.0.1", at) + path)
        return page

    def blank(self) -> Page:
        """Return a page that looks at nothing."""
        self._contexts.append(self._browser.new_context())
        return self._contexts[-1].new_page()

    def close(self) -> None:
        for context in self._contexts:
            context.close()


@pytest.fixture
def opened(browser, served, robot) -> Iterator[Opened]:
    found = Opened(browser, served[1])
    yield found
    found.close()
    assert until(lambda: robot.sockets == 0)
    assert [one for one in found.errors if not any(why in one for why in REFUSED)] == []


def stands(page: Page, robot: PageRobot) -> bool:
    """Return whether the wheels come to stand."""
    return within(page, lambda: not robot.moves, STOPS_S)


def grip(page: Page, ahead: float = 0.32, right: float = 0.0) -> None:
    """Put a finger on the stick and push it; as parts of its size."""
    stick = page.locator(".drive-stick")
    expect(stick).to_be_visible()
    expect(page.locator('.linkdot[data-link="open"]')).to_be_visible()
    stick.hover(trial=True)  # until it stays where it is
    box = stick.bounding_box()
    assert box is not None
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + right * box["width"], y - ahead * box["height"], steps=4)


@both
def test_a_thumb_drives_and_a_lifted_thumb_stops(opened, robot, size):
    page = opened.page(size)
    grip(page)
    assert within(page, lambda: robot.moves)
    assert robot.held[-1]["to"] == "drive/command"
    assert robot.held[-1]["message"]["angle_deg"] == 0
    page.wait_for_timeout(600)
    assert robot.moves, "a thumb that rests on the stick goes on driving"
    page.mouse.up()
    assert stands(page, robot)


def test_keys_drive_while_they_are_held(opened, robot):
    page = opened.page()
    expect(page.locator(".drive-why")).to_contain_text("Ready")
    page.keyboard.down("ArrowUp")
    page.keyboard.down("d")
    assert within(page, lambda: robot.moves and robot.held[-1]["message"]["angle_deg"] == 45)
    page.keyboard.up("ArrowUp")
    assert within(page, lambda: robot.held[-1]["message"]["angle_deg"] == 90)
    page.keyboard.up("d")
    assert within(page, lambda: not robot.moves)


def test_a_key_or_gamepad_that_is_pushed_already_moves_nothing_until_it_was_at_rest(opened, robot):
    page = opened.page(script=SLOWLY + PAD)
    expect(page.locator(".drive-why")).to_contain_text("Ready")

    def moves_nothing() -> None:
        page.evaluate(FRAMES)
        assert not robot.held

    def drives_after_rest() -> None:
        page.evaluate("lean(0)")
        page.evaluate(FRAMES)
        page.evaluate("lean(0.7)")
        assert within(page, lambda: robot.moves)

    page.evaluate("lean(0.7)")  # as one that is found pushed, or again after the page was loaded anew
    moves_nothing()
    drives_after_rest()
    for loss in ("unplugged()", "dispatchEvent(new Event('blur'))"):
        page.evaluate(loss)
        assert within(page, lambda: not robot.moves), loss
        robot.held.clear()
        page.evaluate("lean(0.7)")
        moves_nothing()
        drives_after_rest()
    page.evaluate("lean(0)")
    assert within(page, lambda: not robot.moves)
    page.keyboard.down("d")
    assert within(page, lambda: robot.moves)
    page.evaluate("dispatchEvent(new Event('blur'))")
    assert within(page, lambda: not robot.moves)
    robot.held.clear()
    page.keyboard.down("d")  # a key that is down already repeats
    moves_nothing()
    page.keyboard.up("d")
    page.keyboard.down("d")
    assert within(page, lambda: robot.moves)


@pytest.mark.parametrize(("size", "how"), [("phone", "close"), ("desk", "close"), ("phone", "hide"), ("phone", "leave"), ("desk", "blur")])  # fmt: skip
def test_a_page_that_goes_away_stops_what_it_drove(opened, robot, size, how):
    other = opened.blank()
    page = opened.page(size)
    grip(page)
    assert within(page, lambda: robot.moves)
    if how == "close":
        page.close()
    elif how == "leave":
        page.goto("about:blank")
    else:
        page.evaluate(HIDE if how == "hide" else "window.dispatchEvent(new Event('blur'))")
    assert stands(other, robot)


def test_its_own_stop_outlasts_a_thumb_that_stays_on_the_stick(opened, robot):
    page = opened.page()
    grip(page)
    assert within(page, lambda: robot.moves)
    page.keyboard.press("Escape")
    assert within(page, lambda: not robot.moves)
    held = len(robot.held)
    page.mouse.move(600, 300, steps=5)
    page.wait_for_timeout(200)
    assert (robot.moves, len(robot.held)) == (False, held)
    expect(page.locator(".drive-why")).to_contain_text("Release, then push again")
    page.mouse.up()
    expect(page.locator(".drive-why")).to_contain_text("Ready")


@both
def test_a_second_page_stops_the_first_which_must_let_go_before_it_drives_again(opened, robot, size):
    page, other = opened.page(size), opened.page(size)
    grip(page)
    assert within(page, lambda: robot.moves)
    other.get_by_role("button", name=re.compile("^Stop.* the robot")).click()
    assert within(other, lambda: not robot.moves)
    page.mouse.move(200, 300, steps=5)
    page.wait_for_timeout(300)
    assert not robot.moves
    expect(page.locator(".drive-why")).to_contain_text("Release, then push again")
    page.mouse.up()
    grip(page)
    assert within(page, lambda: robot.moves)
    page.mouse.up()


def test_space_and_escape_stop_and_escape_does_within_a_dialogue_too(opened, robot):
    page = opened.page()
    expect(page.locator(".drive-why")).to_contain_text("Ready")
    for key in ("Space", "Escape"):
        page.keyboard.press(key)
        assert within(page, lambda: ("stop", None) in robot.asked)
        robot.asked.clear()
    page.get_by_role("button", name="Settings").click()
    page.get_by_role("dialog").wait_for()
    page.keyboard.press("Escape")
    assert within(page, lambda: ("stop", None) in robot.asked)


@both
def test_stop_is_above_a_dialogue_and_held_for_a_second_it_is_the_emergency_stop(opened, robot, size):
    page = opened.page(size, path="/icon.svg", script="")
    page.clock.install(time=0)
    page.goto(page.url.replace("icon.svg", "#drive"))
    page.get_by_role("button", name="Settings").click()
    page.get_by_role("dialog").wait_for()
    stop = page.locator("#stop").bounding_box()
    assert stop is not None
    x, y = stop["x"] + stop["width"] / 2, stop["y"] + stop["height"] / 2
    assert page.evaluate("([x, y]) => document.elementFromPoint(x, y).closest('#stop') !== null", [x, y])
    assert min(stop["width"], stop["height"]) >= 60
    page.mouse.move(x, y)
    page.clock.pause_at(page.evaluate("Date.now()") / 1000 + 2)
    page.mouse.down()
    assert within(page, lambda: ("stop", None) in robot.asked)
    page.clock.run_for(990)
    assert ("estop", None) not in robot.asked
    page.clock.run_for(10)
    page.clock.resume()
    assert within(page, lambda: ("estop", None) in robot.asked)
    page.mouse.up()
    page.keyboard.press("Escape")
    expect(page.get_by_role("alert")).to_contain_text("Emergency stop is engaged")
    expect(page.get_by_role("alert")).to_contain_text("motors has not acknowledged: use the hardware switch")
    page.get_by_role("button", name="Release").click()
    page.get_by_role("dialog").get_by_role("button", name="Release").click()
    assert within(page, lambda: ("reset", None) in robot.asked)
    expect(page.get_by_role("alert")).to_have_count(0)


@both
def test_neither_a_notice_nor_a_dialogue_covers_the_alarm_of_the_emergency_stop(opened, robot, size):
    page = opened.page(size)
    page.get_by_role("button", name="Settings").click()
    page.get_by_role("dialog").wait_for()
    robot.estop = "pressed at the robot"
    expect(page.get_by_role("alert")).to_contain_text("pressed at the robot")
    page.keyboard.press("Escape")
    expect(page.locator(".notice")).to_contain_text("Stopped")
    page.get_by_role("button", name="Settings").click()
    page.get_by_role("dialog").wait_for()
    covered = """([alarm, ...others]) => others.map((one) => one.getBoundingClientRect().top - alarm.getBoundingClientRect().bottom)"""
    boxes = [page.locator(one).element_handle() for one in (".alarm-stop", ".notice", ".dialog")]
    assert within(page, lambda: min(page.evaluate(covered, boxes)) >= 0)
    page.get_by_role("button", name="Release").click()
    page.get_by_role("dialog").get_by_role("button", name="Release").click()
    assert within(page, lambda: ("reset", None) in robot.asked)


def test_on_a_phone_nothing_lies_over_the_picture_but_what_is_meant_to(opened):
    page = opened.page("phone", path="/icon.svg")
    page.route("**/stream.mjpg*", lambda route: route.fulfill(status=401))
    page.goto(page.url.replace("icon.svg", "#drive"))
    apart = """boxes => { const [a, b] = boxes.map((one) => one.getBoundingClientRect());
        return a.right <= b.left || b.right <= a.left || a.bottom <= b.top || b.bottom <= a.top; }"""
    names = [".drive-nopicture p", ".drive-inset", ".drive-stick", ".drive-gauges", "#stop"]
    boxes = [page.locator(one).element_handle() for one in names]
    for at, one in enumerate(boxes):
        for other in boxes[at + 1 :]:
            assert within(page, lambda pair=(one, other): page.evaluate(apart, list(pair)))


def test_on_a_phone_the_surroundings_are_drawn_whole_above_what_drives(opened):
    page = opened.page("phone")
    page.get_by_role("radio", name="Surroundings").click()
    apart = """(names) => { const [a, b] = names.map((name) => document.querySelector(name)?.getBoundingClientRect());
        return a?.height > 140 && (b?.bottom <= a.top + 1 || b?.top >= a.bottom - 1); }"""
    for other in (".drive-gauges", ".drive-why", ".drive-stick"):
        assert within(page, lambda pair=(".drive-radar-large", other): page.evaluate(apart, list(pair))), other


def test_the_buttons_beside_a_table_that_runs_stay_while_it_moves_and_stands(opened, robot):
    told = {
        "table": "patrol",
        "phase": "running",
        "state": "Forward",
        "reason": "",
        "code": "",
        "good": None,
        "rows": [],
    }
    names, streams = robot.capabilities, robot.streams

    def with_a_table():
        moves = time.monotonic() % 0.6 < 0.3
        found = streams()
        found["drive/state"] |= {"moving": moves, "holder": "behaviour" if moves else None}
        return found | {"behaviour/state": told}

    robot.capabilities = [*names, capability("behaviour", "behaviour", "runs", outputs(state="BehaviourState"), {})]
    robot.streams = with_a_table
    robot.rebuild(None)
    try:
        page = opened.page()
        line = page.locator(".drive-why")
        expect(line.get_by_role("button", name="Take over")).to_be_visible()
        gone = page.evaluate(
            """line => new Promise((done) => {
              let gone = 0;
              const looks = new MutationObserver((all) => { for (const one of all) gone += one.removedNodes.length + line.querySelectorAll(".drive-unseen").length; });
              looks.observe(line, { childList: true, attributes: true, subtree: true });
              setTimeout(() => { looks.disconnect(); done(gone); }, 2000);
            })""",
            line.element_handle(),
        )
        assert gone == 0
    finally:
        robot.capabilities, robot.streams = names, streams
        robot.rebuild(None)


def test_a_code_for_a_phone_that_is_over_is_renewed_on_a_press(opened, robot):
    codes = iter(["123456", "654321", "111222"])

    def with_the_word(route):
        told = route.fetch().json()
        route.fulfill(
            json=told | {"words": [*told["words"], {"word": "phone", "help": "", "role": "admin", "usage": "phone"}]}
        )

    def paired(route):
        data = {
            "digits": next(codes),
            "good_for_s": 120,
            "url": "https://192.168.1.20:50001/#pair",
            "open": True,
            "svg": "",
            "fingerprint": "",
        }
        route.fulfill(json={"code": 0, "text": "", "data": data})

    page = opened.page(path="/icon.svg", script="")
    page.clock.install()
    page.route("**/api", with_the_word)
    page.route("**/api/console", paired)
    page.goto(page.url.replace("icon.svg", "#drive"))
    page.get_by_role("button", name="Connect a phone").click()
    dialog = page.get_by_role("dialog")
    expect(dialog.get_by_text("123 456")).to_be_visible()
    page.clock.fast_forward(120_000)
    expect(dialog.get_by_text("The code was good for two minutes.")).to_be_visible()
    expect(dialog.get_by_text("123 456")).to_have_count(0)
    dialog.get_by_role("button", name="New code").click()
    expect(dialog.get_by_text("654 321")).to_be_visible()


@both
def test_a_refusal_is_told_by_its_code_and_sentence_and_who_holds_it_can_be_followed(opened, robot, size):
    page = opened.page(size)
    robot.refusal = {"code": "held", "reason": "console holds it", "holder": "console"}
    grip(page)
    expect(page.locator(".drive-why")).to_contain_text("console drives")
    page.mouse.up()
    page.get_by_role("button", name="Take over").click()
    robot.refusal = None
    grip(page)
    assert within(page, lambda: robot.moves and robot.held[-1]["message"].get("take_over") is True)
    page.mouse.up()
    robot.refusal = {"code": "obstacle", "reason": "forward reads 18 cm"}
    grip(page)
    expect(page.locator(".drive-why")).to_contain_text("forward reads 18 cm")
    page.mouse.up()


@pytest.mark.parametrize("size", ["desk", "phone"])
def test_the_stick_stays_under_the_thumb_whatever_is_said_about_it(opened, robot, size):
    page = opened.page(size)
    stick = page.locator(".drive-stick")
    expect(page.locator(".drive-why")).to_contain_text("Ready")
    before = stick.bounding_box()
    robot.refusal = {"code": "held", "reason": "console at the other end of the house holds it", "holder": "console"}
    grip(page)
    expect(page.get_by_role("button", name="Take over")).to_be_visible()
    assert stick.bounding_box() == before
    page.mouse.up()
    robot.refusal = {"code": "obstacle", "reason": "forward reads 18 cm, and that is less than it may be. " * 6}
    grip(page)
    expect(page.locator(".drive-why")).to_contain_text("forward reads 18 cm")
    assert stick.bounding_box() == before
    page.mouse.up()


def test_what_holds_the_base_still_is_the_robots_own_answer(opened, robot):
    page = opened.page("phone")
    page.get_by_role("button", name="Why?").click()
    expect(page.locator(".drive-because")).to_contain_text("Nothing holds it still")
    robot.estop = "the dog" + ", and all that it had with it" * 12
    expect(page.get_by_role("alert")).to_contain_text("the dog")
    expect(page.locator(".drive-because")).to_contain_text("latched by console@kitchen:812: the dog")
    expect(page.locator(".drive-why").get_by_role("button", name="Release")).to_be_visible()
    assert not page.evaluate(SMALL)
    begins, card = page.locator(".drive-because strong").bounding_box(), page.locator(".drive-why").bounding_box()
    assert begins is not None
    assert card is not None
    assert begins["y"] >= card["y"], "a long answer begins where it can be read"
    robot.estop = ""
    expect(page.locator(".drive-because")).to_contain_text("Nothing holds it still")
    page.get_by_role("button", name="Why?").click()
    expect(page.locator(".drive-because")).to_have_count(0)


@both
def test_moves_that_end_by_themselves_are_kept_until_they_do(opened, robot, size):
    robot.lasts_s = math.inf
    page = opened.page(size)
    page.get_by_role("button", name="Turn 90°", exact=True).click()
    assert within(page, lambda: robot.moves and robot.held[-1] == {"to": "drive/turn", "message": {"angle_deg": 90}})
    page.wait_for_timeout(350)
    assert robot.moves
    robot.stop("turned 90 degrees", "done")
    expect(page.locator(".notice")).to_contain_text("turned 90 degrees")
    page.get_by_role("button", name="Dock").click()
    assert within(page, lambda: ("console", {"line": "autodock"}) in robot.asked)


@both
def test_it_speaks_texts_and_phrases(opened, robot, size):
    page = opened.page(size)
    page.get_by_label("What the robot says").fill("Good morning")
    page.keyboard.press("Enter")
    assert within(page, lambda: ("speech/say", {"text": "Good morning"}) in robot.asked)
    page.get_by_role("button", name="follow me").click()
    assert within(page, lambda: ("speech/say", {"phrase": "follow_me", "language": "en"}) in robot.asked)


def test_what_is_old_says_so(opened, robot):
    page = opened.page(script="")
    expect(page.locator(".drive-why")).to_contain_text("Ready")
    robot.muted |= {"drive"}
    expect(page.locator(".drive-why")).to_contain_text(re.compile(r"\d s old"), timeout=6000)


def test_a_robot_that_comes_back_is_found_again(opened, robot):
    page = opened.page(script="")
    expect(page.locator('.linkdot[data-link="open"]')).to_be_visible()
    page.context.set_offline(True)
    page.evaluate("1")
    expect(page.get_by_role("alert")).to_contain_text("lost", timeout=9000)
    with page.expect_request("**/stream.mjpg*"):  # the picture, too, is of the robot that came back
        page.context.set_offline(False)
        expect(page.locator('.linkdot[data-link="open"]')).to_be_visible(timeout=9000)
    opened.errors.clear()  # the browser tells of each try


def test_who_is_unknown_pairs_by_six_digits_and_is_known_from_then_on(opened, robot):
    page = opened.page("phone", at=browsers.ELSEWHERE)
    expect(page.get_by_label("Six digits")).to_be_visible()
    expect(page.locator("#stop")).to_have_count(0)
    page.get_by_label("Six digits").fill("654321")
    page.get_by_role("button", name="Pair").click()
    expect(page.locator(".notice")).to_contain_text("digits are wrong")
    page.get_by_label("Six digits").fill("123 456")
    page.get_by_role("button", name="Pair").click()
    grip(page)
    assert within(page, lambda: robot.moves)
    page.mouse.up()
    page.reload()
    expect(page.locator(".drive-stick")).to_be_visible()
    expect(page.locator("#stop")).to_be_visible()


def test_a_role_that_only_looks_moves_nothing_and_may_stop(opened, robot):
    page = opened.page(by="eve")
    expect(page.locator(".drive-why")).to_contain_text("may look and stop")
    grip(page)
    page.keyboard.down("w")
    page.wait_for_timeout(200)
    page.keyboard.up("w")
    page.mouse.up()
    assert not robot.held
    page.locator("#stop").click()
    assert within(page, lambda: ("stop", None) in robot.asked)


@pytest.mark.parametrize("view", ["drive", "system"])
def test_each_view_fits_each_screen_and_all_in_it_has_a_name(opened, robot, view):
    page = opened.page(path=f"/#{view}")
    expect(page.locator(f'main[data-view="{view}"] h2').first).to_be_attached()
    for width, height in ((320, 568), (844, 390), (768, 1024), (1280, 800), (3840, 2160)):
        page.set_viewport_size({"width": width, "height": height})
        page.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
        assert page.evaluate("document.documentElement.scrollWidth") <= width
        assert (width, page.evaluate(UNNAMED)) == (width, [])
        assert (width, page.evaluate(SMALL)) == (width, [])


def test_who_wants_the_robot_asks_and_who_holds_it_hands_it_over(opened, robot):
    holder, other = opened.page("phone"), opened.page(by="tablet")
    grip(holder)
    assert within(holder, lambda: robot.moves)
    other.get_by_role("button", name="Ask for it").click()
    sign = holder.get_by_role("alert").filter(has_text="tablet would like to drive")
    expect(sign).to_be_visible()
    assert robot.moves, "a question ends nothing"
    sign.get_by_role("button", name="Hand over").focus()
    holder.keyboard.press("Enter")
    assert within(holder, lambda: not robot.moves)
    expect(other.locator(".notice").filter(has_text="hands over to you")).to_be_visible()
    expect(sign).to_have_count(0)
    held = len(robot.held)
    holder.mouse.move(200, 300, steps=3)
    holder.wait_for_timeout(200)
    assert len(robot.held) == held, "a thumb that stays on the stick takes nothing back"
    grip(other)
    assert within(other, lambda: robot.moves)
    other.mouse.up()


def test_what_moves_on_the_page_below_a_thumb_steers_nothing(opened, robot):
    page = opened.page("phone")
    grip(page)
    box = page.locator(".drive-stick").bounding_box()
    assert within(page, lambda: robot.held and robot.held[-1]["message"]["angle_deg"] == 0)
    page.evaluate("document.querySelector('.drive-stick').style.translate = '0 90px'")
    assert page.locator(".drive-stick").bounding_box() != box
    said = len(robot.held)
    page.mouse.move(195, 300)
    assert within(page, lambda: len(robot.held) > said)
    ahead, x = 0.32, box["x"] + box["width"] / 2
    page.mouse.move(x, box["y"] + (0.5 + ahead) * box["height"])
    assert within(page, lambda: robot.held[-1]["message"]["angle_deg"] == 180), (
        "as far below the middle as it was above"
    )
    page.mouse.up()
