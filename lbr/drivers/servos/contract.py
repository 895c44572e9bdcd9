"""The duties of a bus of servos for the capability that drives it, and the facts known of each servo.

Positions, speeds and torque limits are the servo's own whole numbers here: what was written can then be compared with
what is read back. `ServoModel` says what they mean.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from math import inf
from typing import TYPE_CHECKING, Generic, Protocol, TypeVar

if TYPE_CHECKING:  # a guard's own program imports this, and is to start soon
    from lbr.drivers.guard import Guard

SETTING_UP = "is being set up"
UNSEEN = "was not looked for yet"
Tell = Callable[[str, str, str], None]
"""Takes the kind of an event, its text and its level; from any thread."""


class Motion(Protocol):
    """Where a servo is and what it does, as one read gives it: raw, and in SI units with counter-clockwise positive.

    A value that a servo does not report is 0: error bits, speed, load.
    """

    @property
    def error(self) -> int:
        """The error bits that came with it."""

    @property
    def position(self) -> int:
        """Return where it is."""

    @property
    def speed(self) -> int:
        """Return how fast it turns."""

    @property
    def position_rad(self) -> float:
        """Radians from the middle."""

    @property
    def speed_rps(self) -> float:
        """Radians a second."""

    @property
    def load_fraction(self) -> float:
        """Fraction of its most."""


@dataclass(frozen=True, slots=True)
class SlowState:
    """The report of a servo apart from its motion; `at` is the time. Read of one servo in each round of the poller.

    `enabled` and `goal` are to be what the servo says: by them a stop is acknowledged and the guard knows whom to hold.
    A servo that knows no speed says 0, one without a torque limit its `full_torque`.
    """

    at: float
    enabled: bool
    goal: int
    speed: int
    limit: int
    voltage_v: float
    temperature_c: float


@dataclass(frozen=True, slots=True)
class Seen:
    """One servo as it was seen last; `at` is when its motion was, and `reason` why it is not seen now."""

    motion: Motion | None = None
    at: float = -inf
    slow: SlowState | None = None
    error: int = 0
    reason: str = ""


@dataclass(frozen=True, slots=True)
class Snapshot:
    """All servos after a round of the poller; `sweep` counts the rounds from 1."""

    sweep: int
    ended: float
    servos: Mapping[int, Seen]
    sweeps_hz: float = 0.0
    states_hz: float = 0.0
    sweep_s: float = 0.0
    together: bool = False
    """True if it was read by one request."""

    @property
    def searched(self) -> bool:
        """Return whether every servo was looked for; before, nothing can be said of what has torque."""
        return all(seen.reason not in {UNSEEN, SETTING_UP} for seen in self.servos.values())


@dataclass(slots=True)
class Counts:
    """The errors of the line since it was opened. `babble` counts bytes that belong to no packet."""

    timeouts: int = 0
    corrupt: int = 0
    retries: int = 0
    strays: int = 0
    babble: int = 0


class ServoBus(Protocol):
    """Transactions on the line, one at a time, for one thread. A line that is gone is a DeviceError.

    An answer that does not come is None, and `trouble` says why. While it waits although the wire is free, the bus asks
    `urgent`, and leaves the rest undone if it says yes: `cut_short` tells then. `written_all` counts the writes to
    several servos at once.
    """

    counts: Counts
    trouble: str
    cut_short: bool
    written_all: int
    echo: bool

    @property
    def together(self) -> bool:
        """Return whether several servos are read by one request."""

    def read_motion(self, servo: int) -> Motion | None:
        """Return the motion of one servo."""

    def read_together(self, servos: tuple[int, ...]) -> Sequence[Motion | None] | None:
        """Return the motion of each, by one request; None: it was not answered at all."""

    @property
    def together_errors(self) -> bool:
        """Return whether the error bits of what is read together are the servos' own."""

    def read_state(self, servo: int, patience_s: float) -> tuple[Motion | None, SlowState] | None:
        """Return all of one servo, asked once; an answer later than wire and servo explain gets `patience_s`."""

    def write_positions(self, goals: Mapping[int, int]) -> None:
        """Give each servo a goal at the same time; the speed stays as it is. Servos are held by this, where they
        are."""

    def write_goals(self, goals: Mapping[int, tuple[int, int]]) -> None:
        """Give each servo goal and speed at the same time."""

    def write_limits(self, limits: Mapping[int, int]) -> None:
        """Give each servo its torque limit at the same time.

        Servos without one cannot fade: then nothing is written, and they are released at once when the time is over.
        """

    def torque_off(self, servos: Collection[int]) -> None:
        """Take the torque off all of them at the same time, without waiting for any."""

    def torque_on(self, servo: int, speed: int, limit: int) -> int | str:
        """Give a servo torque where it is: the goal first, then the torque. Return that position, or why not."""

    def drain(self) -> None:
        """Throw away what came unasked, and notice a line that is gone."""

    def close(self) -> None:
        """Close the line."""


class ServoModel(Protocol):
    """The meaning of these servos' numbers, and their known features."""

    @property
    def full_torque(self) -> int:
        """The highest torque limit."""

    def position_raw(self, angle_rad: float) -> int:
        """Return the position nearest to an angle, within what the servo can reach."""

    def position_rad(self, raw: int) -> float:
        """Return the angle of a position, radians from the middle, counter-clockwise positive."""

    def speed_raw(self, speed_rps: float | None) -> int:
        """Return the speed to write; None is as fast as it goes."""

    def torque_raw(self, fraction: float) -> int:
        """Return the torque limit of a fraction."""

    def holding_goal(self, position: int, speed: int, goal: int) -> int:
        """Return the goal that holds a servo where it is: its own while it rests near that, or it would sag again."""

    def most_torque(self, servo: int) -> int:
        """Return the highest torque limit that this servo may get."""

    def latched(self, servo: int, seen: Seen) -> tuple[str, ...]:
        """Return the faults that keep a servo without torque until it is recovered; `seen.slow` is there."""

    def faults(self, error: int) -> tuple[str, ...]:
        """Return the names of error bits."""


B = TypeVar("B", bound=ServoBus)


@dataclass(frozen=True, kw_only=True)
class ServoLink(Generic[B]):
    """An open line of servos, as a driver hands it to the capability.

    `prepare` sees each servo before it is polled, also one that comes back, and says what is wrong with it, or nothing;
    in the bus's thread, as `begin`, which is called once before the first servo. `guard` starts the guard. `recovery`
    returns the job that takes a servo out of its latched faults, which returns why it did not; None: there is nothing
    to do, or it was not prepared yet. `judge` is called in the loop's thread, now and then, to tell what there is to
    tell.
    """

    bus: B
    model: ServoModel
    guard: "Callable[[], Guard]"
    recovery: Callable[[int], Callable[[B], str] | None] = lambda _servo: None
    prepare: Callable[[B, int], str] = lambda _bus, _servo: ""
    begin: Callable[[B], None] = lambda _bus: None
    judge: Callable[[], None] = lambda: None
