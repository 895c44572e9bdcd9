"""The contract between a servo bus and the capability that drives it, and the known values of each servo.

Positions, speeds and torque limits are the servo's own whole numbers, so that written and read values can be compared.
`ServoModel` converts them.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from math import inf
from typing import TYPE_CHECKING, Generic, Protocol, TypeVar

if TYPE_CHECKING:  # a guard's own program imports this, and has to start fast
    from lbr.drivers.guard import Guard

SETTING_UP = "is being set up"
UNSEEN = "was not looked for yet"
Tell = Callable[[str, str, str], None]
"""Queues an event by kind, text and level; from any thread."""


class Motion(Protocol):
    """Position and motion of a servo from one read: raw, and in SI units with counter-clockwise positive.

    A value that a servo does not report is 0: error bits, speed, load.
    """

    @property
    def error(self) -> int:
        """The error bits that came with it."""

    @property
    def position(self) -> int:
        """Return the raw position."""

    @property
    def speed(self) -> int:
        """Return the raw speed."""

    @property
    def position_rad(self) -> float:
        """Radians from the middle."""

    @property
    def speed_rps(self) -> float:
        """Radians a second."""

    @property
    def load_fraction(self) -> float:
        """Fraction of the maximum."""


@dataclass(frozen=True, slots=True)
class SlowState:
    """A servo's report apart from its motion; `at` is its time. The poller reads it of one servo in each round.

    `enabled` and `goal` must be the servo's own values: they acknowledge a stop, and by them the guard holds servos.
    `speed` is 0 if the servo has none, `limit` is `full_torque` if it has no torque limit.
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
    """The last reading of one servo; `at` is the time of its motion, and `reason` why it cannot be read now."""

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
    """True if one request read them all."""

    @property
    def searched(self) -> bool:
        """Return whether every servo was searched for; before that, their torque is unknown."""
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
    """Transactions on the line, one at a time, for one thread. A lost line is a DeviceError.

    A lost answer is None, and `trouble` gives the reason. While the bus waits with the wire free, it calls `urgent`; if
    that is true it skips the rest and sets `cut_short`. `written_all` counts the writes to several servos at once.
    """

    counts: Counts
    trouble: str
    cut_short: bool
    written_all: int
    echo: bool

    @property
    def together(self) -> bool:
        """Return whether one request reads several servos."""

    def read_motion(self, servo: int) -> Motion | None:
        """Return the motion of one servo."""

    def read_together(self, servos: tuple[int, ...]) -> Sequence[Motion | None] | None:
        """Return the motion of each by one request; None if that was not answered."""

    @property
    def together_errors(self) -> bool:
        """Return whether a common read returns the servos' own error bits."""

    def read_state(self, servo: int, patience_s: float) -> tuple[Motion | None, SlowState] | None:
        """Read all values of one servo once; wait up to `patience_s` for an answer that is later than wire and servo
        explain."""

    def write_positions(self, goals: Mapping[int, int]) -> None:
        """Give each servo a goal at the same time, and keep its speed; this holds servos at their position."""

    def write_goals(self, goals: Mapping[int, tuple[int, int]]) -> None:
        """Give each servo goal and speed at the same time."""

    def write_limits(self, limits: Mapping[int, int]) -> None:
        """Give each servo its torque limit at the same time.

        Servos without such a limit cannot fade: nothing is written for them, and they are released at once at the end.
        """

    def torque_off(self, servos: Collection[int]) -> None:
        """Switch the torque of all of them off at the same time, without waiting for any."""

    def torque_on(self, servo: int, speed: int, limit: int) -> int | str:
        """Switch a servo's torque on where it stands, after its goal; return that position, or the reason for a
        failure."""

    def drain(self) -> None:
        """Discard unexpected input; a lost line raises."""

    def close(self) -> None:
        """Close the line."""


class ServoModel(Protocol):
    """The units of these servos' numbers, and their known features."""

    @property
    def full_torque(self) -> int:
        """The highest torque limit."""

    def position_raw(self, angle_rad: float) -> int:
        """Return the position nearest to an angle, within the servo's range."""

    def position_rad(self, raw: int) -> float:
        """Return the angle of a position, radians from the middle, counter-clockwise positive."""

    def speed_raw(self, speed_rps: float | None) -> int:
        """Return the raw speed; None means full speed."""

    def torque_raw(self, fraction: float) -> int:
        """Return the raw torque limit for a fraction."""

    def holding_goal(self, position: int, speed: int, goal: int) -> int:
        """Return the goal that holds a servo where it is: near its goal that goal itself, or the servo would sag
        further."""

    def most_torque(self, servo: int) -> int:
        """Return the highest torque limit that this servo may have."""

    def latched(self, servo: int, seen: Seen) -> tuple[str, ...]:
        """Return the faults that keep a servo without torque until it is recovered; `seen.slow` is not None."""

    def faults(self, error: int) -> tuple[str, ...]:
        """Return the names of error bits."""


B = TypeVar("B", bound=ServoBus)


@dataclass(frozen=True, kw_only=True)
class ServoLink(Generic[B]):
    """An open line of servos, as a driver passes it to the capability.

    `prepare` checks each servo before it is polled, also after a silence, and returns the fault or an empty string.
    `begin` is called once, before the first servo. Both run in the bus's thread. `guard` starts the guard. `recovery`
    returns the job that recovers a servo, or None if there is nothing to do or no preparation yet. The job returns the
    reason for a failure, or an empty string. `judge` is called in the loop's thread, now and then, to publish events.
    """

    bus: B
    model: ServoModel
    guard: "Callable[[], Guard]"
    recovery: Callable[[int], Callable[[B], str] | None] = lambda _servo: None
    prepare: Callable[[B, int], str] = lambda _bus, _servo: ""
    begin: Callable[[B], None] = lambda _bus: None
    judge: Callable[[], None] = lambda: None
