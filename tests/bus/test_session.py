"""A leaf process's sessions under questions: real processes on a real router."""

import json
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import Self

import pytest
import zenoh

from lbr.bus import session, wire
from lbr.bus.access import Limits
from lbr.errors import BusError
from tests.support import programs
from tests.support.waiting import HANG_S, STOPS_S, until

QUESTIONS = 500
ANSWER_BYTES = 10_000
PATIENT_MS = 3000
"""Of a link: longer than a busy machine holds up an end of it."""
MORE_THAN_A_SOCKET_HOLDS = 1000
"""So many answers; the kernel keeps up to 4 MB for a socket that nobody reads."""
KEEP_ALIVE = b"\x01\x00\x04"
LEAF = f"""
import sys, time
from lbr.bus import session, wire
bus = session.open_client(sys.argv[1:])
stream = wire.Publisher(bus, "robot/drive/state", "drive")
worst_s, last = 0.0, time.monotonic()
stream.put({{"text": "x" * {ANSWER_BYTES}}})
print("ready", flush=True)
while True:
    stream.put({{"text": "x" * {ANSWER_BYTES}, "worst_s": worst_s}})
    time.sleep(0.02)
    worst_s, last = max(worst_s, time.monotonic() - last), time.monotonic()
"""
ASKER = f"""
import sys
import zenoh
from lbr.bus import session
bus = session.open_client(sys.argv[1:], lease_ms={PATIENT_MS})
print("ready", flush=True)
sys.stdin.readline()
for _ in range({MORE_THAN_A_SOCKET_HOLDS}):
    bus.get("robot/drive/state", zenoh.handlers.Callback(lambda reply: None, indirect=False), timeout={HANG_S})
sys.stdin.readline()
"""
"""An answer that comes after its question's time is dropped, and fills no socket."""


PATIENT = """
import sys
from lbr.bus import session, wire
with session.open_client(sys.argv[1:]) as bus:
    print("ready", flush=True)
    print(len(wire.ask(bus, "robot/late", None, timeout_s=30.0, source="test")), flush=True)
"""


class Deaf:
    """Stands between a client and a router; from a moment on it takes no answers, and the client goes on asking."""

    def __init__(self, router: tuple[str, int]) -> None:
        self.cut_off = self._deaf = False
        self._sockets = ExitStack()
        self._listener = self._sockets.enter_context(socket.create_server(("127.0.0.1", 0)))
        self._robot = self._sockets.enter_context(socket.socket())
        self._robot.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)  # it does not grow with what comes
        self._robot.connect(router)
        self.port = self._listener.getsockname()[1]
        threading.Thread(target=self._run, daemon=True).start()

    def listen_no_more(self) -> None:
        self._deaf = True

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self._sockets.close()

    def _run(self) -> None:
        client = self._sockets.enter_context(self._listener.accept()[0])
        threading.Thread(target=self._back, args=(client,), daemon=True).start()
        with suppress(ConnectionError):
            while passed := client.recv(65536):
                self._robot.sendall(passed)
            return
        self.cut_off = True

    def _back(self, client: socket.socket) -> None:
        with suppress(OSError), self._robot.makefile("rb") as frames:
            while not self._deaf:
                length = frames.read(2)
                client.sendall(length + frames.read(int.from_bytes(length, "little")))
            while True:
                client.sendall(KEEP_ALIVE)
                time.sleep(0.05)


@pytest.fixture
def port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as free:
        return int(free.getsockname()[1])


@pytest.fixture
def endpoint(tmp_path: Path, port: int) -> Iterator[str]:
    """A router with a leaf process that publishes fifty times a second; it listens at a port, too."""
    inside = f"unixsock-stream/{tmp_path / 'bus.sock'}"
    limits = Limits(protocols=("tcp",), bytes=1000, keys=("robot/**",), puts_hz={"robot/drive/stop": 10.0})
    router = session.Router(listen=(inside, f"tcp/127.0.0.1:{port}"), limits=limits, lease_ms=PATIENT_MS)
    with session.open_router(router), program(LEAF, inside):
        yield inside


@contextmanager
def program(text: str, *arguments: str) -> Iterator["subprocess.Popen[bytes]"]:
    """Run a program that says when it is ready."""
    pipe = subprocess.PIPE
    popen = programs.start(
        [sys.executable, "-c", text, *arguments], stdin=pipe, stdout=pipe, env=session.leaf_environment()
    )
    try:
        assert popen.stdout is not None
        assert popen.stdout.readline() == b"ready\n"
        yield popen
    finally:
        popen.kill()
        popen.communicate()


def test_many_questions_at_once_are_answered_by_a_process_that_only_leafs(endpoint: str) -> None:
    answers: list[zenoh.Reply] = []
    with session.open_client([endpoint]) as bus:
        for _ in range(QUESTIONS):
            bus.get("robot/drive/state", zenoh.handlers.Callback(answers.append, indirect=False), timeout=HANG_S)
        until(lambda: len(answers) > QUESTIONS // 2, what="most are answered")


def test_who_asks_from_another_machine_and_does_not_listen_holds_up_nobody(endpoint: str, port: int) -> None:
    with (
        Deaf(("127.0.0.1", port)) as deaf,
        session.open_client([endpoint]) as bus,
        program(ASKER, f"tcp/127.0.0.1:{deaf.port}") as asker,
    ):
        states = wire.Subscription(bus, "robot/drive/state", depth=512)
        deaf.listen_no_more()
        asker.stdin.write(b"go\n")  # type: ignore[union-attr]
        asker.stdin.flush()  # type: ignore[union-attr]
        until(lambda: deaf.cut_off, what="it is cut off")
        states.take()
        worst_s = max(json.loads(raw.payload)["worst_s"] for raw in until(states.take, what="what the leaf publishes"))
    assert worst_s < STOPS_S


def test_a_client_of_this_machine_that_is_held_up_for_a_second_still_gets_its_answer(tmp_path: Path) -> None:
    endpoint = f"unixsock-stream/{tmp_path / 'bus.sock'}"
    router = session.Router(listen=(endpoint,))
    with session.open_router(router), session.open_client([endpoint]) as bus:
        requests: list[wire.Request] = []
        server = wire.QueryServer(bus, "robot/late", lambda: requests.extend(server.take()), source="test")
        with program(PATIENT, endpoint) as client:
            until(lambda: requests, what="a question")
            client.send_signal(signal.SIGSTOP)
            held_s = time.monotonic() + 3 * session.LINK_LEASE_MS / 1000
            until(lambda: time.monotonic() > held_s)
            client.send_signal(signal.SIGCONT)
            requests[0].reply({"text": "late"}, "test")
            assert client.stdout.readline() == b"1\n"  # type: ignore[union-attr]
        server.close()


@pytest.mark.parametrize(
    ("endpoints", "client_ms", "router_ms"),
    [
        (["unixsock-stream//run/a.sock", "unixsock-stream//run/b.sock"], session.LOCAL_LEASE_MS, session.HELD_MS),
        (["tls/robot.local:7447"], session.LINK_LEASE_MS, session.LINK_LEASE_MS),
        (["unixsock-stream//run/a.sock", "tcp/robot.local:7447"], session.LINK_LEASE_MS, session.LINK_LEASE_MS),
    ],
)
def test_a_link_over_a_network_is_lost_soon_after_its_last_sign_of_life(
    endpoints: list[str], client_ms: int, router_ms: int
) -> None:
    found = session.client_settings(endpoints), session.router_settings(session.Router(listen=tuple(endpoints)))
    assert [one["transport"]["link"]["tx"]["lease"] for one in found] == [client_ms, router_ms]


DOORS = """
import os, resource, sys
resource.setrlimit(resource.RLIMIT_NOFILE, (512, 512))
from lbr.bus import session
opened = [session.open_router(session.Router(listen=(one,))) for one in sys.argv[1:]]
print("ready", flush=True)
sys.stdin.readline()
wanted = [open(os.devnull) for _ in range(256)]
print("opened", flush=True)
sys.stdin.readline()
"""


@pytest.mark.parametrize(("files", "pending", "sessions"), [(512, 32, 128), (10_000, 500, 1000), (-1, 250, 1000)])
def test_a_router_holds_no_more_than_its_share_of_the_files(
    monkeypatch: pytest.MonkeyPatch, files: int, pending: int, sessions: int
) -> None:
    monkeypatch.setattr("resource.getrlimit", lambda _: (files, files))
    unicast = session.router_settings(session.Router(listen=()))["transport"]["unicast"]
    assert (unicast["accept_pending"], unicast["max_sessions"]) == (pending, sessions)


def test_connections_that_say_nothing_leave_a_process_with_two_doors_files_to_open(tmp_path: Path) -> None:
    paths = [tmp_path / "a.sock", tmp_path / "b.sock"]
    with program(DOORS, *(f"unixsock-stream/{path}" for path in paths)) as doors, ExitStack() as stack:
        idle = [stack.enter_context(socket.socket(socket.AF_UNIX)) for _ in range(600)]
        for number, connection in enumerate(idle):
            connection.connect(str(paths[number % 2]))
            connection.setblocking(False)
        until(lambda: sum(map(_refused, idle)) >= len(idle) - 2 * 512 // session.FILES_A_PENDING, what="most refused")
        assert doors.stdin is not None
        assert doors.stdout is not None
        doors.stdin.write(b"\n")
        doors.stdin.flush()
        assert doors.stdout.readline() == b"opened\n"
        stack.close()
        until(lambda: _let_in(paths[0]), what="a client is let in afterwards")


def _refused(connection: socket.socket) -> bool:
    try:
        return not connection.recv(1, socket.MSG_PEEK)
    except BlockingIOError:
        return False
    except ConnectionResetError:
        return True


def _let_in(path: Path) -> bool:
    try:
        session.open_client([f"unixsock-stream/{path}"]).close()
    except BusError:
        return False
    return True
