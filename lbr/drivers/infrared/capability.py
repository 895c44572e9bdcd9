"""The dock's beams as a capability: which beams are seen now."""

from math import inf

from lbr.capability.base import Capability
from lbr.capability.context import Call, Context
from lbr.drivers.infrared import BEAMS, Beam, InfraredSettings
from lbr.drivers.infrared.receiver import Receiver
from lbr.drivers.infrared.records import ANY_PROTOCOL, Scancode
from lbr.errors import DeviceError
from lbr.messages.dock import DockSignal
from lbr.messages.leases import CommandReply
from lbr.messages.motors import RESTS_S

LOOKS_HZ, RESTING_HZ = 20.0, 2.0
"""The pace of its looks, and that before a standing base that nobody holds."""
PUBLISH_S = 0.75
SOONEST_S = 0.1
RETRY_S = 1.0
OLDEST_S = 3600.0


class Infrared(Capability[InfraredSettings]):
    """Publishes every change at once, each new sight ten times a second at most, and once a second at least.

    Without its receiver it is degraded, but still accepts sights from other programs.
    """

    rate_hz = LOOKS_HZ

    def __init__(self, ctx: Context[InfraredSettings]) -> None:
        super().__init__(ctx)
        self._seen_at: dict[Beam, float] = {}
        self._beams = ctx.settings.beams
        self._receiver: Receiver | None = None
        self._retry_at = -inf
        self._published_beams: tuple[bool, ...] = ()
        self._published_at = -inf
        self._new = False

    def step(self) -> None:
        """Read the receiver, and publish the current beams."""
        for scancode in self._received():
            self._take(scancode)
        now = self.ctx.clock()
        signal = self._signal(now)
        shown = (signal.left, signal.right, signal.power)
        since_s = now - self._published_at
        if shown != self._published_beams or since_s >= PUBLISH_S or (self._new and since_s >= SOONEST_S):
            self._published_beams, self._published_at, self._new = shown, now, False
            self.ctx.publish("signal", signal)
        drive = self.ctx.latest("drive")
        base = drive.message if drive is not None and drive.age_s(now) <= RESTS_S else None
        self.rate_hz = RESTING_HZ if base is not None and base.holder is None and not base.moving else LOOKS_HZ

    def command(self, call: Call) -> None:
        """Accept a beam seen by another program."""
        for beam in BEAMS:
            if getattr(call.message, beam):
                self._note(beam, call.arrived)
        call.reply(CommandReply(accepted=True))

    def close(self) -> None:
        """Close the receiver."""
        receiver, self._receiver = self._receiver, None
        if receiver is not None:
            receiver.close()

    def _received(self) -> list[Scancode]:
        try:
            if self._receiver is None and self.ctx.clock() >= self._retry_at:
                self._receiver = Receiver(self.device_row, self.ctx.settings)
                self.ctx.ready()
            return self._receiver.poll() if self._receiver is not None else []
        except DeviceError as err:
            self.close()
            self._retry_at = self.ctx.clock() + RETRY_S
            self.ctx.warn(str(err), err.code)
            return []

    def _take(self, scancode: Scancode) -> None:
        protocols = self.ctx.settings.protocols
        beam = self._beams.get(scancode.code)
        if beam is None or (protocols and scancode.protocol not in {ANY_PROTOCOL, *protocols}):
            return
        now = self.ctx.clock()
        ours = now - OLDEST_S < scancode.taken_s <= now  # else the device has a clock of its own
        self._note(beam, scancode.taken_s if ours else now)

    def _note(self, beam: Beam, seen_at: float) -> None:
        """Store when a beam was seen; an older sight changes nothing."""
        self._seen_at[beam] = max(seen_at, self._seen_at.get(beam, seen_at))
        self._new = True

    def _signal(self, now: float) -> DockSignal:
        ages_s = {beam: round(max(0.0, now - seen_at), 3) for beam, seen_at in self._seen_at.items()}
        counts = {beam: ages_s.get(beam, inf) < self.ctx.settings.ttl_s for beam in BEAMS}
        return DockSignal(
            left=counts["left"],
            right=counts["right"],
            power=counts["power"],
            left_age_s=ages_s.get("left"),
            right_age_s=ages_s.get("right"),
            power_age_s=ages_s.get("power"),
        )
