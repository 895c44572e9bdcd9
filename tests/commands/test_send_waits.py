"""`lbr send` waits for a start that is under way: a lock that is held, without a record beside it."""

import fcntl
import os
from types import SimpleNamespace

import pytest

from lbr import home
from lbr.commands import send
from lbr.home import RunLock, Running

RECORD = Running(robot="lbr", pid=1, endpoints=(), profile="lbr-sim", database="", core="", password="")


@pytest.fixture(autouse=True)
def _home(tmp_path, monkeypatch):
    monkeypatch.setenv("LBR_HOME", str(tmp_path / "home"))
    monkeypatch.setattr(home, "_lived_in", None)


@pytest.fixture
def looks(monkeypatch):
    """Have time pass by the waits alone."""
    clock = SimpleNamespace(now=0.0, then=lambda: None)

    def sleep(seconds):
        clock.now += seconds
        clock.then()

    monkeypatch.setattr(send, "time", SimpleNamespace(monotonic=lambda: clock.now, sleep=sleep))
    return clock


def test_a_start_under_way_is_waited_for_until_it_is_reached(looks, capsys):
    lock = RunLock("lbr")
    looks.then = lambda: looks.now > 3.0 and lock.publish(RECORD)
    send.await_start(None, 10.0)
    assert 3.0 < looks.now < 3.2
    assert [one.robot for one in home.running()] == ["lbr"]
    assert capsys.readouterr().err.count("lbr is starting") == 1
    assert home.starting() == []
    lock.release()


def test_the_wait_ends_at_its_bound_and_with_the_start(looks):
    lock = RunLock("lbr")
    send.await_start("lbr", 2.0)
    assert 2.0 <= looks.now < 2.2
    looks.now, looks.then = 0.0, lock.release
    send.await_start("lbr", 2.0)
    assert looks.now < 0.2


def test_nothing_is_waited_for_where_none_that_is_meant_starts(looks):
    send.await_start(None, 10.0)
    lock = RunLock("bioloid")
    send.await_start("lbr", 10.0)
    assert looks.now == 0.0
    lock.release()


def test_the_record_of_a_run_that_was_killed_is_of_no_robot_for_those_who_look_at_once_nor_as_the_next_starts(looks):
    killed = RunLock("lbr")
    killed.publish(RECORD)
    os.close(killed._fd)
    with (home.directory("run") / "lbr.lock").open() as another:
        fcntl.flock(another, fcntl.LOCK_SH)
        assert (home.running(), home.starting()) == ([], [])
    lock = RunLock("lbr")
    assert (home.running(), home.starting()) == ([], ["lbr"])
    send.await_start("lbr", 2.0)
    assert looks.now >= 2.0
    lock.release()


def test_a_start_whose_robot_is_not_known_yet_is_waited_for_until_it_has_its_lock(looks):
    home.begin()
    assert home.starting() == [""]
    send.await_start("lbr", 1.0)
    assert looks.now >= 1.0
    lock = RunLock("lbr")
    assert home.starting() == ["lbr"]
    lock.release()
