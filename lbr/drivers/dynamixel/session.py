"""What lives as long as the line of a servo bus is open: the bus, its owner, the sweep, what was told, the guard."""

from collections.abc import Callable
from math import inf

from lbr.capability.context import Context
from lbr.drivers.dynamixel import DynamixelSettings, table
from lbr.drivers.dynamixel.bus import Bus
from lbr.drivers.dynamixel.guard import Guard
from lbr.drivers.dynamixel.line import ServoLine
from lbr.drivers.dynamixel.outputs import Outputs
from lbr.drivers.dynamixel.packet import error_mask
from lbr.drivers.dynamixel.setup import Setup
from lbr.drivers.dynamixel.sweep import Sweeper
from lbr.drivers.dynamixel.table import Register
from lbr.drivers.owner import Owner
from lbr.errors import DeviceError

CLOSING_S = 0.3
JUDGED_S = 5.0
NOTABLE_BYTES = 200
SET_UP_QUIET_S = 0.5
ASKED = 3
"""So often an adapter is asked whether it is a USB2AX; most are none, and say nothing."""
Tell = Callable[[str, str, str], None]


class Session:
    """All that lives as long as the line is open."""

    def __init__(self, ctx: Context[DynamixelSettings], line: ServoLine, servos: list[int], tell: Tell) -> None:
        self._ctx, self._line, self._servos = ctx, line, servos
        settings = ctx.settings
        self.opened = self._judged = ctx.clock()
        self._babble, self._echo = 0, False
        self._done = self._told_of = 0
        self._done_at = -inf
        self._tell = tell
        self.guard: Guard | None = None
        self.bus = Bus(line, clock=ctx.clock, urgent=self._urgent)
        self.setup = Setup(_wanted(settings), tell)
        period_s = 1.0 / settings.sweep_hz
        self.sweeper = Sweeper(servos, ctx.clock, period_s, self.setup.prepare, tell)
        self._looked = not settings.sync_read
        self.owner = Owner(self.bus, self._turn)
        self.outputs = Outputs(servos, self.owner, ctx.clock, self.setup.kept.get, tell)

    def beat(self) -> None:
        """Feed the guard, which is there as soon as a servo was heard."""
        if self.guard is None and self._ctx.settings.guard and self.sweeper.heard > -inf:
            try:
                self.guard = Guard(self._line, self._ctx.settings, self._servos, self._ctx.clock)
            except OSError as err:
                device = self._ctx.settings.device
                raise DeviceError(
                    f"device '{device}': its guard process does not start: {err}; free some memory"
                ) from err
        if self.guard is not None:
            self.guard.beat(turning=self.outputs.turning)

    def judge(self) -> None:
        """Tell of a line that babbles or echoes, now and then."""
        now, bus = self._ctx.clock(), self.bus
        self._tell_set_up(now)
        if bus.echo and not self._echo:
            self._echo = True
            self._tell("echo", "the adapter hears what it says itself; that is taken out", "info")
        if now - self._judged < JUDGED_S:
            return
        came, self._babble, self._judged = bus.counts.babble - self._babble, bus.counts.babble, now
        if came > NOTABLE_BYTES:
            text = f"{came} bytes within {JUDGED_S:g} s belong to no packet; check the cables, and for a second sender"
            self._tell("babble", text, "warning")

    def _tell_set_up(self, now: float) -> None:
        """Tell what servos were given to keep, in one sentence once there are no more of them."""
        done = self.setup.done
        if len(done) > self._done:
            self._done, self._done_at = len(done), now
        elif len(done) > self._told_of and now - self._done_at >= SET_UP_QUIET_S:
            for what in dict.fromkeys(names for _, names in done[self._told_of :]):
                servos = sorted(servo for servo, names in done[self._told_of :] if names == what)
                whom = f"servo {servos[0]}" if len(servos) == 1 else f"servos {', '.join(map(str, servos))}"
                self._tell("servo_set_up", f"{whom}: set {what}", "info")
            self._told_of = len(done)

    def close(self, *, release: bool) -> None:
        """Say the last word, and let go; what still has torque then is the guard's."""
        turning, alive = self.outputs.turning, self.owner.failure is None
        if alive and release:
            self.outputs.release("the driver ended")
        elif alive:
            self.outputs.hold(self.sweeper.snapshot)
        self.owner.join(CLOSING_S)
        if self.guard is not None and turning and alive and not release:
            self.guard.leave()
        elif self.guard is not None:
            self.guard.dismiss()
        self.bus.close()

    def _urgent(self) -> bool:
        return self.owner.urgent()

    def _turn(self, bus: Bus) -> float:
        if not self._looked:
            self._looked = True
            any(bus.find_adapter() for _ in range(ASKED))
            return 0.0
        return self.sweeper.turn(bus)


def _wanted(settings: DynamixelSettings) -> list[tuple[Register, int]]:
    """Return what servos are to keep without power. Temperature limits stay as they are."""
    if not settings.write_eeprom:
        return []
    alarms = error_mask(*settings.alarms)
    return [
        (table.RETURN_LEVEL, 2),
        (table.RETURN_DELAY, settings.return_delay_us // 2),
        (table.MIN_VOLTAGE, round(settings.lowest_v * 10)),
        (table.MAX_VOLTAGE, round(settings.highest_v * 10)),
        (table.ALARM_LED, alarms),
        (table.SHUTDOWN, alarms),
    ]
