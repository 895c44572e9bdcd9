"""The world's side of its cameras: starts the drawing process when there are viewers, and sends it views."""

import os
import socket
import subprocess
import sys
import threading
import time
from collections import deque
from collections.abc import Callable

import msgspec

from lbr.capability.die_with_parent import dying_with_parent
from lbr.simulation.cameras.orders import LONGEST_BYTES, Begin, Drawing, Order, SetFaults, Watch
from lbr.simulation.cameras.view import SharedView
from lbr.simulation.devices.camera import CameraFaults

_AGAIN_S = 2.0
_AGAIN_AFTER_FAILURE_S = 30.0
_ENDING_S = 0.3


class CameraHost:
    """One process for all cameras of a packed model. `watch`, `set_faults` and `show` may be called from another
    thread."""

    def __init__(self, model: bytes, view_bytes: int, clock: Callable[[], float] = time.monotonic) -> None:
        self._model = model
        self._view_bytes = view_bytes
        self._clock = clock
        self._waiting: deque[tuple[Order, socket.socket | None]] = deque()
        self._faults: dict[str, CameraFaults] = {}
        self._process: subprocess.Popen[bytes] | None = None
        self._control: socket.socket | None = None
        self._view: SharedView | None = None
        self._lock = threading.Lock()
        self._use_gl = True
        self._drawing = False
        self._not_before = 0.0

    @property
    def running(self) -> bool:
        """Return whether views are needed."""
        return self._view is not None

    def watch(self, device: str, mount: str, connection: socket.socket) -> None:
        """Hand over a client that has connected to a device."""
        self._waiting.append((Watch(device, mount), connection))

    def set_faults(self, device: str, faults: CameraFaults) -> None:
        """Set the faults of a device."""
        self._faults[device] = faults
        self._waiting.append((SetFaults(device, faults), None))

    def show(self, view: bytes, taken_s: float) -> None:
        """Set the present view of the world."""
        with self._lock:
            if self._view is not None:
                self._view.write(view, round(taken_s * 1e9))

    def serve(self) -> list[Drawing]:
        """Start the process if it is due, and send the waiting orders; return the new reports of drawing."""
        drawings = self._read_drawings()
        watched = any(connection is not None for _, connection in self._waiting)
        if self._process is None and watched and self._clock() >= self._not_before:
            self._start()
        while self._waiting:
            order, connection = self._waiting.popleft()
            self._send(order, [connection.fileno()] if connection else [])
            if connection is not None:
                connection.close()
        return drawings

    def close(self) -> None:
        """Hang up, which ends the process."""
        for _, connection in self._waiting:
            if connection is not None:
                connection.close()
        self._waiting.clear()
        self._end()

    def _start(self) -> None:
        self._not_before = self._clock() + _AGAIN_S
        view = self._view = SharedView(self._view_bytes)
        self._control, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._control.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 2 * LONGEST_BYTES)
        self._drawing = False
        with theirs:
            self._process = subprocess.Popen(
                dying_with_parent((sys.executable, "-P", "-m", "lbr.simulation.cameras", str(theirs.fileno()))),
                stdin=subprocess.DEVNULL,
                pass_fds=(theirs.fileno(),),
                env={**os.environ, "LP_NUM_THREADS": "1"},  # Mesa's software renderer would use every core
            )
        self._control.setblocking(False)
        with os.fdopen(os.memfd_create("world-model", os.MFD_CLOEXEC), "wb") as file:
            file.write(self._model)
            file.flush()
            self._send(Begin(self._view_bytes, self._use_gl), [view.descriptor, file.fileno()])
        for device, faults in self._faults.items():
            self._send(SetFaults(device, faults), [])

    def _send(self, order: Order, descriptors: list[int]) -> None:
        """Send an order, or drop it if the process is gone: a viewer then sees its connection end."""
        if self._control is None:
            return
        try:
            socket.send_fds(self._control, [msgspec.json.encode(order)], descriptors)
        except ConnectionError:
            pass  # the last report may still wait: reading it comes first, and then the end
        except OSError:
            self._end()

    def _read_drawings(self) -> list[Drawing]:
        if self._control is None or self._process is None:
            return []
        try:
            data = _received(self._control)
        except BlockingIOError:
            return []
        if data:
            drawing = msgspec.json.decode(data, type=Drawing)
            self._drawing = bool(drawing.renderer)
            if not self._drawing:
                self._not_before = self._clock() + _AGAIN_AFTER_FAILURE_S
            return [drawing]
        process = self._process
        self._end()
        if not self._drawing and process.returncode < 0:
            self._use_gl = False  # a graphics library that crashes the process is not tried again
        return []

    def _end(self) -> None:
        if self._control is not None:
            self._control.close()
        if self._process is not None:
            try:
                self._process.wait(timeout=_ENDING_S)
            except subprocess.TimeoutExpired:
                self._process.kill()
                self._process.wait()
        with self._lock:
            if self._view is not None:
                self._view.close()
            self._view = None
        self._control = self._process = None


def _received(control: socket.socket) -> bytes:
    """Return a message; empty: the other end is gone, possibly with an error."""
    try:
        return control.recv(LONGEST_BYTES)
    except ConnectionError:
        return control.recv(LONGEST_BYTES)
