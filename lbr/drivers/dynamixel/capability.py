"""A bus of AX-12A as a capability, on the common driver of servos whose registers can be read back."""

from collections.abc import Callable

from lbr.capability.context import Device
from lbr.drivers.dynamixel import DynamixelSettings, table
from lbr.drivers.dynamixel.bus import Bus
from lbr.drivers.dynamixel.model import Ax12
from lbr.drivers.dynamixel.packet import error_mask
from lbr.drivers.dynamixel.recovery import recovery
from lbr.drivers.dynamixel.setup import Setup, SetupNews
from lbr.drivers.servos.contract import ServoLink
from lbr.drivers.servos.line import open_servo_line
from lbr.drivers.servos.protocol1.register import Register
from lbr.drivers.servos.registers import RegisterServos

RELEASE = "lbr.drivers.dynamixel.guard_release"
ASKED = 3
"""The number of times that the bus is searched for a USB2AX; most adapters are others, and do not answer."""


class Dynamixel(RegisterServos[DynamixelSettings, Bus]):
    """AX-12A servos, plain or by a USB2AX."""

    def connect(self, device: Device, urgent: Callable[[], bool]) -> ServoLink[Bus]:
        """Open the line; each servo is set up when it is found."""
        settings, clock = self.ctx.settings, self.ctx.clock
        line = open_servo_line(device, settings.baud, settings.reply_margin_s)
        setup = Setup(_wanted(settings), self.tell)

        def job(servo: int) -> Callable[[Bus], str] | None:
            kept = setup.kept.get(servo)
            return recovery(servo, kept) if kept is not None else None

        return ServoLink(
            bus=Bus(line, clock=clock, urgent=urgent),
            model=Ax12(setup.kept.get),
            guard=lambda: self.guard(RELEASE, line.fileno(), line.baud, line.margin_s),
            recovery=job,
            prepare=setup.prepare,
            begin=self._find_adapter,
            judge=SetupNews(setup, clock, self.tell).step,
        )

    def _find_adapter(self, bus: Bus) -> None:
        if self.ctx.settings.sync_read:
            any(bus.find_adapter() for _ in range(ASKED))


def _wanted(settings: DynamixelSettings) -> list[tuple[Register, int]]:
    """Return the EEPROM values that servos should have; temperature limits are left unchanged."""
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
