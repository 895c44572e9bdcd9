"""A whole robot in virtual time: its capabilities as its rows plan them, on a stage; drivers and twins on lines within
this process, which carry the same bytes."""

import errno
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from lbr.bus import keys, stamp, wire
from lbr.bus.codec import Decoder
from lbr.bus.memory import MemoryQuestion
from lbr.capability import registry
from lbr.capability.calls import Answers
from lbr.capability.config import ProcessConfig
from lbr.capability.stage import ROUND_S, Stage
from lbr.drivers import i2c_socket
from lbr.drivers.mpu9150.controller import InertialUnit
from lbr.drivers.servos.bus_thread import BusThread
from lbr.drivers.servos.line import ServoLine
from lbr.errors import DeviceError
from lbr.messages.leases import CommandReply
from lbr.messages.system import EstopRelease
from lbr.simulation import plugged, twins
from lbr.simulation.loop import WorldLoop

BUS_S = 0.7 * ROUND_S
"""So much of each round a bus's thread works; its last transaction may take longer."""
LINES = (
    *(f"lbr.drivers.{name}" for name in ("roboteq.capability", "ultrasonic.capability")),
    "lbr.robots.uxa90.driver.session",
)
WORLDS = frozenset({"world", "humanoid_world"})


class MemoryPort:
    """A device's end of a line in memory."""

    def __init__(self, path: str | Path) -> None:
        self.path, self.plugged, self.rate = Path(path), False, 0
        self.heard = self.said = b""

    def plug(self) -> None:
        self.plugged = True

    def unplug(self) -> None:
        self.plugged = False
        self.heard = self.said = b""

    def fileno(self) -> int:
        return -1

    def baud(self) -> int:
        return self.rate

    def read(self) -> bytes:
        heard, self.heard = self.heard, b""
        return heard

    def write(self, data: bytes) -> int:
        self.said += data
        return len(data)


class Line(ServoLine):
    """A driver's end; while it waits, the driver's own time goes by. `written` is what left it, and when."""

    def __init__(self, robot: "WholeRobot", device: Any, baud: int, margin_s: float = 0.01) -> None:
        self.name = device.name
        self.margin_s = margin_s
        self._robot = robot
        self._owner = robot.opens = robot.owners[device.name]
        self._twin = robot.twins[device.name]
        self.written = robot.written.setdefault(device.name, [])
        self._port: MemoryPort = self._twin.port
        self.set_baud(baud)
        self._serve()

    def fileno(self) -> int:
        return -1

    def read(self, wait_s: float = 0.0) -> bytes:
        until = self._now() + wait_s
        while True:
            self._serve()
            data, self._port.said = self._port.said, b""
            left_s = until - self._now()
            if data or left_s <= 0.0:
                return data
            due = self._twin.next_due()
            self._robot.stage.spend(self._owner, left_s if due is None else min(left_s, max(due - self._now(), 1e-4)))

    def send(self, data: bytes) -> bool:
        self._serve()
        self.written.append((self._now(), data))
        self._port.heard += data
        self._serve()
        return True

    def write(self, data: bytes) -> int:
        self.send(data)
        return len(data)

    def drop_input(self) -> None:
        self._port.said = b""

    def drop_output(self) -> None:
        pass

    def low_latency(self) -> None:
        pass

    def set_baud(self, baud: int) -> None:
        self.baud = self._port.rate = baud

    def close(self) -> None:
        pass

    def _now(self) -> float:
        return self._robot.stage.time_of(self._owner)

    def _serve(self) -> None:
        self._twin.service(self._now())
        if not self._port.plugged:
            raise DeviceError(f"device '{self.name}' went away", "unplugged")


class MemorySocket(MemoryPort):
    """An i2c bus's end of a socket in memory, with one client."""

    def receive(self) -> list[tuple[int, bytes]]:
        heard = self.read()
        return [(1, heard)] if heard else []

    def send(self, _client: int, data: bytes) -> int:
        return self.write(data)


class MemoryBus(i2c_socket.SocketBus):
    """A driver's end of that; a transaction takes no time."""

    def __init__(self, robot: "WholeRobot", device: Any) -> None:
        super().__init__("")
        self._twin, owner = robot.twins[device.name], robot.owners[device.name]
        self._clock, self.wait = partial(robot.stage.time_of, owner), partial(robot.stage.spend, owner)

    def _connect(self) -> Any:
        return None

    def _transact(self, request: bytes, expected: int = 0) -> bytes:
        port = self._twin.port
        port.heard = request
        self._twin.service(self._clock())
        answer, port.said = port.said, b""
        if len(answer) != expected + 1 or answer[0]:
            raise OSError(answer[0] if answer else errno.ENODEV, "not answered")
        return answer[1:]


class WholeRobot:
    """A robot whose world, drivers, operations and apps are on a stage. `written` are the bytes to each device, with times."""

    def __init__(self, patch: pytest.MonkeyPatch, units: Mapping[str, ProcessConfig], home: Path) -> None:
        kinds = {name: registry.find(unit.kind, home) for name, unit in units.items()}
        self.stage = Stage(next(iter(units.values())).robot)
        self.written: dict[str, list[tuple[float, bytes]]] = {}
        self.twins: dict[str, Any] = {}
        self.loops: list[WorldLoop] = []
        self.threads: list[tuple[str, BusThread[Any]]] = []
        self.opens = ""
        self.owners = {
            device.name: name for name, unit in units.items() for device in unit.devices if device.name == unit.device
        }
        self._patch(patch)
        for name in sorted(units, key=lambda one: kinds[one].name not in WORLDS):
            self.stage.add(units[name], kinds[name])

    def round(self) -> None:
        """Let one round go by: for the capabilities, the world, and the threads of the buses."""
        self.stage.round()
        for loop in self.loops:
            loop.step(ROUND_S)
        for owner, thread in self.threads:
            until = self.stage.now + BUS_S
            while owner in self.stage.members and thread.failure is None and self.stage.time_of(owner) < until:
                rest_s = thread.turn()
                if rest_s is None:
                    break
                self.stage.spend(owner, min(rest_s, until - self.stage.time_of(owner)))

    def run(self, seconds: float) -> None:
        """Let time go by."""
        for _ in range(round(seconds / ROUND_S)):
            self.round()

    def ask(self, name: str, what: str, message: Any) -> Any:
        """Ask a capability, and let time go by until it has answered."""
        asked = self.stage.command(name, what, message, "test")
        while (answers := asked.answers()) is None:
            self.round()
        return answers[name]

    def close(self) -> None:
        """End all of them, the world last."""
        for member in reversed(self.stage.members.values()):
            member.loop.end()

    def reset(self) -> dict[str, bool]:
        """Release the emergency stop as the executive does, and say who agreed."""
        agreed = {}
        payload = wire.encode(EstopRelease(by="test"))
        for name, member in self.stage.members.items():
            config = member.ctx.config
            if not member.ctx.kind.moves:
                continue
            seal = stamp.make(
                "executive", 1, payload, bytes.fromhex(config.release_key), sent_s=self.stage.bus.moment()
            )
            key = keys.estop_release(self.stage.robot, name)
            asked = Answers(
                {name: MemoryQuestion(self.stage.bus, key, payload, seal, 1.0, lambda: None)}, Decoder(CommandReply)
            )
            while (answers := asked.answers()) is None:
                self.round()
            agreed[name] = bool(answers[name] and answers[name].accepted)
        return agreed

    def _patch(self, patch: pytest.MonkeyPatch) -> None:
        def make(device: Any, around: Any) -> Any:
            return self.twins.setdefault(device.name, twins.make(device, around))

        def begin(loop: WorldLoop) -> None:
            self.loops.append(loop)

        patch.setattr(plugged, "make", make)
        patch.setattr(WorldLoop, "open", begin)
        patch.setattr(BusThread, "start", lambda thread: self.threads.append((self.opens, thread)))
        patch.setattr("lbr.simulation.twins.i2c.SocketPort", MemorySocket)
        patch.setattr("lbr.simulation.twins.line.PtyPort", MemoryPort)
        for module in LINES:
            patch.setattr(f"{module}.open_line", partial(Line, self))
        patch.setattr("lbr.drivers.dynamixel.capability.open_servo_line", partial(Line, self))
        patch.setattr("lbr.drivers.mpu9150.capability.open_bus", lambda device, at: (MemoryBus(self, device), at))
        patch.setattr("lbr.drivers.mpu9150.capability.InertialUnit", lambda bus, *of: InertialUnit(bus, *of, bus.wait))
