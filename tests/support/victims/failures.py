"""Ways for a process to go wrong, for the kinds beside this file."""

import ctypes
import os
import resource
import signal
import sys
import threading
from collections.abc import Callable

import psutil
from msgspec import Struct

from lbr.bus import session, wire

SPARE_BYTES = 32 << 20


class Fail(Struct, frozen=True, kw_only=True):
    """Go wrong in this way."""

    how: str


def fail(how: str, socket: str) -> None:
    """Go wrong: some ways at once, some on another thread a moment later."""
    WAYS[how](socket)


def _raise(_socket: str = "") -> None:
    raise RuntimeError("failing as asked")


def _recurse(socket: str) -> None:
    _recurse(socket)


def _hoard(_socket: str) -> None:
    used = psutil.Process().memory_info().vms
    resource.setrlimit(resource.RLIMIT_AS, (used + SPARE_BYTES, used + SPARE_BYTES))
    hoard = []
    while True:
        hoard.append(bytearray(SPARE_BYTES // 8))


def _call_back(socket: str) -> None:
    bus = session.open_client([f"unixsock-stream/{socket}"])
    wire.Subscription(bus, "lbr/victim/tick", wake=_raise)
    bus.put("lbr/victim/tick", b"{}")


def _spin(_socket: str) -> None:
    while True:
        pass


def _hold_interpreter(_socket: str) -> None:
    ctypes.PyDLL(None).sleep(60)


def _touch_nothing(_socket: str) -> None:
    ctypes.string_at(0)


def _deadlock(_socket: str) -> None:
    lock = threading.Lock()
    with lock:
        lock.acquire()


WAYS: dict[str, Callable[[str], object]] = {
    "exception": _raise,
    "exit": lambda _socket: sys.exit(3),
    "exit 0": lambda _socket: sys.exit(0),
    "thread exit": lambda _socket: threading.Thread(target=sys.exit).start(),
    "abort": lambda _socket: os.abort(),
    "segfault": _touch_nothing,
    "terminated": lambda _socket: os.kill(os.getpid(), signal.SIGTERM),
    "recursion": _recurse,
    "memory": _hoard,
    "callback": _call_back,
    "thread": lambda _socket: threading.Thread(target=_raise).start(),
    "busy": _spin,
    "interpreter": _hold_interpreter,
    "deadlock": _deadlock,
}
