"""One USB device, played at its end of a socket by a thread: descriptors, control transfers, bulk data."""

import errno
import select
import socket
import threading
import time
from collections import defaultdict, deque
from contextlib import suppress
from typing import Self

from tests.support.usb import usbip, vhci
from tests.support.usb.descriptors import CONFIGURATION, DEVICE, STRING, Identity
from tests.support.usb.usbip import Setup, Submit, Unlink

STALL = -errno.EPIPE
GET_STATUS, GET_DESCRIPTOR, GET_CONFIGURATION, GET_INTERFACE = 0x00, 0x06, 0x08, 0x0A
TO_DEVICE, TO_INTERFACE, TO_ENDPOINT = 0, 1, 2
TICK_S = 0.5
FREE_S = 20.0


class Function:
    """What a device is for. All is called on the device's thread."""

    identity: Identity
    configuration: bytes
    speed = vhci.FULL_SPEED

    def control(self, setup: Setup, data: bytes) -> bytes | None:
        """Answer a request of class or vendor; None: refused."""
        return None

    def out(self, endpoint: int, data: bytes) -> None:
        """Take what the host sent."""

    def watched(self) -> int | None:
        """Return the descriptor that has something for the host, if any."""
        return None

    def come(self, room: int) -> bytes:
        """Return up to `room` bytes for the host; only called when there may be some."""
        return b""

    def due(self) -> float | None:
        """Return when there will be something for the host without a descriptor that tells."""
        return None

    def closed(self) -> None:
        """Take note that the cable is out."""


class Played:
    """A device that is plugged in; `unplug` pulls the cable, `plug` puts it back."""

    def __init__(self, function: Function) -> None:
        self.function = function
        self.failure: BaseException | None = None
        self._socket: socket.socket | None = None
        self._thread: threading.Thread | None = None
        self._port = -1
        self.plug()

    def plug(self) -> None:
        """Plug it in; the kernel then takes its time to find out what it is."""
        self._port, self._socket = vhci.attach(self.function.speed)
        self._thread = threading.Thread(target=self._play, args=(self._socket,), daemon=True)
        self._thread.start()

    def unplug(self) -> float:
        """Pull the cable; return when. Waits until the kernel is through with the port."""
        at = time.monotonic()
        if self._socket is not None and self._thread is not None:
            with suppress(OSError):
                self._socket.shutdown(socket.SHUT_RDWR)
            self._thread.join(FREE_S)
            self._socket.close()
            self._socket = None
            while not vhci.is_free(self._port):
                if time.monotonic() > at + FREE_S:
                    raise RuntimeError(f"the kernel still holds port {self._port} after {FREE_S:g} s")
                time.sleep(0.01)
        if self.failure is not None:
            raise self.failure
        return at

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.unplug()

    def _play(self, end: socket.socket) -> None:
        try:
            Session(self.function, end).run()
        except OSError:
            pass  # the cable is out
        except BaseException as err:  # noqa: BLE001 - whoever unplugs it raises it again
            self.failure = err
        finally:
            self.function.closed()


class Session:
    """The time between plugging in and pulling out: what the kernel waits for, and its answers."""

    def __init__(self, function: Function, end: socket.socket) -> None:
        self._function = function
        self._end = end
        self._reader = usbip.Reader()
        self._waiting: dict[int, deque[Submit]] = defaultdict(deque)

    def run(self) -> None:
        """Play until the socket ends."""
        while True:
            function, now = self._function, time.monotonic()
            wanted, due = (function.watched(), function.due()) if self._waiting[BULK_IN] else (None, None)
            wait_s = TICK_S if due is None else min(TICK_S, max(0.0, due - now))
            ready, _, _ = select.select([self._end, *([] if wanted is None else [wanted])], [], [], wait_s)
            if self._end in ready:
                data = self._end.recv(1 << 16)
                if not data:
                    return
                for request in self._reader.feed(data):
                    self._take(request)
            if wanted in ready or (due is not None and time.monotonic() >= due):
                self._give()

    def _take(self, request: Submit | Unlink) -> None:
        if isinstance(request, Unlink):
            self._unlink(request)
        elif request.endpoint == 0:
            self._control(request)
        elif request.into_host:
            self._waiting[request.endpoint].append(request)
        else:
            self._function.out(request.endpoint, request.data)
            self._answer(request, 0, actual=len(request.data))

    def _give(self) -> None:
        waiting = self._waiting[BULK_IN]
        if waiting and (data := self._function.come(waiting[0].length)):
            self._answer(waiting.popleft(), 0, actual=len(data), data=data)

    def _control(self, request: Submit) -> None:
        found = answer(self._function, request.setup, request.data)
        if found is None:
            self._answer(request, STALL, actual=0)
        elif request.into_host:
            data = found[: request.length]
            self._answer(request, 0, actual=len(data), data=data)
        else:
            self._answer(request, 0, actual=len(request.data))

    def _unlink(self, request: Unlink) -> None:
        for waiting in self._waiting.values():
            for open_ in waiting:
                if open_.number == request.wanted:
                    waiting.remove(open_)
                    self._end.sendall(usbip.unlinked(request.number, -errno.ECONNRESET))
                    return
        self._end.sendall(usbip.unlinked(request.number, 0))

    def _answer(self, request: Submit, status: int, *, actual: int, data: bytes = b"") -> None:
        self._end.sendall(usbip.submitted(request.number, status, actual=actual, data=data))


BULK_IN = 1
"""The endpoint by which each of these devices sends, without its direction."""


def answer(function: Function, setup: Setup, data: bytes) -> bytes | None:
    """Answer a control request: the standard ones here, the others by the function; None: refused."""
    if setup.type >> 5 & 3:
        return function.control(setup, data)
    match setup.request:
        case 0x06:
            return _described(function, setup)
        case 0x00:
            return b"\0\0"
        case 0x08:
            return b"\1"
        case 0x0A:
            return b"\0"
        case _:
            return b""  # addresses, configurations, halts: taken, nothing changes


def _described(function: Function, setup: Setup) -> bytes | None:
    kind, index = setup.value >> 8, setup.value & 0xFF
    if kind == DEVICE:
        return function.identity.descriptor()
    if kind == CONFIGURATION:
        return function.configuration if index == 0 else None
    return function.identity.string(index) if kind == STRING else None
