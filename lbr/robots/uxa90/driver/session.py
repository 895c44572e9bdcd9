"""The objects of an open line of a UXA-90: the bus, its thread, the poller, the orders, the guard."""

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
    """The objects that live as long as the line is open. `identity` are the main board's answers about itself.

    `answered`: whether it sent anything at all.
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
        if known.busy:  # the main board does not notice a pulled cable: it may still play
            self.thread.submit(lambda bus: bus.say(TAKE_CONTROL), STOP)
        self._identified: Future[dict[str, str]] = self.thread.submit(_identify, READ)
        self.thread.start()

    def step(self) -> None:
        """Process the main board's frames; take control after the question about its identity."""
        now = self._ctx.clock()
        while self.bus.board_frames:
            frame = self.bus.board_frames.popleft()
            self.answered = True
            self.controller.hear(frame)
            self._publish(self.unit.hear(frame, now))
        self._publish(self.unit.missed(now))
        if self._identified.done() and self.controller.mode.name == "unknown":
            if not self._identified.cancelled() and self._identified.exception() is None:
                self.identity = self._identified.result()
                self.answered = self.answered or bool(self.identity)
            self.controller.take()

    def send_orders(self, *, urgent: bool) -> None:
        """Send due orders to the servos, and read them while that is possible."""
        passes = self.controller.passes
        if self.targets.due or not passes or not self.poller.judged_all:
            self.rest.stir()
        if passes and not self.poller.reading:
            self.thread.submit(lambda _bus: self.poller.afresh(), WRITE)
        self.targets.open = self.poller.reading = passes
        if self.targets.due and urgent:
            self.thread.submit(self.targets.flush_now, STOP, "flush")
        elif self.targets.due:
            self.thread.submit(self.targets.flush, WRITE, "flush")

    def brake(self) -> None:
        """Short all motors, now and again once the main board passes packets on, if that must be requested first."""
        if not self.controller.mode.pc:
            self.thread.submit(lambda bus: bus.say(TAKE_CONTROL), STOP)
        self.targets.braked()
        self.thread.submit(self.targets.brake, STOP, "brake")

    @property
    def answers(self) -> bool:
        """Return whether the main board or a servo answers; always True if the row reads no servos."""
        return self.answered or self.hears or not self._ctx.settings.sweep_hz

    @property
    def turning(self) -> bool:
        """Return whether any servo has torque by this driver, or the main board moves them."""
        return self.targets.turning or self.controller.plays.busy

    @property
    def mute(self) -> bool:
        """Return whether every servo was asked in vain, or the line has been silent for too long."""
        long = bool(self._ctx.settings.sweep_hz) and self.bus.silent_s >= SILENT_S
        return long or self.poller.all_silent

    def part(self, *, release: bool) -> None:
        """Release the servos; to hold, they need no order."""
        turning = self.turning
        self.controller.interrupt("the driver ended", {})
        self.poller.reading = False
        if release and turning:
            self.targets.release("the driver ended")
            self.targets.open = True
            self.thread.submit(self.targets.flush_now, STOP)

    def start_guard(self) -> Guard:
        """Start the guard, with the time that the main board takes to give up control."""
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
        """Read on, unless the main board has just got an order."""
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
    """Ask the main board for its identity; a missing answer stays unknown."""
    answers = {}
    for question in IDENTITY:
        answer = bus.inquire(frames.ask(question), *frames.QUESTIONS[question])
        if answer is not None:
            answers[question] = words(question, answer.contents)
    return answers


def words(question: str, contents: bytes) -> str:
    """Return the main board's answer as text for people."""
    if question == "serial":
        return contents.decode("ascii", "replace")
    if question == "firmware":
        return contents.hex(" ").upper()
    return " ".join(map(str, contents))
