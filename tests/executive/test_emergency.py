"""The keeper of the emergency stop on a bus of its own: what counts as a press, and what it takes back."""

import json
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from threading import Event, Thread
from types import SimpleNamespace
from typing import Any

import pytest

from lbr.bus import keys, session, wire
from lbr.executive.service import emergency
from lbr.executive.service.emergency import Emergency
from lbr.messages.system import EstopAcknowledgement, EstopState
from tests.support.waiting import HANG_S, until


class KeptStop:
    """An emergency stop with one mover, `motors`, which the test plays; its loop is turned every millisecond."""

    def __init__(self, endpoint: str) -> None:
        self.saved: list[tuple[bool, str]] = []
        self.news: list[tuple[str, str]] = []
        self.woken = 0
        self.kept = Emergency(
            "lbr",
            lambda: session.open_client([endpoint]),
            EstopState(engaged=False, reason=""),
            SimpleNamespace(happened=self._happened, trouble=lambda *_trouble: None),
            movers=lambda: ["motors"],
            seal=lambda _key: "00" * 16,
            persist=lambda engaged, reason: self.saved.append((engaged, reason)),
            wake=self._wake,
        )
        self._end = Event()
        self._thread = Thread(target=self._turn)
        self._thread.start()

    def rest(self) -> None:
        """Turn its loop no more."""
        self._end.set()
        self._thread.join()

    def close(self) -> None:
        self.rest()
        self.kept.close()

    def _happened(self, kind: str, _subject: str, text: str, _level: str) -> None:
        self.news.append((kind, text))

    def _wake(self) -> None:
        self.woken += 1

    def _turn(self) -> None:
        while not self._end.wait(0.001):
            self.kept.step(emergency.time.monotonic())


@contextmanager
def keeper(tmp_path: Path) -> Iterator[tuple[KeptStop, session.Session]]:
    endpoint = f"unixsock-stream/{tmp_path}/r.sock"
    with session.open_router(session.Router(listen=(endpoint,))), session.open_client([endpoint]) as bus:
        kept = KeptStop(endpoint)
        try:
            until(
                lambda: wire.ask(bus, keys.estop("lbr"), b"", source="tester", timeout_s=0.5), what="a press reaches it"
            )
            yield kept, bus
        finally:
            kept.close()


def acknowledge(bus: session.Session, *, engaged: bool, stopped: bool = True, within_s: float = 0.5) -> None:
    said = EstopAcknowledgement(
        capability="motors", engaged=engaged, stopped=engaged and stopped, reason="", within_s=within_s
    )
    wire.put(bus, keys.estop_acknowledgement("lbr", "motors"), said, source="motors", urgent=True)


def releasing(bus: session.Session) -> wire.ComputedReply:
    return wire.ComputedReply(bus, keys.estop_release("lbr", "motors"), lambda: {"accepted": True})


def test_a_press_that_bears_the_stamp_of_a_repetition_counts(tmp_path: Path) -> None:
    with keeper(tmp_path) as (robot, bus):
        heard = wire.Subscription(bus, keys.estop("lbr"), depth=64)
        bus.put(keys.estop("lbr"), json.dumps({"engaged": True, "reason": "a ladder"}))
        repeated: list[wire.RawMessage] = []
        until(lambda: repeated.extend(raw for raw in heard.take() if raw.attachment) or repeated, what="a repetition")
        acknowledge(bus, engaged=True)
        until(lambda: robot.kept.state().acknowledged, what="the motors stand")
        release = releasing(bus)
        until(lambda: released(robot), what="it is released")
        assert not robot.kept.state().engaged
        for one in (*repeated, *heard.take()):
            bus.put(keys.estop("lbr"), one.payload, attachment=one.attachment)
            until(lambda: robot.kept.state().engaged, what="what movers obey is latched here too")
            until(lambda: released(robot), what="it is released again")
        del release


def released(robot: KeptStop) -> bool:
    return robot.kept.release("tester", emergency.time.monotonic()) is None


def test_what_was_written_before_another_pressed_it_releases_nothing(tmp_path: Path) -> None:
    with keeper(tmp_path) as (robot, bus):
        release = releasing(bus)
        began_s = emergency.time.monotonic()
        acknowledge_soon = partial(acknowledge, bus, engaged=True)

        def press(source: str) -> None:
            robot.kept.press("a ladder", source)
            until(lambda: acknowledge_soon() or robot.kept.state().acknowledged, what="the motors stand")

        press("ann")
        until(lambda: robot.kept.release("ann", began_s) is None, what="her own press is meant")
        press("bob")
        why_not = robot.kept.release("ann", began_s)
        assert why_not is not None
        assert why_not.code == "stopped_since"
        assert robot.kept.state().engaged
        until(lambda: released(robot), what="it is released")
        del release


def test_an_acknowledgement_that_comes_before_the_next_round_is_reported(tmp_path: Path) -> None:
    with keeper(tmp_path) as (robot, bus):
        robot.rest()
        bus.put(keys.estop("lbr"), json.dumps({"engaged": True, "reason": "a ladder"}))
        until(lambda: robot.kept.state().engaged, what="it is latched")
        before = robot.woken
        acknowledge(bus, engaged=True)
        until(lambda: robot.kept.state().acknowledged, what="the motors stand")
        until(lambda: robot.woken > before, what="its next round is due at once")
        robot.kept.step(emergency.time.monotonic())
        assert [kind for kind, _ in robot.news] == ["estop", "estop_acknowledged"]


@pytest.mark.parametrize("when", ["before the movers are asked", "while they answer"])
def test_a_press_that_comes_during_a_release_wins(tmp_path: Path, monkeypatch: Any, when: str) -> None:
    with keeper(tmp_path) as (robot, bus):

        def press() -> dict[str, bool]:
            before = robot.woken
            bus.put(keys.estop("lbr"), json.dumps({"engaged": True, "reason": "a ladder"}))
            until(lambda: robot.woken > before, what="it has come")
            return {"accepted": True}

        first = when == "before the movers are asked"
        release = releasing(bus) if first else wire.ComputedReply(bus, keys.estop_release("lbr", "motors"), press)
        press()
        if first:
            monkeypatch.setattr(emergency.time, "sleep", lambda _seconds: press())
        assert not released(robot)
        assert robot.kept.state().engaged
        del release


def test_its_own_repetitions_are_no_presses_and_become_rare(tmp_path: Path, monkeypatch: Any) -> None:
    monkeypatch.setattr(emergency, "REPEAT_FOR_S", 0.2)
    with keeper(tmp_path) as (robot, bus):
        press = {"engaged": True, "reason": "a ladder"}  # said again: it may come before anybody is known to hear it
        until(lambda: bus.put(keys.estop("lbr"), json.dumps(press)) or robot.kept.state().engaged, what="it is latched")
        heard = wire.Subscription(bus, keys.estop("lbr"), depth=64)
        end = emergency.time.monotonic() + 1.5
        until(lambda: emergency.time.monotonic() > end, what="a second and a half")
        assert len(heard.take()) < 12


def test_a_stop_that_only_a_mover_heard_is_latched_and_saved(tmp_path: Path) -> None:
    with keeper(tmp_path) as (robot, bus):
        until(lambda: acknowledge(bus, engaged=True) or robot.kept.state().engaged, what="it is latched")
        assert "motors" in robot.kept.state().source
        until(lambda: robot.saved and robot.saved[-1][0], what="it is on the disk")


def test_a_latch_that_waits_to_be_saved_is_saved_when_the_robot_ends(tmp_path: Path) -> None:
    with keeper(tmp_path) as (robot, bus):
        robot.rest()
        bus.put(keys.estop("lbr"), json.dumps({"engaged": True, "reason": "a ladder"}))
        until(lambda: robot.kept.state().engaged, what="it is latched")
        assert robot.saved == []
        robot.kept.close()
        assert robot.saved == [(True, "a ladder")]


def pressed(robot: KeptStop, bus: session.Session, within_s: float) -> tuple[Thread, list[EstopState]]:
    """Press the stop of a device that is known to take so long."""
    before = robot.woken
    acknowledge(bus, engaged=False, within_s=within_s)
    until(lambda: robot.woken > before, what="how long it takes is known")
    answers: list[EstopState] = []
    thread = Thread(target=lambda: answers.append(robot.kept.press("a ladder", "tester")))
    thread.start()
    until(lambda: robot.kept.state().engaged, what="it is latched")
    return thread, answers


def test_who_pressed_is_answered_once_a_slow_device_has_acknowledged_and_meanwhile_nothing_is_alarming(
    tmp_path: Path,
) -> None:
    with keeper(tmp_path) as (robot, bus):
        began = emergency.time.monotonic()
        thread, answers = pressed(robot, bus, 9.0)
        acknowledge(bus, engaged=True, stopped=False, within_s=9.0)
        until(lambda: emergency.time.monotonic() - began > 0.8, what="longer than a device usually takes")
        state = robot.kept.state()
        assert (state.waiting, state.overdue, answers) == (("motors",), (), [])
        acknowledge(bus, engaged=True, within_s=9.0)
        thread.join(HANG_S)
        assert [(one.acknowledged, one.waiting) for one in answers] == [(("motors",), ())]
        until(lambda: "estop_acknowledged" in dict(robot.news), what="it is reported")
        assert "estop_overdue" not in dict(robot.news)


def test_a_device_that_does_not_acknowledge_in_its_time_is_an_alarm_once(tmp_path: Path) -> None:
    with keeper(tmp_path) as (robot, bus):
        thread, answers = pressed(robot, bus, 0.7)
        acknowledge(bus, engaged=True, stopped=False, within_s=0.7)
        thread.join(HANG_S)
        assert [(one.waiting, one.overdue) for one in answers] == [(("motors",), ("motors",))]
        until(lambda: "estop_overdue" in dict(robot.news), what="it is reported")
        acknowledge(bus, engaged=True, within_s=0.7)
        until(lambda: "estop_acknowledged" in dict(robot.news), what="it has at last")
        assert [kind for kind, _ in robot.news] == ["estop", "estop_overdue", "estop_acknowledged"]
