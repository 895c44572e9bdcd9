"""The objects that live as long as a line of servos is open: the bus, its thread, the poller, the orders, the guard."""

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any, Generic, Protocol, TypeVar

from lbr.capability.context import Context
from lbr.drivers.guard import Guard
from lbr.drivers.servos import ServosSettings
from lbr.drivers.servos.bus_thread import BusThread
from lbr.drivers.servos.contract import B, Counts, ServoLink, Tell
from lbr.drivers.servos.poller import Poller
from lbr.drivers.servos.rest import Rest
from lbr.drivers.servos.targets import ServoTargets
from lbr.drivers.servos.torque import Torque
from lbr.errors import DeviceError

CLOSING_S = 0.3
JUDGED_S = 5.0
NOTABLE_BYTES = 200
"""Fewer meaningless bytes than this, in all of JUDGED_S, occur on any line."""
S = TypeVar("S", bound=ServosSettings)
L = TypeVar("L", bound="PolledLine")


class PolledLine(Protocol):
    """The bus interface of every session."""

    @property
    def counts(self) -> Counts:
        """The errors of the line since it was opened."""

    def close(self) -> None:
        """Close the line."""


class Heard(Protocol):
    """The poller interface of every session; `heard_at` is the time of the last answer of any servo."""

    heard_at: float


class Session(ABC, Generic[S, L]):
    """The part common to all servos. A driver's own session adds `poller` and `targets`, and starts `thread`."""

    poller: Heard
    targets: Torque[Any]

    def __init__(self, ctx: Context[S], bus: L, tell: Tell) -> None:
        self.bus = bus
        self.guard: Guard | None = None
        self.opened = self._judged = ctx.clock()
        self.rest = Rest(ctx.clock, ctx.settings.still_rad, ctx.settings.still_load, ctx.wake)
        self.thread = BusThread(bus, self.turn)
        self._ctx = ctx
        self._tell = tell
        self._babble = 0

    @abstractmethod
    def turn(self, bus: L) -> float:
        """Do the next transaction of the background, in the bus's thread; return the seconds until the one after."""

    @abstractmethod
    def start_guard(self) -> Guard:
        """Start the guard; raise OSError if that fails."""

    @abstractmethod
    def part(self, *, release: bool) -> None:
        """Submit the last orders before the line is closed: release the servos, or hold them."""

    @property
    def turning(self) -> bool:
        """Return whether any servo has torque, or is getting it."""
        return self.targets.turning

    @property
    def hears(self) -> bool:
        """Return whether any servo has answered since the line was opened."""
        return self.poller.heard_at > self.opened

    @property
    def answers(self) -> bool:
        """Return whether the line answers."""
        return self.hears

    @property
    def failure(self) -> Exception | None:
        """Return the error that ended the bus's thread."""
        return self.thread.failure

    def urgent(self) -> bool:
        """Return whether a stop waits; the bus checks it while it waits for an answer."""
        return self.thread.urgent()

    def beat(self) -> None:
        """Beat the guard; start it first, once the line answers or a servo may have torque. Without it no servo gets
        torque."""
        turning = self.turning
        if self.guard is None and self._ctx.settings.guard and (turning or self.answers):
            try:
                self.guard = self.start_guard()
            except OSError as err:
                device = self._ctx.settings.device
                raise DeviceError(
                    f"device '{device}': its guard process does not start: {err}; free some memory"
                ) from err
        if self.guard is not None:
            self.guard.beat(turning=turning)
        self.targets.guarded = not self._ctx.settings.guard or (self.guard is not None and self.guard.listens)

    def judge(self) -> None:
        """Report a babbling line, at most once in `JUDGED_S`."""
        now = self._ctx.clock()
        if now - self._judged < JUDGED_S:
            return
        count, self._babble, self._judged = self.bus.counts.babble - self._babble, self.bus.counts.babble, now
        if count > NOTABLE_BYTES:
            text = f"{count} bytes within {JUDGED_S:g} s belong to no packet; check the cables, and for a second sender"
            self._tell("babble", text, "warning")

    def close(self, *, release: bool) -> None:
        """Hold or release the servos, and close the line; servos that still have torque are left to the guard."""
        turning, alive = self.turning, self.thread.failure is None
        if alive:
            self.part(release=release)
        self.thread.join(CLOSING_S)
        if self.guard is not None and turning and alive and not release:
            self.guard.leave()
        elif self.guard is not None:
            self.guard.dismiss()
        self.bus.close()


class ServoSession(Session[S, B]):
    """An open line of servos whose registers can be read back."""

    poller: Poller[B]
    targets: ServoTargets[B]

    def __init__(
        self, ctx: Context[S], servos: list[int], connect: Callable[[Callable[[], bool]], ServoLink[B]], tell: Tell
    ) -> None:
        link = self.link = connect(self.urgent)
        super().__init__(ctx, link.bus, tell)
        self._echo = self._begun = False
        settings = ctx.settings
        periods = 1.0 / settings.sweep_hz, 1.0 / min(settings.sweep_hz, settings.rest_hz)
        self.poller = Poller[B](servos, ctx.clock, periods[0], link.prepare, tell, self.rest, periods[1])
        self.targets = ServoTargets[B](servos, self.thread, ctx.clock, link.model, tell, self.rest)
        self.thread.start()

    @property
    def failure(self) -> Exception | None:
        """Return the error that ended the bus's thread, or that prevented an order to a servo."""
        return self.thread.failure or self.targets.broken

    def turn(self, bus: B) -> float:
        """Call the link's `begin` once, then do the poller's turns."""
        if not self._begun:
            self._begun = True
            self.link.begin(bus)
            return 0.0
        return self.poller.turn(bus)

    def start_guard(self) -> Guard:
        """Start the guard by the link."""
        return self.link.guard()

    def judge(self) -> None:
        """Report a line that babbles or echoes, now and then."""
        self.link.judge()
        if self.bus.echo and not self._echo:
            self._echo = True
            self._tell("echo", "the adapter echoes what it sends; the echo is removed", "info")
        super().judge()

    def part(self, *, release: bool) -> None:
        """Release the servos, or hold them at their measured position."""
        if release:
            self.targets.release("the driver ended")
        else:
            self.targets.hold(self.poller.snapshot)
