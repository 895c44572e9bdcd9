"""The objects of an open line of a UXA-90: the bus, its owner, the sweep, the orders, the guard."""

from collections.abc import Mapping
from concurrent.futures import Future
from math import inf

from lbr.capability.context import Context, Device
from lbr.drivers.guard import Guard
from lbr.drivers.serial_line import open_line
from lbr.drivers.servos import session
from lbr.drivers.servos.bus_thread import READ, STOP, WRITE
from lbr.drivers.servos.contract import Tell
from lbr.drivers.servos.guard import Guard as ServosGuard
from lbr.messages.imu import ImuSample
from lbr.robots.uxa90.driver import Uxa90Settings, frames
from lbr.robots.uxa90.driver.bus import Bus
from lbr.robots.uxa90.driver.controller import Controller
from lbr.robots.uxa90.driver.frames import IMU, TAKE_CONTROL
from lbr.robots.uxa90.driver.inertial_unit import InertialUnit
from lbr.robots.uxa90.driver.poller import Poller
from lbr.robots.uxa90.driver.stored_motions import StoredMotions
from lbr.robots.uxa90.driver.targets import ServoTargets

SILENT_S = 1.5
IDENTITY = ("firmware", "serial")
RELEASE = "lbr.robots.uxa90.driver.guard_release"


class Session(session.Session[Uxa90Settings, Bus]):
    """All that lives as long as the line is open. `identity` is what the main board said of itself, once it was asked.

    `answered`: whether it said anything at all.
    """

    poller: Poller
    targets: ServoTargets

    def __init__(
        self,
        ctx: Context[Uxa90Settings],
        device: Device,
        servos: list[int],
        tell: Tell,
        known: StoredMotions,
        blocked: str = "",
    ) -> None:
        settings = ctx.settings
        self._line = open_line(device, settings.baud)
        self._line.low_latency()
        bus = Bus(
            self._line,
            settings.reply_s,
            clock=ctx.clock,
            stop_waits=self.urgent,
            write_waits=self._write_waits,
            unsummed=() if settings.imu.sum else (IMU,),
        )
        super().__init__(ctx, bus, tell)
        self.unit = InertialUnit(settings.imu, simulated=ctx.simulated)
        period_s = 1.0 / settings.sweep_hz if settings.sweep_hz else 0.0
        self.poller = Poller(
            servos,
            ctx.clock,
            period_s,
            settings.trust,
            settings.together,
            moving=self._moving,
            tell=tell,
            rest=self.rest,
            rest_period_s=max(period_s, 1.0 / settings.rest_hz),
        )
        seen = self.poller.seen
        self.targets = ServoTargets(servos, seen, ctx.clock, self._line.wire_s, settings.offsets, blocked)
        self.controller = Controller(self.thread, self.targets, settings, ctx.clock, known)
        self.answered = False
        self.identity: Mapping[str, str] = {}
        if known.busy:  # the main board does not notice that its cable was out: it may play still
            self.thread.submit(lambda bus: bus.say(TAKE_CONTROL), STOP)
        self._identified: Future[dict[str, str]] = self.thread.submit(_identify, READ)
        self.thread.start()

    def step(self) -> None:
        """Take in what the main board said; take control once it was asked who it is."""
        now = self._ctx.clock()
        while self.bus.told:
            frame = self.bus.told.popleft()
            self.answered = True
            self.controller.hear(frame)
            self._publish(self.unit.hear(frame, now))
        self._publish(self.unit.missed(now))
        if self._identified.done() and self.controller.mode.name == "unknown":
            if not self._identified.cancelled() and self._identified.exception() is None:
                self.identity = self._identified.result()
                self.answered = self.answered or bool(self.identity)
            self.controller.take()

    def tell(self, *, urgent: bool) -> None:
        """Have the servos told what is due, and read while nothing forbids it."""
        passes = self.controller.passes
        if self.targets.due or not passes or not self.poller.told_apart:
            self.rest.stir()
        if passes and not self.poller.reading:
            self.thread.submit(lambda _bus: self.poller.afresh(), WRITE)
        self.targets.open = self.poller.reading = passes
        if self.targets.due and urgent:
            self.thread.submit(self.targets.flush_now, STOP, "flush")
        elif self.targets.due:
            self.thread.submit(self.targets.flush, WRITE, "flush")

    def brake(self) -> None:
        """Short all motors, now and, if the main board has to be asked to pass that on first, once it does."""
        if not self.controller.mode.pc:
            self.thread.submit(lambda bus: bus.say(TAKE_CONTROL), STOP)
        self.targets.braked()
        self.thread.submit(self.targets.brake, STOP, "brake")

    @property
    def answers(self) -> bool:
        """Return whether the main board or a servo answers; where the row reads no servos nothing is waited for."""
        return self.answered or self.hears or not self._ctx.settings.sweep_hz

    @property
    def turning(self) -> bool:
        """Return whether any servo has torque by this driver, or the main board moves them."""
        return self.targets.turning or self.controller.plays.busy

    @property
    def mute(self) -> bool:
        """Return whether every servo was asked in vain, or some were for so long that all of them may be."""
        long = bool(self._ctx.settings.sweep_hz) and self.bus.unheard_s >= SILENT_S
        return long or self.poller.all_silent

    def part(self, *, release: bool) -> None:
        """Release the servos; to hold they need no order."""
        turning = self.turning
        self.controller.interrupt("the driver ended", {})
        self.poller.reading = False
        if release and turning:
            self.targets.release("the driver ended")
            self.targets.open = True
            self.thread.submit(self.targets.flush_now, STOP)

    def start_guard(self) -> Guard:
        """Start the guard, told how long the main board takes to give up control."""
        settle_s = self._ctx.settings.settle_s
        return ServosGuard(
            RELEASE,
            self._line.fileno(),
            self._ctx.settings,
            tuple(self.targets.servos),
            self._ctx.clock,
            words=(settle_s,),
            settling_s=2.0 * settle_s,
        )

    def turn(self, bus: Bus) -> float:
        """Read on, unless the main board was given something to do just now."""
        if not self.targets.open:
            self.poller.reading = False
        unit_s = inf
        if self.unit.asked and self.controller.mode.name in {"pc", "normal"}:
            unit_s = self.unit.turn(bus, self._ctx.clock())
        return min(unit_s, self.poller.turn(bus))

    def _publish(self, sample: ImuSample | None) -> None:
        if sample is not None:
            self._ctx.publish("imu", sample)

    def _write_waits(self) -> bool:
        return self.thread.waiting(WRITE)

    def _moving(self, servo: int) -> bool:
        return self.targets.moving(servo)


def _identify(bus: Bus) -> dict[str, str]:
    """Ask the main board who it is; what it does not say stays unknown."""
    said = {}
    for what in IDENTITY:
        answer = bus.inquire(frames.ask(what), *frames.QUESTIONS[what])
        if answer is not None:
            said[what] = words(what, answer.contents)
    return said


def words(what: str, contents: bytes) -> str:
    """Return for people what the main board said."""
    if what == "serial":
        return contents.decode("ascii", "replace")
    if what == "firmware":
        return contents.hex(" ").upper()
    return " ".join(map(str, contents))
