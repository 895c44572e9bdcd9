"""What lives as long as the line of a UXA-90 is open: the bus, its owner, the sweep, what was told, the guard."""

from collections.abc import Callable, Mapping
from concurrent.futures import Future

from lbr.capability.context import Context
from lbr.drivers.owner import READ, STOP, WRITE, Owner
from lbr.drivers.serial_line import open_line
from lbr.drivers.uxa90 import Uxa90Settings, frames
from lbr.drivers.uxa90.bus import Bus
from lbr.drivers.uxa90.controller import Controller
from lbr.drivers.uxa90.frames import TAKE_CONTROL
from lbr.drivers.uxa90.guard import Guard
from lbr.drivers.uxa90.outputs import Outputs
from lbr.drivers.uxa90.plays import Plays
from lbr.drivers.uxa90.sweep import Sweeper
from lbr.drivers.wire import Wire
from lbr.errors import DeviceError

CLOSING_S = 0.3
JUDGED_S = 5.0
SILENT_S = 1.5
NOTABLE_BYTES = 200
IDENTITY = ("firmware", "serial")
Tell = Callable[[str, str, str], None]


class Session:
    """All that lives as long as the line is open. `identity` is what the main board said of itself, once it was asked."""

    def __init__(
        self, ctx: Context[Uxa90Settings], servos: list[int], tell: Tell, known: Plays, blocked: str = ""
    ) -> None:
        assert ctx.device is not None
        settings = ctx.settings
        line = open_line(ctx.device, settings.baud)
        line.low_latency()
        self._line = Wire(line.fileno(), f"'{ctx.device.name}' at {line.path}", settings.baud, line=line)
        self._ctx, self._servos, self._tell = ctx, servos, tell
        self.guard: Guard | None = None
        self.bus = Bus(
            self._line, settings.reply_s, clock=ctx.clock, stop_waits=self._stop_waits, write_waits=self._write_waits
        )
        period_s = 1.0 / settings.sweep_hz if settings.sweep_hz else 0.0
        self.sweeper = Sweeper(
            servos, ctx.clock, period_s, settings.trust, settings.together, moving=self._moving, told=tell
        )
        self.owner = Owner(self.bus, self._turn)
        seen = self.sweeper.seen
        self.outputs = Outputs(servos, seen, ctx.clock, self._line.wire_s, settings.offsets, blocked)
        self.controller = Controller(self.owner, self.outputs, settings, ctx.clock, known)
        self.opened = self._judged = ctx.clock()
        self._strays = 0
        self.identity: Mapping[str, str] = {}
        if known.busy:  # the main board does not notice that its cable was out: it may play still
            self.owner.submit(lambda bus: bus.say(TAKE_CONTROL), STOP)
        self._identified: Future[dict[str, str]] = self.owner.submit(_identify, READ)
        self.owner.start()

    def step(self) -> None:
        """Take in what the main board said; take control once it was asked who it is."""
        while self.bus.told:
            self.controller.hear(self.bus.told.popleft())
        if self._identified.done() and self.controller.mode.name == "unknown":
            if not self._identified.cancelled() and self._identified.exception() is None:
                self.identity = self._identified.result()
            self.controller.take()

    def tell(self, *, urgent: bool) -> None:
        """Have the servos told what is due, and read while nothing forbids it."""
        passes = self.controller.passes
        if passes and not self.sweeper.reading:
            self.owner.submit(lambda _bus: self.sweeper.afresh(), WRITE)
        self.outputs.open = self.sweeper.reading = passes
        if self.outputs.due and urgent:
            self.owner.submit(self.outputs.flush_now, STOP, "flush")
        elif self.outputs.due:
            self.owner.submit(self.outputs.flush, WRITE, "flush")

    def brake(self) -> None:
        """Short all motors, now and, if the main board has to be asked to pass that on first, once it does."""
        if not self.controller.mode.pc:
            self.owner.submit(lambda bus: bus.say(TAKE_CONTROL), STOP)
        self.outputs.braked()
        self.owner.submit(self.outputs.brake, STOP, "brake")

    def beat(self) -> None:
        """Feed the guard, which is there as soon as a servo has torque."""
        turning = self.outputs.turning or self.controller.plays.busy
        if self.guard is None and self._ctx.settings.guard and turning:
            try:
                self.guard = Guard(self._line, self._ctx.settings, self._servos, self._ctx.clock)
            except OSError as err:
                device = self._ctx.settings.device
                raise DeviceError(
                    f"device '{device}': its guard process does not start: {err}; free some memory"
                ) from err
        if self.guard is not None:
            self.guard.beat(turning=turning)

    def judge(self) -> None:
        """Tell of a line that babbles, now and then."""
        now = self._ctx.clock()
        if now - self._judged < JUDGED_S:
            return
        came = self.bus.counts.strays - self._strays
        self._strays, self._judged = self.bus.counts.strays, now
        if came > NOTABLE_BYTES:
            text = f"{came} bytes came unasked within {JUDGED_S:g} s; check the cable, and for a second sender"
            self._tell("babble", text, "warning")

    @property
    def mute(self) -> bool:
        """Whether every servo was asked in vain, or some were for so long that all of them may be."""
        long = bool(self._ctx.settings.sweep_hz) and self.bus.unheard_s >= SILENT_S
        return long or self.sweeper.all_silent

    def close(self, *, release: bool) -> None:
        """Say the last word, and let go; what still has torque then is the guard's."""
        turning, alive = self.outputs.turning or self.controller.plays.busy, self.owner.failure is None
        if alive:
            self.controller.interrupt("the driver ended", {})
            self.sweeper.reading = False
        if alive and release and turning:
            self.outputs.release("the driver ended")
            self.outputs.open = True
            self.owner.submit(self.outputs.flush_now, STOP)
        self.owner.join(CLOSING_S)
        if self.guard is not None and turning and alive and not release:
            self.guard.leave()
        elif self.guard is not None:
            self.guard.dismiss()
        self.bus.close()

    def _turn(self, bus: Bus) -> float:
        """Read on, unless the main board was given something to do just now."""
        if not self.outputs.open:
            self.sweeper.reading = False
        return self.sweeper.turn(bus)

    def _stop_waits(self) -> bool:
        return self.owner.urgent()

    def _write_waits(self) -> bool:
        return self.owner.waiting(WRITE)

    def _moving(self, servo: int) -> bool:
        return self.outputs.moving(servo)


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
