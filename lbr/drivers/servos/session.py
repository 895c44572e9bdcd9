"""The objects that live as long as the line of a servo bus is open: the bus, its thread, the poller, the orders, the
guard."""

from collections.abc import Callable
from math import inf
from typing import Generic, TypeVar

from lbr.capability.context import Context
from lbr.drivers.guard import Guard
from lbr.drivers.servos import ServosSettings
from lbr.drivers.servos.bus_thread import BusThread
from lbr.drivers.servos.contract import B, ServoLink, Tell
from lbr.drivers.servos.poller import Poller
from lbr.drivers.servos.rest import Rest
from lbr.drivers.servos.targets import ServoTargets
from lbr.errors import DeviceError

CLOSING_S = 0.3
JUDGED_S = 5.0
NOTABLE_BYTES = 200
"""Fewer bytes that mean nothing, in all of JUDGED_S, come from any line now and then."""
S = TypeVar("S", bound=ServosSettings)


class GuardPost(Generic[S]):
    """Starts the guard of a servo driver when it is needed, and feeds it."""

    def __init__(self, ctx: Context[S], start: Callable[[], Guard]) -> None:
        self._ctx = ctx
        self._start = start
        self.guard: Guard | None = None

    def beat(self, *, needed: bool, turning: bool) -> None:
        """Feed the guard, which is there as soon as it is needed."""
        if self.guard is None and self._ctx.settings.guard and needed:
            try:
                self.guard = self._start()
            except OSError as err:
                device = self._ctx.settings.device
                raise DeviceError(
                    f"device '{device}': its guard process does not start: {err}; free some memory"
                ) from err
        if self.guard is not None:
            self.guard.beat(turning=turning)

    @property
    def stands(self) -> bool:
        """Return whether the guard is there and would act, or the row wants none."""
        return not self._ctx.settings.guard or (self.guard is not None and self.guard.listens)

    def close(self, *, to_act: bool) -> None:
        """Leave the line to the guard, or send it away."""
        if self.guard is not None and to_act:
            self.guard.leave()
        elif self.guard is not None:
            self.guard.dismiss()


class ServoSession(Generic[S, B]):
    """All that lives as long as the line is open."""

    def __init__(
        self,
        ctx: Context[S],
        servos: list[int],
        connect: Callable[[Callable[[], bool]], ServoLink[B]],
        tell: Tell,
    ) -> None:
        self._ctx = ctx
        link = self.link = connect(self._urgent)
        self.opened = self._judged = ctx.clock()
        self._babble, self._echo, self._begun = 0, False, False
        self._tell = tell
        self.bus = link.bus
        self.post = GuardPost(ctx, link.guard)
        settings = ctx.settings
        rest = self.rest = Rest(ctx.clock, settings.still_rad, settings.still_load, ctx.wake)
        periods = 1.0 / settings.sweep_hz, 1.0 / min(settings.sweep_hz, settings.rest_hz)
        self.poller = Poller[B](servos, ctx.clock, periods[0], link.prepare, tell, rest, periods[1])
        self.thread = BusThread(self.bus, self._turn)
        self.targets = ServoTargets[B](servos, self.thread, ctx.clock, link.model, tell, rest)
        self.thread.start()

    @property
    def guard(self) -> Guard | None:
        """The guard, once there is one."""
        return self.post.guard

    @property
    def turning(self) -> bool:
        """Return whether any servo has torque, or is getting it."""
        return self.targets.turning

    @property
    def failure(self) -> Exception | None:
        """Return what ended the bus's thread, or kept it from telling a servo something."""
        return self.thread.failure or self.targets.broken

    def beat(self) -> None:
        """Feed the guard, which is there as soon as a servo was heard."""
        self.post.beat(needed=self.poller.heard > -inf, turning=self.turning)
        self.targets.guarded = self.post.stands

    def judge(self) -> None:
        """Tell of a line that babbles or echoes, now and then."""
        now, bus = self._ctx.clock(), self.bus
        self.link.judge()
        if bus.echo and not self._echo:
            self._echo = True
            self._tell("echo", "the adapter hears what it says itself; that is taken out", "info")
        if now - self._judged < JUDGED_S:
            return
        came, self._babble, self._judged = bus.counts.babble - self._babble, bus.counts.babble, now
        if came > NOTABLE_BYTES:
            text = f"{came} bytes within {JUDGED_S:g} s belong to no packet; check the cables, and for a second sender"
            self._tell("babble", text, "warning")

    def close(self, *, release: bool) -> None:
        """Tell the servos to hold or release them, and close the line; what still has torque then is the guard's."""
        turning, alive = self.targets.turning, self.thread.failure is None
        if alive and release:
            self.targets.release("the driver ended")
        elif alive:
            self.targets.hold(self.poller.snapshot)
        self.thread.join(CLOSING_S)
        self.post.close(to_act=turning and alive and not release)
        self.bus.close()

    def _urgent(self) -> bool:
        return self.thread.urgent()

    def _turn(self, bus: B) -> float:
        if not self._begun:
            self._begun = True
            self.link.begin(bus)
            return 0.0
        return self.poller.turn(bus)
