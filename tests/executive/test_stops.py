"""Stops from the bus: answered however many come at once, and whatever does not answer them."""

import threading
import time
from io import StringIO

import pytest

from lbr.bus import stamp, wire
from lbr.executive.service import console_service
from lbr.executive.service.console_service import STOPPERS, Stops
from lbr.messages.system import ConsoleResult
from tests.support.waiting import until

DONE = ConsoleResult(code=0, text="stopped")


class Said(wire.Request):
    """A stop by one of many, and when it was answered."""

    def __init__(self, source: str) -> None:
        super().__init__("r/@console/view", b"s", stamp.make(source, 0), None)
        self.answered: ConsoleResult | None = None

    def reply(self, message, source):
        self.answered = message


class Robot:
    """Its stops wait for something that does not answer, until `let_go`."""

    def __init__(self) -> None:
        self.begun: list[str] = []
        self.over = threading.Event()
        self.stops = Stops(self._stop)
        self.stops.start()

    def _stop(self, request, _line, _role):
        self.begun.append(stamp.read(request.attachment).source)
        assert self.over.wait(20.0)
        return DONE


@pytest.fixture
def robot():
    before = set(threading.enumerate())
    robot = Robot()
    yield robot
    robot.over.set()
    robot.stops.close()
    until(lambda: set(threading.enumerate()) <= before, what="its threads end, and what they print is of this test")


def say(robot, *sources):
    requests = [Said(source) for source in sources]
    for request in requests:
        robot.stops.put(request, "s", "view")
    return requests


def test_many_stops_of_one_are_done_as_soon_as_may_be_and_all_are_answered(robot):
    requests = say(robot, *["a"] * 500)
    until(lambda: robot.begun)
    robot.over.set()
    until(lambda: all(one.answered == DONE for one in requests))
    assert len(robot.begun) < 500


def test_a_stop_that_comes_while_others_wait_is_begun_at_once(robot):
    say(robot, *(f"client {number}" for number in range(STOPPERS - 1)))
    until(lambda: len(robot.begun) == STOPPERS - 1)
    say(robot, "another")
    until(lambda: "another" in robot.begun)


def test_more_than_there_are_threads_for_are_begun_at_once_and_threads_do_not_stay(robot):
    before = threading.active_count()
    say(robot, *(f"client {number}" for number in range(5 * STOPPERS)))
    until(lambda: len(robot.begun) == 5 * STOPPERS)
    robot.over.set()
    until(lambda: threading.active_count() <= before, what="the threads end that were for these alone")
    assert say(robot, "another")
    until(lambda: "another" in robot.begun)


def test_a_machine_without_threads_still_stops(robot, monkeypatch):
    def start(_thread):
        raise RuntimeError("can't start new thread")

    monkeypatch.setattr(threading.Thread, "start", start)
    late = say(robot, *(f"client {number}" for number in range(2 * STOPPERS)))
    until(lambda: len(robot.begun) == STOPPERS)
    robot.over.set()
    until(lambda: all(one.answered == DONE for one in late))


def test_a_stop_is_never_answered_by_one_that_was_begun_before_it_came(robot):
    say(robot, "a")
    until(lambda: robot.begun == ["a"])
    say(robot, "a")
    until(lambda: robot.begun == ["a", "a"])


def test_those_that_wait_are_one_only_if_the_same_source_says_the_same(robot, monkeypatch):
    monkeypatch.setattr(console_service, "MOST_STOPPERS", STOPPERS)
    say(robot, *(f"client {number}" for number in range(STOPPERS)))
    until(lambda: len(robot.begun) == STOPPERS)
    late = say(robot, "b", "b", "c", "b")
    robot.over.set()
    until(lambda: all(one.answered == DONE for one in late))
    assert sorted(robot.begun[STOPPERS:]) == ["b", "c"]


def test_an_answer_that_cannot_be_given_costs_no_thread(robot, monkeypatch):
    told = StringIO()
    monkeypatch.setattr("sys.stderr", told)

    class Gone(Said):
        def reply(self, message, source):
            raise RuntimeError("the bus is gone")

    for _ in range(2 * STOPPERS):
        robot.stops.put(Gone("a"), "s", "view")
        time.sleep(0)
    robot.over.set()
    (last,) = say(robot, "b")
    until(lambda: last.answered == DONE)
    until(lambda: told.getvalue().count("Error: the bus is gone") == robot.begun.count("a"))
