"""Garbage connections to a Zenoh socket: random bytes, and handshakes that are cut, bent or never finished."""

import random
import select
import socket
import tempfile
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from functools import lru_cache
from pathlib import Path

from benchmarks.fuzzing.mutation import mutated, noise
from lbr.bus import session
from lbr.errors import BusError

AT_ONCE = 16
ALIVE_EVERY = 200
ANSWER_S = 2.0
RETRY_S = 0.05


def endpoints(home: Path, robot: str) -> list[Path]:
    """Return the sockets of a running robot: local door, core, and annexes if there are any."""
    return sorted(path for path in (home / "run").glob(f"{robot}*.sock") if path.is_socket())


def assault(path: Path, n: int, dice: random.Random, report: Callable[[list[str]], None]) -> None:
    """Connect `n` times and talk nonsense; now and then see whether somebody with sense is still let in."""
    hello = handshake()
    held: list[socket.socket] = []
    for number in range(n):
        report(_connect(path, _nonsense(dice, hello), held))
        if len(held) > AT_ONCE:
            held.pop(dice.randrange(len(held))).close()
        if number % ALIVE_EVERY == 0:
            report(_talks(path, hello))
    for link in held:
        link.close()


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


def _connect(path: Path, said: bytes, held: list[socket.socket]) -> list[str]:
    link = socket.socket(socket.AF_UNIX)
    link.settimeout(ANSWER_S)
    try:
        link.connect(str(path))
    except OSError as err:
        link.close()
        return [f"{path.name} takes no connection: {err}"]
    with suppress(OSError):  # it may hang up in the middle of it
        link.sendall(said)
    held.append(link)
    return []


def _talks(path: Path, hello: bytes) -> list[str]:
    """Say hello as a client does, as often as a client does; whoever answers is alive."""
    until = time.monotonic() + ANSWER_S
    while not (answered := _answers(path, hello)) and time.monotonic() < until:
        select.select([], [], [], RETRY_S)
    return [] if answered else [f"{path.name} has not answered a client for {ANSWER_S:g} s"]


def _answers(path: Path, hello: bytes) -> bool:
    with socket.socket(socket.AF_UNIX) as link, suppress(OSError):
        link.settimeout(ANSWER_S)
        link.connect(str(path))
        link.sendall(hello)
        return bool(link.recv(1024))
    return False
