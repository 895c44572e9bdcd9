"""What the service manager hears: ready when ready, a beat from the main loop alone, stopping at shutdown."""

import contextlib
import os
import select
import signal
import socket
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from lbr.executive.notify import Notifier
from tests.support.robot import start
from tests.support.waiting import HANG_S, until

PERIOD_S = 2.0
"""What the unit sets as WatchdogSec."""


class FakeManager:
    """The socket on which a service manager listens."""

    def __init__(self, place: Path) -> None:
        self.path = place / "notify"
        self.socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self.socket.bind(str(self.path))
        self.said: list[str] = []

    def listen(self, limit_s: float) -> list[str]:
        """Return what is said from now until it falls silent for `limit_s`."""
        news: list[str] = []
        while select.select([self.socket], [], [], limit_s)[0]:
            news += self.socket.recv(4096).decode().splitlines()
        self.said += news
        return news

    def hears(self, word: str, limit_s: float = HANG_S) -> None:
        """Wait until it has heard a line."""
        end = time.monotonic() + limit_s
        while word not in self.said and select.select([self.socket], [], [], max(0.0, end - time.monotonic()))[0]:
            self.said += self.socket.recv(4096).decode().splitlines()
        assert word in self.said, self.said


@pytest.fixture
def manager() -> Iterator[FakeManager]:
    with tempfile.TemporaryDirectory(prefix="lbr-") as place:
        fake = FakeManager(Path(place))
        with contextlib.closing(fake.socket):
            yield fake


class Clock:
    now = 100.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def notifier(manager: FakeManager, clock: Clock) -> Iterator[Notifier]:
    made = Notifier(str(manager.path), 0.5, clock)
    with contextlib.closing(made):
        yield made


def test_a_robot_says_when_it_is_ready_beats_while_its_main_loop_goes_round_and_says_when_it_stops(
    home, manager, monkeypatch
):
    """No capability is told where the service manager listens."""
    monkeypatch.setenv("NOTIFY_SOCKET", str(manager.path))
    monkeypatch.setenv("WATCHDOG_USEC", str(int(PERIOD_S * 1e6)))
    robot = start(home)
    try:
        children = [Path(f"/proc/{one['pid']}/environ") for one in robot.status()["capabilities"] if one["pid"]]
        assert children
        if os.geteuid() == 0:  # who else may look into a process that has given up being looked at?
            assert not any(b"NOTIFY_SOCKET" in path.read_bytes() for path in children)
        manager.hears("READY=1")
        manager.hears("STATUS=ready")
        os.kill(robot.popen.pid, signal.SIGSTOP)
        manager.listen(0.05)
        assert manager.listen(PERIOD_S / 2) == []
        os.kill(robot.popen.pid, signal.SIGCONT)
        manager.said.clear()
        manager.hears("WATCHDOG=1")
    finally:
        assert robot.close() == 0
    manager.listen(0.05)
    assert "STOPPING=1" in manager.said
    assert any(one.startswith("STATUS=stopping") for one in manager.said)


def test_a_start_that_takes_long_is_given_time_for_as_long_as_the_loop_goes_round(notifier, manager, clock):
    notifier.beat()
    assert "EXTEND_TIMEOUT_USEC=10000000" in manager.listen(0.0)
    notifier.ready()
    clock.now += 1.0
    notifier.beat()
    assert manager.listen(0.0) == ["READY=1", "WATCHDOG=1"]


def test_beats_are_four_to_a_period_however_often_the_loop_goes_round(notifier, manager, clock):
    notifier.ready()
    for _ in range(100):
        notifier.beat()
        clock.now += 0.02
    assert manager.listen(0.0) == ["READY=1", *["WATCHDOG=1"] * 4]


def test_a_status_is_one_line_and_said_once(notifier, manager):
    for _ in range(2):
        notifier.status("E-STOP: pressed\nREADY=0")
    assert len(manager.listen(0.0)) == 1
    assert manager.said[0].startswith("STATUS=E-STOP: pressed")


def test_a_full_queue_never_delays_and_readiness_comes_when_there_is_room(notifier, manager, clock):
    while notifier._send("WATCHDOG=1"):
        pass
    notifier.ready()
    notifier.beat()
    manager.listen(0.0)
    clock.now += 1.0
    notifier.beat()
    assert manager.listen(0.0)[0] == "READY=1"


def test_a_manager_that_is_gone_is_no_error(notifier, manager):
    manager.path.unlink()
    notifier.ready()
    notifier.beat()


@pytest.mark.parametrize(
    ("environment", "beat_s"),
    [
        ({}, float("inf")),
        ({"NOTIFY_SOCKET": "@lbr", "WATCHDOG_USEC": "2000000"}, 0.5),
        ({"NOTIFY_SOCKET": "@lbr", "WATCHDOG_USEC": "2000000", "WATCHDOG_PID": str(os.getpid())}, 0.5),
        ({"NOTIFY_SOCKET": "@lbr", "WATCHDOG_USEC": "2000000", "WATCHDOG_PID": "1"}, float("inf")),
        ({"NOTIFY_SOCKET": "@lbr", "WATCHDOG_USEC": "soon"}, float("inf")),
        ({"NOTIFY_SOCKET": "relative", "WATCHDOG_USEC": "0"}, float("inf")),
    ],
)
def test_it_takes_the_managers_words_out_of_the_environment(environment, beat_s):
    given = dict(environment) | {"PATH": "/bin"}
    made = Notifier.from_environment(given)
    assert made.beat_s == beat_s
    assert given == {"PATH": "/bin"}
    made.beat()
    made.close()


def test_an_abstract_socket_is_reached():
    with contextlib.closing(socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)) as listener:
        name = f"lbr-test-{os.getpid()}"
        listener.bind(f"\0{name}")
        with contextlib.closing(Notifier(f"@{name}", 0.5)) as made:
            made.ready()
        assert until(lambda: listener.recv(100)) == b"READY=1"
