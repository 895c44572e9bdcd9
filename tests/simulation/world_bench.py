"""A world with a wall, two devices and a fake context, and a client of its motor line."""

import threading
import time

import serial

from lbr.capability.context import Device
from lbr.messages.sensing import ring
from lbr.simulation.cameras.host import CameraHost
from lbr.simulation.capability import World
from lbr.simulation.kind import KIND
from lbr.simulation.requests import FaultRequest
from lbr.simulation.settings import BoxSettings, WorldSettings
from lbr.simulation.trace import OutputTrace
from lbr.simulation.twins.base import Surroundings
from lbr.testing import FakeCall
from lbr.testing.driver import RealTimeContext
from tests.support.waiting import HANG_S

WALL = BoxSettings(name="wall", x_m=2.0, y_m=0.0, length_m=0.1, width_m=8.0)


class WorldContext(RealTimeContext):
    """The context of a world on real time."""

    def __init__(self, settings, devices, sensors=(), kind=KIND):
        super().__init__(kind, settings, robot="lbr", name="world", devices=devices, given=sensors)


class Client:
    """A motor line without echo."""

    def __init__(self, path):
        self.tty = serial.Serial(str(path), 115200, timeout=HANG_S, write_timeout=HANG_S, exclusive=True)
        self.tty.write(b"^ECHOF 1\r")
        assert self.tty.read_until(b"+\r").endswith(b"+\r")

    def ask(self, line):
        self.tty.write(line.encode() + b"\r")
        return self.tty.read_until(b"\r")


class Bench:
    """A world on wheels between a wall and a test; a subclass may have another."""

    def __init__(self, folder, **settings):
        self.motors_path, self.ranges_path = folder / "motors", folder / "ranges"
        self.trace_path = folder / "trace.txt"
        settings = WorldSettings(**{"walls": (WALL,), "trace": str(self.trace_path), **settings})
        devices = (
            Device("motors", "roboteq", str(self.motors_path), {}),
            Device("ranges", "ultrasonic_ring", str(self.ranges_path), {"board": "arduino"}),
        )
        self._run(World, WorldContext(settings, devices, ring(0.43, 0.30)))

    def _run(self, world, ctx):
        self.ctx, self.world = ctx, world(ctx)

    def ask(self, name, message, **more):
        call = FakeCall(name, message, **more)
        self.world.command(call)
        return call

    def fault(self, device, name, value=True):
        call = self.ask("fault", FaultRequest(device=device, name=name, value=value))
        assert not call.refused
        return call.answer

    def trace(self):
        return [line.split() for line in self.trace_path.read_text().splitlines()]

    def until(self, condition):
        """Step as the runtime would until something is true."""
        pause, end = threading.Event(), time.monotonic() + HANG_S
        while time.monotonic() < end:
            self.world.step()
            if condition():
                return True
            pause.wait(0.01)
        return False


AROUND = Surroundings(seed=1, now=0.0, trace=OutputTrace(""), cameras=CameraHost(b"", 0), mounts=("front", "rear"))
"""What a twin needs that is built without a world."""
