"""The real server on a real port, in a loop like its process's, with a robot that is nothing but answers."""

import http.client
import json
import socket
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import Any

from websockets.exceptions import ConnectionClosed
from websockets.sync.connection import Connection

from lbr.apps.web.capability import Web
from lbr.apps.web.face import Face
from lbr.apps.web.kind import WebSettings
from lbr.capability.context import Received
from lbr.errors import DeviceError
from lbr.messages.leases import CommandReply
from lbr.messages.rows import Row
from tests.support.rows import given
from tests.support.waiting import HANG_S

UPGRADE = (
    b"GET %s HTTP/1.1\r\nHost: localhost\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n"
    b"Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
)
REQUESTS = ("move", "halt", "torque", "play", "stop_motion", "take_control", "edit", "estop_reset")


class PendingReply:
    def __init__(self, name: str, answer: Any) -> None:
        self._answers = {name: answer}

    def answers(self) -> dict[str, Any]:
        return self._answers


class Stage:
    """What the server has of its robot. `answer` answers what it asks, in the loop."""

    name, robot, on_tick, simulated = "web", "uxa90", True, True

    def __init__(self, settings: WebSettings, users: tuple[Any, ...] = ()) -> None:
        self.settings, self.given = settings, users
        self.asked: list[tuple[str, Any]] = []
        self.events: list[tuple[str, str, str]] = []
        self.event_data: list[tuple[str, Any]] = []
        self.published: dict[str, Any] = {}
        self.engaged: list[str] = []
        self.warned: list[str] = []
        self.came: dict[str, list[Received]] = {}
        self.dead: set[str] = set()
        self.inputs: dict[str, Received] = {}
        self.wired = set(REQUESTS)
        self.answer: Callable[[str, Any], Any] = lambda _request, _message: CommandReply(accepted=True)
        self.woken = threading.Event()

    def clock(self) -> float:
        return time.monotonic()

    def wake(self) -> None:
        self.woken.set()

    def latest(self, port: str) -> Received | None:
        return self.inputs.get(port)

    def take(self, port: str) -> list[Received]:
        return self.came.pop(port, [])

    def alive(self, capability: str) -> bool:
        return capability not in self.dead

    def bring(self, port: str, source: str, message: Any, *, age_s: float = 0.0) -> None:
        """Have a message come to an input."""
        last = Received(message, None, time.monotonic() - age_s, source)
        self.came[port] = [*self.came.get(port, []), last]

    def targets(self, request: str) -> tuple[str, ...]:
        return ("joints",) if request in self.wired else ()

    def ask(self, request: str, message: Any, timeout_s: float, *, only: Any = None) -> PendingReply:
        self.asked.append((request, message))
        return PendingReply("joints", self.answer(request, message))

    def event(
        self, kind: str, text: str, *, level: str = "info", data: Any = None, code: str = "", about: str = ""
    ) -> None:
        self.events.append((kind, text, level))
        self.event_data.append((kind, data))

    def warn(self, reason: str, code: str = "failed") -> None:
        self.warned.append(reason)

    def publish(self, output: str, message: Any) -> None:
        self.published[output] = message

    def rows(self, row: type[Row]) -> tuple[Any, ...]:
        return given(*self.given)(row)

    def adopt(self, rows: Iterable[Row]) -> None:
        new = {(type(one), one.key): one for one in rows}
        self.given = (*(one for one in self.given if (type(one), one.key) not in new), *new.values())

    def engage_estop(self, reason: str) -> None:
        self.engaged.append(reason)

    def say(self, port: str, message: Any) -> None:
        self.inputs[port] = Received(message, None, time.monotonic(), "test")


class Served:
    """A running server and its port."""

    def __init__(self, stage: Stage, web: Web) -> None:
        self.stage, self.web = stage, web
        self.port = web._front.place.port

    @property
    def connections(self) -> int:
        """Return how many connections are open."""
        return self.web._front.connections

    def ask(
        self,
        method: str,
        path: str,
        body: Any = None,
        headers: dict[str, str] | None = None,
        *,
        host: str = "127.0.0.1",
    ) -> "Answer":
        connection = http.client.HTTPConnection(host, self.port, timeout=8)
        given = dict(headers or {})
        if body is not None and not isinstance(body, bytes):
            body = json.dumps(body).encode()
            given = {"Content-Type": "application/json"} | given
        try:
            connection.request(method, path, body, given)
            response = connection.getresponse()
            return Answer(response.status, dict(response.getheaders()), response.read())
        finally:
            connection.close()

    def raw(self, sent: bytes) -> bytes:
        with socket.create_connection(("127.0.0.1", self.port), timeout=8) as client:
            client.sendall(sent)
            parts = []
            while part := client.recv(65536):
                parts.append(part)
        return b"".join(parts)


class Answer:
    def __init__(self, status: int, headers: dict[str, str], body: bytes) -> None:
        self.status, self.body = status, body
        self.headers = {name.lower(): value for name, value in headers.items()}

    @property
    def json(self) -> Any:
        return json.loads(self.body)

    @property
    def said(self) -> str:
        return self.json["message"]


def ending(viewer: Connection) -> tuple[int | None, str]:
    """Read a stream to its end, and return how it was closed; no code if it was cut."""
    try:
        while True:
            viewer.recv(timeout=HANG_S)
    except ConnectionClosed as closed:
        return (closed.rcvd.code, closed.rcvd.reason) if closed.rcvd is not None else (None, "")


@contextmanager
def serving(
    *faces: Face,
    users: tuple[Any, ...] = (),
    rows: Any = None,
    simulated: bool = True,
    bus: Any = None,
    make: Callable[[WebSettings, tuple[Any, ...]], Stage] = Stage,
    **settings: Any,
) -> Iterator[Served]:
    """Serve faces with these settings until the end of a `with`; `rows` are a robot's, for faces that need them.

    `bus` is what the API has of the robot's.
    """
    stage = make(WebSettings(**{"port": 0, "announce": False, **settings}), users)
    stage.simulated = simulated
    if rows is not None:
        stage.given = (*users, *rows.joints, *rows.motors, *rows.buttons)
        stage.given += tuple(row for motion in rows.motions for row in motion.rows)
    web = Web(stage)  # type: ignore[arg-type]
    web._open_bus = lambda: bus  # type: ignore[method-assign]
    for face in faces:
        web._faces.add(face)
    ended = threading.Event()
    opened = threading.Event()
    troubles: list[BaseException] = []

    def loop() -> None:
        try:
            web.open()
            opened.set()
            while not ended.is_set():
                web.step()
                stage.woken.wait(0.02)
                stage.woken.clear()
        except (DeviceError, AssertionError) as err:
            troubles.append(err)
        finally:
            opened.set()
            web.close()

    thread = threading.Thread(target=loop)
    thread.start()
    opened.wait(HANG_S)
    try:
        if troubles:
            raise troubles[0]
        yield Served(stage, web)
    finally:
        ended.set()
        stage.wake()
        thread.join(HANG_S)
        assert not thread.is_alive()
