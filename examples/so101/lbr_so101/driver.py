"""A bus of STS3215 as the capability that drives servos whose registers can be read back."""

from collections.abc import Callable

from lbr.capability.context import Device
from lbr.drivers.servos.contract import ServoLink
from lbr.drivers.servos.line import open_servo_line
from lbr.drivers.servos.registers import RegisterServos
from lbr_so101.bus import FeetechBus
from lbr_so101.kind import FeetechSettings
from lbr_so101.model import Sts3215
from lbr_so101.setup import Setup

RELEASE = "lbr_so101.guard_release"


class Feetech(RegisterServos[FeetechSettings, FeetechBus]):
    """STS3215 servos on one line."""

    def connect(self, device: Device, urgent: Callable[[], bool]) -> ServoLink[FeetechBus]:
        """Open the line; each servo is examined when it is found."""
        settings, clock = self.ctx.settings, self.ctx.clock
        line = open_servo_line(device, settings.baud, settings.reply_margin_s)
        setup = Setup(settings.models, self.tell, check_phase=settings.check_phase)
        bus = FeetechBus(
            line, together=settings.sync_read, acceleration=settings.acceleration, clock=clock, urgent=urgent
        )
        return ServoLink(
            bus=bus,
            model=Sts3215(setup.kept.get),
            guard=lambda: self.guard(RELEASE, line.fileno(), line.baud, line.margin_s),
            recovery=setup.recovery,
            prepare=setup.prepare,
        )
