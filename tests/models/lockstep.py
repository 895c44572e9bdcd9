"""World, range board, driver's parser and drive kernel in lockstep: no processes, no clocks but its own, late on purpose.

The bytes are the board's, at its own pace and 115200 baud; the decisions are the kernel's. What lies between is taken
as late as it was ever seen on a busy machine: each hop over the bus takes `HOP_S`, the range driver looks at its port
each `LOOK_S`, the kernel beats 50 times a second, and a setpoint turns into power `MOTOR_S` after it came.
"""

import heapq
from itertools import count
from math import cos, hypot, sin
from random import Random

from msgspec.structs import replace

from lbr.drivers.ultrasonic import UltrasonicSettings
from lbr.drivers.ultrasonic.protocol import Frame, LineParser, to_ranges
from lbr.leases.lease import Reply, Result, Setpoint
from lbr.messages.drive import DriveCommand, GoalResult
from lbr.messages.motors import MotorsState
from lbr.operations.drive.kernel import decide, first_state
from lbr.operations.drive.settings import DriveSettings
from lbr.operations.drive.state import Command, Event, MotorsSeen, RangesSeen, Tick
from lbr.simulation.devices.ultrasonic_ring import UltrasonicFaults
from lbr.simulation.devices.ultrasonic_ring.device import UltrasonicBoard
from lbr.simulation.engine import Engine
from lbr.simulation.messages import WorldBox
from lbr.simulation.model import TIMESTEP_S
from lbr.simulation.settings import WorldSettings

HOP_S = 0.010
"""A message from one process to another; 7 ms at most were seen beside four busy loops."""

LOOK_S = 0.010
BEAT_S = 0.020
MOTOR_S = 0.012
"""Writing the setpoint, its bytes on the line, and the controller's own cycle."""

RENEW_S = 0.1
MOTORS_S = 0.02
RANGES = UltrasonicSettings(device="range_board", board="parallax")
ARMED = MotorsState(left=0.0, right=0.0, armed=True, reason="", estop=False)

Point = tuple[float, float]


class Lockstep:
    """A robot that moves by `DriveCommand`s and stops by its rules; `random` gives the phases of all its loops.

    `power` is what the motors have now; `refusal` is why the newest command was refused.
    """

    def __init__(self, world: WorldSettings, drive: DriveSettings, random: Random) -> None:
        self.engine = Engine(world)
        self.now = 0.0
        self.power = (0.0, 0.0)
        self.refusal = ""
        self.results: list[GoalResult] = []
        self._state = first_state(drive)
        self._random = random
        self._board = UltrasonicBoard(
            RANGES.board, seed=random.randrange(1 << 30), powered_at=-random.uniform(0.0, 0.15)
        )
        self._parser = LineParser()
        self._bytes = b""
        self._order = count()
        self._due: list[tuple[float, int, Event | Setpoint]] = []
        self._loops = ((LOOK_S, self._look), (BEAT_S, self._tick), (MOTORS_S, self._motors), (RENEW_S, self._renew))
        self._next = [random.uniform(0.0, period_s) for period_s, _ in self._loops]
        self._wanted: DriveCommand | None = None
        self._lease = ""

    @property
    def halted(self) -> bool:
        """Whether both motors are without power."""
        return self.power == (0.0, 0.0)

    def drive(self, power: float, angle_deg: float) -> None:
        """Drive from now on, by a lease that is renewed; a refused command is tried again."""
        self.ask(DriveCommand(power=power, angle_deg=angle_deg))

    def ask(self, wanted: DriveCommand | None) -> None:
        """Ask for a motion from now on, or for nothing more."""
        self._wanted, self.refusal = wanted, ""
        self._renew()

    def fault(self, faults: UltrasonicFaults) -> None:
        """Let the range board fail."""
        self._board.faults = faults

    def run(self, seconds: float) -> None:
        """Let time pass."""
        until = self.now + seconds - 1e-9
        while self.now < until:
            self.step()

    def step(self) -> None:
        """Run one step of the physics, and all that falls due within it."""
        self.now += TIMESTEP_S
        self.engine.step(*self.power, TIMESTEP_S)
        self._board.distances_m = self.engine.ranges_m
        self._bytes += self._board.poll(self.now)
        for index, (period_s, work) in enumerate(self._loops):
            while self._next[index] <= self.now:
                self._next[index] += period_s
                work()
        while self._due and self._due[0][0] <= self.now:
            self._arrive(heapq.heappop(self._due)[2])

    def _look(self) -> None:
        heard, self._bytes = self._bytes, b""
        for frame in self._parser.feed(heard):
            if isinstance(frame, Frame):
                self._send(RangesSeen(ranges=to_ranges(frame, RANGES), arrived=self.now + HOP_S), HOP_S)

    def _motors(self) -> None:
        self._decide(MotorsSeen(motors=ARMED, arrived=self.now))

    def _tick(self) -> None:
        self._decide(Tick())

    def _renew(self) -> None:
        wanted = self._wanted
        if wanted is None:
            return
        known = self._state.lease.id if self._state.lease else ""
        command = replace(wanted, lease=known)
        named = f"lease-{next(self._order)}"
        self._decide(Command(command=command, source="approach", new_lease=named, new_goal=named, received=self.now))

    def _decide(self, event: Event) -> None:
        self._state, outputs = decide(self._state, event, self.now)
        for output in outputs:
            if isinstance(output, Setpoint):
                self._send(output, HOP_S + MOTOR_S)
            elif isinstance(output, Reply):
                self.refusal = "" if output.message.accepted else output.message.reason
            elif isinstance(output, Result):
                self.results.append(output.message)
                self._wanted = None

    def _send(self, what: Event | Setpoint, after_s: float) -> None:
        heapq.heappush(self._due, (self.now + after_s, next(self._order), what))

    def _arrive(self, what: Event | Setpoint) -> None:
        if not isinstance(what, Setpoint):
            self._decide(what)
            return
        self.power = (what.message.left, what.message.right)


def corners(x_m: float, y_m: float, yaw_rad: float, length_m: float, width_m: float) -> list[Point]:
    """Return the corners of a rectangle, anticlockwise."""
    c, s, ahead, aside = cos(yaw_rad), sin(yaw_rad), length_m / 2, width_m / 2
    local = ((ahead, aside), (-ahead, aside), (-ahead, -aside), (ahead, -aside))
    return [(x_m + c * x - s * y, y_m + s * x + c * y) for x, y in local]


def box_corners(box: WorldBox) -> list[Point]:
    """Return the corners of a box."""
    return corners(box.x_m, box.y_m, box.yaw_rad, box.length_m, box.width_m)


def gap_m(one: list[Point], other: list[Point]) -> float:
    """Return how far two convex outlines are apart; 0 where a corner of one is in the other."""
    if any(_inside(point, other) for point in one) or any(_inside(point, one) for point in other):
        return 0.0
    pairs = [(point, outline) for outline, points in ((other, one), (one, other)) for point in points]
    return min(_to_edge(point, outline[i - 1], outline[i]) for point, outline in pairs for i in range(len(outline)))


def _inside(point: Point, outline: list[Point]) -> bool:
    edges = ((outline[i - 1], outline[i]) for i in range(len(outline)))
    return all((b[0] - a[0]) * (point[1] - a[1]) - (b[1] - a[1]) * (point[0] - a[0]) >= 0.0 for a, b in edges)


def _to_edge(point: Point, a: Point, b: Point) -> float:
    dx, dy = b[0] - a[0], b[1] - a[1]
    share = max(0.0, min(1.0, ((point[0] - a[0]) * dx + (point[1] - a[1]) * dy) / (dx * dx + dy * dy)))
    return hypot(point[0] - a[0] - share * dx, point[1] - a[1] - share * dy)
