"""W1: a stop by HTTP while somebody at the same address holds connections open, idle, half said or slow."""

import http.client
import socket
import tempfile
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

from tests.support.bench import let_go
from tests.support.figures import Results
from tests.support.robot import only, prepare, start
from tests.support.waiting import until

ANSWER_S = 5.0
HOST = b"Host: localhost\r\n"
BURDENS: dict[str, tuple[int, bytes]] = {
    "idle": (40, b""),
    "heads": (200, b"GET /state HTTP/1.1\r\n" + HOST + b"X-"),
    "bodies": (200, b"POST /estop/reset HTTP/1.1\r\n" + HOST + b"Content-Length: 9\r\n\r\n{"),
    "stops": (200, b"POST /stop HTTP/1.1\r\n" + HOST + b"Content-Length: 9\r\n\r\n{"),
}
"""What is held open, how often."""
EDITS = (only("uxa90", "servos", "joints", "motions", "web", "world"),)


def stops_beside(results: Results, n: int) -> None:
    """W1, `n` stops beside each burden, which is taken up again for every tenth of them."""
    with tempfile.TemporaryDirectory(prefix="lbr-") as place:
        robot = start(prepare(Path(place) / "h", edits=EDITS), profile="uxa90-sim")
        try:
            port = int(robot.web.rpartition(":")[2])
            until(lambda: _stop(port) == 200, what="a server that stops the robot")
            for name, (count, sent) in BURDENS.items():
                for at in range(0, n, 10):
                    with _burden(port, sent, count):
                        for _ in range(min(10, n - at)):
                            _measure(results, name, port)
        finally:
            let_go(robot)


def _measure(results: Results, name: str, port: int) -> None:
    began = time.monotonic()
    status = _stop(port)
    results.sample(f"W1 {name}", (time.monotonic() - began) * 1000)
    results.check("W1", [] if status == 200 else [f"a stop beside {name} was answered with {status or 'nothing'}"])


@contextmanager
def _burden(port: int, sent: bytes, count: int) -> Iterator[None]:
    with ExitStack() as stack:
        for _ in range(count):
            held = stack.enter_context(socket.create_connection(("127.0.0.1", port), timeout=ANSWER_S))
            with suppress(ConnectionError):
                held.sendall(sent)
        yield


def _stop(port: int) -> int:
    """Return how a stop was answered on a connection of its own; 0: not at all."""
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=ANSWER_S)
    try:
        connection.request("POST", "/stop")
        return connection.getresponse().status
    except (OSError, http.client.HTTPException):
        return 0
    finally:
        connection.close()
