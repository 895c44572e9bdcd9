"""Moves the head: the joints are leased from the first look to the end, even while the head rests on its target."""

from typing import NamedTuple

from msgspec.structs import replace

from lbr.apps.vision.direction import Angles
from lbr.leases.client import LeaseTarget, Transport
from lbr.leases.holder import Holder
from lbr.messages.joints import JointsCommand

JOINTS = LeaseTarget("move", "halt", "joints operation", "joints operation does not answer; the head holds by itself")
TTL_S = 1.0
"""A longer lifetime than usual: the search comes last on a busy machine, and a head does not move beyond its goal."""
RENEWAL = JointsCommand(ttl_s=TTL_S)
EVERY_S = 1.0 / 15.0


class Neck(NamedTuple):
    """The names of the two joints, their greatest speed, and their torque meanwhile."""

    yaw: str
    pitch: str
    speed_rps: float
    torque: float


class HeadClient(Holder):
    """The holder of the head's joints during one tracking, which was requested at `asked_s`.

    Its first command looks at `first` and sets the torque.
    """

    def __init__(self, ctx: Transport, neck: Neck, first: Angles, asked_s: float) -> None:
        super().__init__(ctx, renewal=RENEWAL)
        self._clock = ctx.clock
        self._neck = neck
        self._sent, self._sent_at = first, ctx.clock()
        self.begin(JOINTS, replace(self._command(first), torque=neck.torque, asked_s=asked_s))

    def look(self, wanted: Angles) -> None:
        """Read the answers; send new angles, or renew the lease."""
        self.step()
        now = self._clock()
        due = wanted != self._sent and now - self._sent_at >= EVERY_S
        if due and self.lease is not None and self.lease.send(self._command(wanted)) is not None:
            self._sent, self._sent_at = wanted, now

    def _command(self, wanted: Angles) -> JointsCommand:
        return JointsCommand(
            positions={self._neck.yaw: wanted.yaw_rad, self._neck.pitch: wanted.pitch_rad},
            join=True,
            stay=True,
            speed_rps=self._neck.speed_rps,
            ttl_s=TTL_S,
        )
