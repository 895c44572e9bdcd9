"""Garbage connections to every door of a robot: random bytes, and handshakes that are cut, bent or never finished."""

import random
import select
import socket
import ssl
import tempfile
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from functools import lru_cache, partial
from pathlib import Path
from typing import NamedTuple

from lbr.bus import session
from lbr.errors import BusError
from tests.fuzzing.mutation import mutated, noise

AT_ONCE = 16
ALIVE_EVERY = 200
ANSWER_S = 3.0
RETRY_S = 0.05
PAUSE_S, MOST_UNSPOKEN = 0.15, 100


class Door(NamedTuple):
    """A way to connect, and the way in which somebody with sense would."""

    name: str
    knock: Callable[[], socket.socket]
    enter: Callable[[], socket.socket]
    pause_s: float = 0.0
    """How long the bus library takes no connection after one that failed to speak TLS."""
    most: int = 1 << 31


def doors(home: Path, robot: str, port: int) -> list[Door]:
    """Return the doors of a running robot: sockets of local door, core and annexes; TLS, from outside and within."""
    found = [Door(path.name, partial(_unix, path), partial(_unix, path)) for path in _sockets(home, robot)]
    tls = partial(_tls, port)
    return [*found, Door("within TLS", tls, tls), Door("the port", partial(_tcp, port), tls, PAUSE_S, MOST_UNSPOKEN)]


def assault(door: Door, n: int, dice: random.Random, report: Callable[[list[str]], None]) -> None:
    """Connect `n` times and talk nonsense; now and then see whether somebody with sense is still let in."""
    hello = handshake()
    held: list[socket.socket] = []
    n = min(n, door.most)
    for number in range(n):
        report(_connect(door, _nonsense(dice, hello), held))
        if len(held) > AT_ONCE:
            held.pop(dice.randrange(len(held))).close()
        if number % ALIVE_EVERY == 0:
            report(_talks(door, hello, ANSWER_S + number * door.pause_s))
    for link in held:
        link.close()
    report(_talks(door, hello, ANSWER_S + n * door.pause_s))


@lru_cache(maxsize=1)
def handshake() -> bytes:
    """Return what a real client says first."""
    with tempfile.TemporaryDirectory(prefix="lbr-") as place, socket.socket(socket.AF_UNIX) as listener:
        path = Path(place) / "s"
        listener.bind(str(path))
        listener.listen()
        thread = threading.Thread(target=_try_to_open, args=(path,), daemon=True)
        thread.start()
        link, _ = listener.accept()
        with link:
            said = link.recv(65536)
    thread.join()
    return said


def _try_to_open(path: Path) -> None:
    with suppress(BusError):
        session.open_client([f"unixsock-stream/{path}"], timeout_s=0.2).close()


def _nonsense(dice: random.Random, hello: bytes) -> bytes:
    match dice.randrange(6):
        case 0:
            return noise(dice, 4000)
        case 1:
            return hello[: dice.randrange(len(hello))]
        case 2:
            return mutated(dice, hello, times=3)
        case 3:
            return hello + noise(dice, 4000)
        case 4:
            return dice.choice((b"\xff\xff", b"\x00\x00", b"\xff\xff\xff\xff")) + noise(dice)
    return b"GET / HTTP/1.1\r\nHost: localhost\r\n\r\n"


def _connect(door: Door, said: bytes, held: list[socket.socket]) -> list[str]:
    try:
        link = door.knock()
    except (
        OSError
    ) as err:  # within TLS it may be too busy with those who came before; `_talks` sees whether it recovers
        return [] if door.name.endswith("TLS") else [f"{door.name} takes no connection: {err}"]
    with suppress(OSError):  # it may hang up in the middle of it
        link.sendall(said)
    held.append(link)
    return []


def _talks(door: Door, hello: bytes, patience_s: float) -> list[str]:
    """Say hello as a client does, as often as a client does; whoever answers is alive."""
    until = time.monotonic() + patience_s
    while not (answered := _answers(door, hello)) and time.monotonic() < until:
        select.select([], [], [], RETRY_S)
    return [] if answered else [f"{door.name} has not answered a client for {patience_s:g} s"]


def _answers(door: Door, hello: bytes) -> bool:
    with suppress(OSError), door.enter() as link:
        link.sendall(hello)
        return bool(link.recv(1024))
    return False


def _sockets(home: Path, robot: str) -> list[Path]:
    return sorted(path for path in (home / "run").glob(f"{robot}*.sock") if path.is_socket())


def _unix(path: Path) -> socket.socket:
    link = socket.socket(socket.AF_UNIX)
    link.settimeout(ANSWER_S)
    try:
        link.connect(str(path))
    except OSError:
        link.close()
        raise
    return link


def _tcp(port: int) -> socket.socket:
    return socket.create_connection(("127.0.0.1", port), timeout=ANSWER_S)


def _tls(port: int) -> socket.socket:
    context = ssl.create_default_context()
    context.check_hostname, context.verify_mode = False, ssl.CERT_NONE
    return context.wrap_socket(_tcp(port))
