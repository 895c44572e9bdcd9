"""Bounded moves end, the emergency stop holds, and nobody but its owner moves a motor."""

import json
from collections.abc import Callable
from typing import Any

import pytest

from lbr.bus import session, stamp
from tests.scenarios import bounds, estop, writers
from tests.support.bench import Bench
from tests.support.figures import Results
from tests.support.waiting import HANG_S, until

Held = Callable[[Callable[[Bench], None]], Results]


def test_a_timed_move_ends(held: Held):
    assert held(bounds.interval).of("S18 interval").n >= 1


def test_a_move_to_a_range_ends_when_it_is_crossed(held: Held):
    assert held(bounds.range_crossed).of("S18 range").n == 1


@pytest.mark.parametrize("press", [estop.by_console, estop.by_put], ids=lambda press: press.__name__)
def test_an_emergency_stop_stops_and_its_reset_moves_nothing(held: Held, press):
    assert held(press).of("S14").n == 1


def test_setpoints_of_strangers_move_nothing(held: Held):
    assert held(writers.foreign_setpoints).of("F7").n == 3


def test_a_second_run_is_refused(held: Held):
    assert held(writers.second_run).of("F7").n == 1


def test_a_second_opener_of_the_tty_is_refused(held: Held):
    assert held(writers.second_opener).of("F7").n == 1


def test_recorded_commands_move_nothing_on_the_same_connection_and_on_another(held: Held):
    assert held(recorded_commands).of("S14").n == 1


def recorded_commands(under_test: Bench) -> None:
    """Drive, stop, and say again byte for byte what made it drive."""
    said = until(lambda: _drove(under_test))
    under_test.answer("drive/stop", {})
    under_test.until(lambda: under_test.trace.now().zero, HANG_S, "rest")
    zero = under_test.trace.now()
    another = session.open_client(under_test.robot.endpoints)
    try:
        answers = [_say(bus, under_test, *one) for one in said for bus in (under_test.robot.bus, another)]
    finally:
        another.close()
    under_test.pass_time(0.1)
    assert [answer["accepted"] for answer in answers] == [False] * 4
    under_test.stays_at_rest(zero)


def _drove(under_test: Bench) -> list[tuple[bytes, bytes]]:
    """Drive until the motors turn, and return what was said; nothing where a busy machine held it up."""
    said = [(b'{"power": 0.4, "take_over": true}', stamp.make("recorded", 0))]
    answer = _say(under_test.robot.bus, under_test, *said[0])
    if not answer["accepted"]:
        return []
    said.append((b'{"power": 0.4, "lease": "%s"}' % answer["lease"].encode(), stamp.make("recorded", 0)))
    if not _say(under_test.robot.bus, under_test, *said[1])["accepted"]:
        return []
    until(lambda: not under_test.trace.now().zero or under_test.answer("drive/state")["holder"] is None)
    return [] if under_test.trace.now().zero else said


def _say(bus: session.Session, under_test: Bench, payload: bytes, attachment: bytes) -> dict[str, Any]:
    replies = bus.get(f"{under_test.robot.name}/drive/command", payload=payload, attachment=attachment, timeout=HANG_S)
    return json.loads(next(iter(replies)).ok.payload.to_bytes())
