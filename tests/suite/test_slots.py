"""Whole robots take turns: who has one keeps it while a robot of theirs runs, and who waits loses no time by it."""

import fcntl
import os
import select
import sys

import pytest

from tests.suite.test_suite import run
from tests.support import programs, slots
from tests.support.robot import until

WAITS = """
import os
import threading
from pathlib import Path

import pytest

from tests.support import slots

@pytest.mark.timeout(0.5)
def test_that_waits_for_its_turn():
    another = slots._free(Path(os.environ[slots.PLACE]))
    threading.Timer(1.0, os.close, (another,)).start()
    slots.take()
    assert slots.waited_s > 0.5
"""


TAKES = "from tests.support import slots; slots.take(); print('had', flush=True); slots.give_back()"


@pytest.fixture
def place(tmp_path, monkeypatch):
    """One turn, which nobody has."""
    (tmp_path / "slots").mkdir()
    monkeypatch.setenv(slots.PLACE, "")
    slots.make(tmp_path / "slots", 1)
    monkeypatch.setattr(slots, "_held", None)
    monkeypatch.setattr(slots, "_robots", [])
    return tmp_path / "slots"


def free(place):
    """Say whether another process would get a turn."""
    found = slots._free(place)
    if found is not None:
        os.close(found)
    return found is not None


def test_a_turn_lasts_until_the_last_robot_of_the_process_has_ended(place):
    slots.take()
    first, second = (programs.start(["/bin/sleep", "60"]) for _ in range(2))
    try:
        for robot in (first, second):
            slots.take()  # who has a turn waits for none
            slots.has(robot)
        first.kill()
        first.wait()
        slots.give_back()
        assert not free(place)
    finally:
        second.kill()
        second.wait()
    slots.give_back()
    assert free(place)


def test_a_process_that_ended_has_no_turn_any_more(place):
    assert free(place)
    holder = programs.start(["/bin/sh", "-c", f"exec 9<'{place}/slot0'; flock 9; echo; exec sleep 60"], stdout=-1)
    try:
        holder.stdout.read(1)
        assert not free(place)
    finally:
        holder.kill()
        holder.wait()
        holder.stdout.close()
    assert free(place)


def test_who_gives_a_turn_back_does_not_take_it_from_one_that_waits(place):
    slots.take()
    waits = programs.start([sys.executable, "-c", TAKES], stdout=-1)
    try:
        until(lambda: queued(place), what="another waits")
        slots.give_back()
        slots.take()
        assert select.select([waits.stdout], [], [], 0.0)[0], "it has had its turn before"
    finally:
        waits.kill()
        waits.wait()
        waits.stdout.close()


def queued(place):
    with (place / slots.QUEUE).open("w") as queue:
        try:
            fcntl.flock(queue, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            return True
    return False


def test_without_turns_nothing_waits(monkeypatch):
    monkeypatch.delenv(slots.PLACE, raising=False)
    monkeypatch.setattr(slots, "_held", None)
    slots.take()
    assert slots._held is None


@pytest.mark.timeout(40)
def test_the_time_that_a_test_waits_for_its_turn_is_not_taken_from_it(place, tmp_path):
    code, said = run(tmp_path, WAITS)
    assert code == 0, said
