"""Z5: bytes by chance between devices and their drivers: noise, flips, cuts, dribble, NULs, pulled cables."""

import json
import random
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import Any

from lbr.bus import wire
from lbr.simulation.devices.roboteq.device import RoboteqDevice
from lbr.simulation.devices.ultrasonic_ring import UltrasonicFaults
from lbr.simulation.devices.ultrasonic_ring.device import UltrasonicBoard
from tests.fuzzing.mutation import flipped
from tests.support.bench import let_go, temporary_home
from tests.support.figures import Results
from tests.support.hosted import OnTty
from tests.support.mover import Mover
from tests.support.robot import Robot, start
from tests.support.waiting import until

MEGABYTE = 1 << 20
BURST_S, STORM_S = 0.15, 1.2
SILENCE_S = 0.5
"""After this long without a frame the driver opens the line again, and the board starts from the beginning."""
STORM_SHARE = 0.2
BACK_S = 8.0
POWER, SLACK = 0.3, 0.002
RANGE_M = (0.2, 7.65)
MEASURED: dict[str, tuple[float, float]] = {
    "voltage_v": (0, 65),
    "internal_v": (0, 65),
    "output_v": (0, 10),
    "amps_left_a": (-300, 300),
    "amps_right_a": (-300, 300),
    "temperature_c": (-50, 150),
    "counts_left": (-(2**31), 2**31),
    "counts_right": (-(2**31), 2**31),
    "left": (-POWER - SLACK, POWER + SLACK),
    "right": (-POWER - SLACK, POWER + SLACK),
}
"""What a motor controller of this kind can measure at all."""

Spoil = Callable[[random.Random, bytes], bytes]
SPOILS: dict[str, Spoil] = {
    "noise": lambda dice, _data: dice.randbytes(4096),
    "flips": lambda dice, data: flipped(dice, data, 1 + len(data) // 40),
    "cuts": lambda dice, data: data[: dice.randint(0, len(data))],
    "drops": lambda dice, data: bytes(byte for byte in data if dice.random() < 0.95),
    "twice": lambda _dice, data: data + data,
    "nuls": lambda _dice, data: b"\x00" * 4000 + data,
    "digits": lambda dice, data: bytes(dice.choice(b"0123456789-:") if 48 <= b < 58 else b for b in data),
    "endless": lambda _dice, data: data.replace(b"\r", b"").replace(b"\n", b"") + b"9" * 2000,
}


def lines(results: Results, megabytes: float, dice: random.Random) -> None:
    """Spoil `megabytes` on their way from devices to drivers; no driver may fall over, lie, or move anything."""
    with device_lines(dice) as (robot, motors, ranges):
        pids = {unit: robot.capability(unit)["pid"] for unit in ("motors", "ranges", "drive")}
        watch = Watch(robot, results)
        sent, tries = 0, 0
        while sent < megabytes * MEGABYTE:
            line, driving = dice.choice((motors, ranges)), dice.random() < 0.5
            tries += 1
            _spoil(robot, line, results, dice, driving=driving, motors=motors)
            if tries % 10 == 0:
                _pull(robot, line, results)
            watch.look()
            results.check("Z5", motors.turned_unasked())
            sent = motors.sent + ranges.sent
        alive = {unit: robot.capability(unit)["pid"] for unit in pids}
        results.check("Z5", [] if alive == pids else [f"a driver was replaced: {robot.status()['capabilities']}"])
        results.of("Z5").checks += sent // 4096


class DeviceLine(OnTty):
    """A device on a tty, served by a thread; what it says may be spoiled on the way."""

    def __init__(self, path: Path, answer: Callable[[bytes, float], bytes], dice: random.Random) -> None:
        super().__init__(path, answer)
        self.sent = 0
        self.whole = 0
        self.spoil: Spoil | None = None
        self.present = True
        self._dice = dice

    def _serve(self) -> None:
        while not self._over.wait(0.001):
            if self.present != self._port.plugged:
                (self._port.plug if self.present else self._port.unplug)()
            heard = self._port.read()
            said = self._answer(heard, time.monotonic())
            if self.spoil is not None:
                said = self.spoil(self._dice, said)
            elif said:
                self.whole += said.count(b"\n")
            if said:
                self.sent += self._port.write(said)


class MotorLine(DeviceLine):
    """The motor controller; keeps what its outputs did although nobody asked."""

    def __init__(self, path: Path, dice: random.Random) -> None:
        self.device = RoboteqDevice()
        self.allowed = 0.0
        self._unasked: list[str] = []
        super().__init__(path, self._feed, dice)

    def turned_unasked(self) -> list[str]:
        """Return what turned faster than it was allowed, once."""
        found, self._unasked = self._unasked[:3], []
        return found

    def _feed(self, heard: bytes, now: float) -> bytes:
        said = self.device.feed(heard, now) if heard else self.device.poll(now)
        outputs = self.device.outputs(now)
        if max(abs(output) for output in outputs) > self.allowed + SLACK:
            self._unasked.append(f"the outputs were {outputs}, allowed was {self.allowed}")
        return said


@contextmanager
def device_lines(dice: random.Random) -> Iterator[tuple[Robot, MotorLine, DeviceLine]]:
    """Run a robot on devices of our own."""
    with temporary_home() as home, ExitStack() as stack:
        board = UltrasonicBoard("arduino", faults=UltrasonicFaults(noise_cm=2.0), powered_at=time.monotonic())
        board.distances_m = dict.fromkeys(("forward", "left", "right", "back"), 3.0)
        motors = stack.enter_context(MotorLine(home / "motors", dice))
        ranges = stack.enter_context(
            DeviceLine(home / "ranges", lambda heard, now: board.feed(heard, now) if heard else board.poll(now), dice)
        )
        profile = home / "fuzz.toml"
        profile.write_text(
            f'robot = "lbr"\n[devices]\nmotor_controller = "{home}/motors"\nrange_board = "{home}/ranges"\n'
        )
        robot = start(home, profile=str(profile))
        try:
            yield robot, motors, ranges
        finally:
            motors.allowed = 1.0
            let_go(robot)


class Watch:
    """Holds everything that drivers publish against what can be measured at all."""

    def __init__(self, robot: Robot, results: Results) -> None:
        self._results = results
        self._ranges = wire.Subscription(robot.bus, f"{robot.name}/ranges/readings", depth=512)
        self._motors = wire.Subscription(robot.bus, f"{robot.name}/motors/state", depth=512)

    def look(self) -> None:
        """Check what came since the last look."""
        for raw in self._ranges.take():
            self._results.check("Z5", _implausible(raw.payload, _readings(raw.payload)))
        for raw in self._motors.take():
            self._results.check("Z5", _implausible(raw.payload, MEASURED))


def _readings(payload: bytes) -> dict[str, tuple[float, float]]:
    return dict.fromkeys((name for name in json.loads(payload) if name.endswith("_m")), RANGE_M)


def _implausible(payload: bytes, bounds: dict[str, tuple[float, float]]) -> list[str]:
    said: dict[str, Any] = json.loads(payload)
    return [
        f"{name} was told to be {said[name]!r}"
        for name, (low, high) in bounds.items()
        if not all(low <= number <= high for number in _numbers(said.get(name)))
    ]


def _numbers(value: Any) -> list[float]:
    """Return what was measured: a number, several by their sensors' names, or none."""
    measured = value.values() if isinstance(value, dict) else (value,)
    return [number for number in measured if number is not None]


def _spoil(
    robot: Robot, line: DeviceLine, results: Results, dice: random.Random, *, driving: bool, motors: MotorLine
) -> None:
    """Spoil a line for a while, at rest or under way; then it must be as if nothing had been."""
    mover = _moving(robot, motors) if driving else None
    storm = dice.random() < STORM_SHARE
    feed = wire.Subscription(robot.bus, f"{robot.name}/ranges/readings")
    began = time.monotonic()
    line.spoil = dice.choice(list(SPOILS.values()))
    time.sleep(STORM_S if storm else BURST_S)
    feed.take()
    whole, line.spoil = line.whole, None
    until(feed.take, what="a reading")
    if line is not motors and time.monotonic() - began < SILENCE_S:
        results.sample("Z5 frames", line.whole - whole)
    feed.close()
    if mover is not None:
        mover.cease()
        robot.line("s")
        until(lambda: not any(motors.device.outputs(time.monotonic())), what="rest")
    motors.allowed = 0.0
    _ready(robot)


def _moving(robot: Robot, motors: MotorLine) -> Mover:
    motors.allowed = POWER
    mover = Mover(robot, 90.0, power=POWER).start(BACK_S)
    with suppress(AssertionError):  # a machine that was busy for 0.1 s has disarmed the motors: then it is at rest
        until(lambda: min(map(abs, motors.device.outputs(time.monotonic()))) > POWER / 2)
    return mover


def _pull(robot: Robot, line: DeviceLine, results: Results) -> None:
    line.present = False
    until(lambda: _phases(robot) != {"ready"}, what="a missing device told")
    line.present = True
    _ready(robot)
    results.of("Z5").checks += 1


def _phases(robot: Robot) -> set[str]:
    units = robot.line("/report/health")["data"]["capabilities"]
    return {unit["phase"] for unit in units}


def _ready(robot: Robot) -> None:
    until(lambda: _phases(robot) == {"ready"}, what="all ready")
