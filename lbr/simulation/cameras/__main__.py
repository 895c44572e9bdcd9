"""The process that draws: `python -m lbr.simulation.cameras DESCRIPTOR`, started by a world."""

import os
import selectors
import socket
import sys
import time
from contextlib import suppress

import msgspec

from lbr.errors import LbrError
from lbr.simulation.cameras.orders import LONGEST_BYTES, Begin, Drawing, Order, SetFaults, Watch
from lbr.simulation.cameras.studio import REST_S, Studio
from lbr.simulation.cameras.view import SharedView
from lbr.simulation.cameras.viewer import Viewer
from lbr.simulation.devices.camera import CameraFaults
from lbr.simulation.physics import unpacked

_NICENESS = 15
_SLOW_S = 0.5
_SOUND = CameraFaults()


class Cameras:
    """Serves all viewers, until the world hangs up."""

    def __init__(self, control: socket.socket) -> None:
        self._control = control
        self._selector = selectors.DefaultSelector()
        self._viewers: list[Viewer] = []
        self._faults: dict[str, CameraFaults] = {}

    def run(self) -> None:
        """Begin by the world's first order, then draw for the viewers."""
        begin, descriptors = self._receive()
        if not isinstance(begin, Begin):
            return
        view = SharedView(begin.view_bytes, descriptors[0])
        with os.fdopen(descriptors[1], "rb") as file:
            file.seek(0)
            model = file.read()
        try:
            studio = Studio(unpacked(model), view, use_gl=begin.use_gl)
        except LbrError as err:
            self._control.send(msgspec.json.encode(Drawing("", str(err))))
            return
        self._control.send(msgspec.json.encode(Drawing(studio.renderer, studio.note)))
        self._selector.register(self._control, selectors.EVENT_READ)
        while self._round(studio):
            pass
        studio.close()

    def _round(self, studio: Studio) -> bool:
        due = min((viewer.due for viewer in self._viewers if viewer.due is not None), default=None)
        longest_s = REST_S if studio.holds_renderer else None
        wait_s = longest_s if due is None else max(0.0, due - time.monotonic())
        for key, events in self._selector.select(wait_s):
            if key.fileobj is self._control:
                if not self._obey(*self._receive()):
                    return False
            elif isinstance(key.data, Viewer):
                self._attend(key.data, events)
        now = time.monotonic()
        for viewer in self._viewers:
            if viewer.due is not None and now >= viewer.due and not viewer.closed:
                self._serve(viewer, studio, now)
        for viewer in [viewer for viewer in self._viewers if viewer.closed]:
            self._end(viewer)
        studio.rest(now, watched=any(viewer.looks for viewer in self._viewers))
        return True

    def _receive(self) -> tuple[Order | None, list[int]]:
        """Return an order and its descriptors; None: the world has hung up."""
        data, descriptors, _, _ = socket.recv_fds(self._control, LONGEST_BYTES, 2)
        return (msgspec.json.decode(data, type=Order) if data else None), descriptors

    def _obey(self, order: Order | None, descriptors: list[int]) -> bool:
        match order:
            case Watch(device=device, mount=mount):
                viewer = Viewer(device, mount, socket.socket(fileno=descriptors[0]))
                self._viewers.append(viewer)
                self._selector.register(viewer.connection, selectors.EVENT_READ, viewer)
            case SetFaults(device=device, faults=faults):
                self._faults[device] = faults
                for viewer in self._viewers:
                    viewer.closed |= faults.unplug and viewer.device == device
        return order is not None

    def _attend(self, viewer: Viewer, events: int) -> None:
        if events & selectors.EVENT_READ:
            viewer.receive(time.monotonic())
        if events & selectors.EVENT_WRITE and not viewer.go_on():
            self._selector.modify(viewer.connection, selectors.EVENT_READ, viewer)

    def _serve(self, viewer: Viewer, studio: Studio, now: float) -> None:
        faults = self._faults.get(viewer.device, _SOUND)
        period_s = max(viewer.period_s, _SLOW_S) if faults.slow else viewer.period_s
        viewer.due = max((viewer.due or now) + period_s, now)
        taken_ns = studio.newest_ns()
        if faults.stalled or taken_ns <= viewer.seen_ns or viewer.busy():
            return
        size = (viewer.width_px, viewer.height_px)
        viewer.send(studio.picture(viewer.device, viewer.mount, size, faults), taken_ns)
        if viewer.busy() and not viewer.closed:
            self._selector.modify(viewer.connection, selectors.EVENT_READ | selectors.EVENT_WRITE, viewer)

    def _end(self, viewer: Viewer) -> None:
        self._selector.unregister(viewer.connection)
        viewer.connection.close()
        self._viewers.remove(viewer)


if __name__ == "__main__":
    os.nice(_NICENESS)
    with suppress(ConnectionError, KeyboardInterrupt):
        Cameras(socket.socket(fileno=int(sys.argv[1]))).run()
