"""What the robot's own console shows of its start: a few lines once all is up, and the rest only if that is asked."""

import pytest
from msgspec.structs import replace

from lbr.console.greeting import Greeting
from lbr.executive.service import greeting
from lbr.messages.system import CapabilityStatus, EstopState, Event, Status
from tests.support.clients.terminal import OnTerminal
from tests.support.robot import LBR, prepare
from tests.support.waiting import HANG_S

PAGE = "http://127.0.0.1:50001/"
UP = Status(
    robot="lbr", profile="lbr-sim", ready=True, pid=1, uptime_s=1.0, estop=EstopState(engaged=False, reason=""),
    capabilities=(),
)  # fmt: skip
STARTING = replace(UP, ready=False)


def event(kind: str, subject: str = "motors", level: str = "info") -> Event:
    return Event(kind=kind, subject=subject, text="it is so", level=level)


def part(name: str, phase: str, reason: str = "") -> CapabilityStatus:
    return CapabilityStatus(
        name=name, kind="k", phase=phase, pid=None, restarts=0, uptime_s=None, reason=reason, rates_hz={}
    )


def started(*, verbose: bool = False) -> Greeting:
    return Greeting(lambda: "Page", verbose=verbose)


# -- which events are shown -------------------------------------------------------------------------------------------


def test_until_all_is_up_only_what_is_amiss_is_shown() -> None:
    console = started()
    assert not console.shows(event("ready"))
    assert not console.shows(event("degraded", level="warning"))
    assert console.shows(event("exposed", level="warning"))
    assert console.shows(event("crashed", level="error"))
    assert console.is_due(UP)
    assert console.shows(event("ready"))
    assert console.shows(event("degraded", level="warning"))


def test_who_asks_for_all_sees_each_part_come_up() -> None:
    console = started(verbose=True)
    assert console.shows(event("ready"))
    assert console.shows(event("degraded", level="warning"))
    assert console.shows(event("ready", "executive"))


def test_the_greeting_comes_once_and_again_only_when_it_is_told_anew_why_the_robot_is_not_ready() -> None:
    console = started()
    assert not console.is_due(None)
    assert not console.is_due(STARTING)
    assert not console.shows(event("not_ready", "executive", "error"))
    assert console.is_due(STARTING)
    assert not console.is_due(STARTING)
    assert not console.shows(event("ready", "executive"))
    assert not console.is_due(STARTING)
    assert console.is_due(UP)
    assert not console.is_due(UP)


# -- what it says -----------------------------------------------------------------------------------------------------


def test_where_all_is_well_it_has_two_lines(wording) -> None:
    said = greeting.lines(replace(UP, capabilities=(part("motors", "ready"),)), PAGE, "")
    assert len(said) == 2
    wording("\n".join(said))


def test_what_does_not_work_is_named_with_its_cure_and_of_many_parts_the_first(wording) -> None:
    missing = "device 'imu' is missing; plug it in"
    parts = (
        part("camera", "ready", "off"),
        part("box", "failed", "the disk is full"),
        *(part(name, "degraded", missing) for name in ("imu", "dock", "motors", "ranges", "drive")),
    )
    engaged = EstopState(engaged=True, reason="ann")
    wording("\n".join(greeting.lines(replace(UP, capabilities=parts, estop=engaged), PAGE, "")))


def test_without_a_page_it_says_why_and_offers_no_phone(wording) -> None:
    wording("\n".join(greeting.lines(UP, "", "'web' does not run: its row is disabled")))


# -- at a terminal ----------------------------------------------------------------------------------------------------


@pytest.mark.slow_start
@pytest.mark.parametrize("verbose", [False, True])
def test_a_person_who_starts_a_robot_sees_its_page_and_by_one_word_a_code_to_scan(tmp_path, verbose) -> None:
    console = OnTerminal(prepare(tmp_path / "h", "web"), [*LBR, "run", *["--verbose"] * verbose])
    try:
        console.wait_for(b"type phone, or p")
        assert b"http://127.0.0.1:" in console.said
        assert (b"motors: ready" in console.said) is verbose
        assert (b"all up after" in console.said) is verbose
        console.type(b"p\r")
        console.wait_for("▀▀▀▀▀▀▀▀▀▀".encode())
        assert b"'close' takes it back" in console.said
        assert b"asked for a code" not in console.said
        console.type(b"Shutdown\r")
        assert console.popen.wait(HANG_S) == 0
    finally:
        console.end()
