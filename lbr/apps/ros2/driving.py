"""The twist or trajectory that the robot follows, by the publishers in ROS, or why it stands. Pure.

One publisher drives at a time. It is the first with a motion, until it rests or leaves, its twists fall silent, or
its trajectory is over. After any interruption, of the bridge too, that publisher must send a twist of zero, or an empty
trajectory, before it moves the robot again. So nothing resumes by itself. Another publisher may begin at once.
"""

from collections import OrderedDict
from math import hypot, inf
from typing import NamedTuple

from msgspec import Struct

from lbr.apps.ros2.codec import S_NS, Stamped
from lbr.apps.ros2.trajectory import Way
from lbr.apps.ros2.wire import Attachment
from lbr.messages.codes import Code, Reason
from lbr.messages.drive import TwistCommand
from lbr.messages.joints import JointsCommand

MOST_PUBLISHERS = 64
WINDOW_S = 30.0
"""The time over which the quickest message defines the difference of a publisher's clock."""
JOINING_S = 5.0  # who has published before the router is joined is received within it, on a busy machine too
AT_REST = Reason("idle", "nobody in ROS asks for motion")


class Limits(Struct, frozen=True, kw_only=True):
    """The greatest speeds of ROS, the longest silence, and the greatest delay."""

    speed_mps: float
    turn_rps: float
    silent_s: float
    late_s: float


class MotionMessage(NamedTuple):
    """A twist or trajectory, its attachment, and its arrival by the monotonic and by the wall clock here."""

    motion: Stamped | Way
    by: Attachment
    arrived_s: float
    wall_ns: int


class Clock:
    """The difference between a publisher's wall clock and ours, by its quickest message of late."""

    def __init__(self) -> None:
        self._least_s: list[float] = []
        self._since_s = 0.0

    def late_s(self, offset_s: float, now: float) -> float:
        """Return how much longer than the quickest a message took; `offset_s` is its time by both clocks."""
        if not self._least_s or now - self._since_s > WINDOW_S:
            self._least_s, self._since_s = [*self._least_s[-1:], offset_s], now
        self._least_s[-1] = min(self._least_s[-1], offset_s)
        return offset_s - min(self._least_s)


class Publisher:
    """A publisher of motion. It may begin if it has `rested` since its last interruption."""

    def __init__(self) -> None:
        self.clock = Clock()
        self.sequence: int | None = None
        self.motion: Stamped | Way | None = None
        self.heard_s = 0.0
        self.rested = True
        self.reported: set[Code] = set()

    def rest(self) -> None:
        """Allow it to begin."""
        self.motion, self.rested = None, True
        self.reported.clear()

    def lose(self) -> None:
        """Require a rest before it moves the robot again."""
        self.motion, self.rested = None, False


class Driving:
    """The publishers of motion: `receive` messages, and follow the `command`; `lost` are refusals and ends to report.

    `driver` is the gid of the publisher that drives, or empty; `stands` is why the robot must stand; `joined_s` is when
    the router was joined. With a reason why it is `denied`, no publisher in ROS drives.
    """

    def __init__(self, limits: Limits, denied: Reason | None = None) -> None:
        self._limits = limits
        self._denied = denied
        self._publishers: OrderedDict[bytes, Publisher] = OrderedDict()
        self.joined_s = -inf
        self.driver: bytes = b""
        self.stands = AT_REST
        self.lost: list[tuple[bytes, Reason]] = []

    def receive(self, asked: MotionMessage) -> None:
        """Receive a twist or a trajectory of a publisher."""
        publisher = self._publisher(asked.by.gid)
        refusal = self._unfit(publisher, asked)
        if refusal is not None:
            if refusal.code != "repeated":
                self._refuse(asked.by.gid, publisher, refusal)
            return
        publisher.heard_s = asked.arrived_s
        if asked.motion.rests:
            publisher.rest()
            if self.driver == asked.by.gid:
                self.driver, self.stands = b"", AT_REST
        elif self._denied is not None:
            self._report(asked.by.gid, publisher, self._denied)
        elif not publisher.rested:
            self._report(asked.by.gid, publisher, Reason("rest_first", f"it goes on: {_rest(asked)} must come first"))
        elif self.driver not in {b"", asked.by.gid}:
            self._report(asked.by.gid, publisher, Reason("held", "another publisher in ROS drives the robot"))
        else:
            self.driver, publisher.motion = asked.by.gid, asked.motion

    def command(self, now: float, ttl_s: float) -> TwistCommand | JointsCommand | None:
        """Return the motion to follow; None if the robot must stand, for the reason `stands`.

        A trajectory is sent once, so the silence of its publisher is not an end.
        """
        driver = self._publishers.get(self.driver)
        if driver is None or driver.motion is None:
            return None
        if isinstance(driver.motion, Way):
            return JointsCommand(frames=driver.motion.frames, ttl_s=ttl_s)
        if not now - driver.heard_s <= self._limits.silent_s:  # this way round, NaN is silence
            self.end(Reason("holder_gone", f"it sent nothing for {self._limits.silent_s:g} s"))
            return None
        return self._limited(driver.motion, ttl_s)

    def finish(self) -> None:
        """Note the planned end of the motion; its publisher may begin again."""
        gid, self.driver, self.stands = self.driver, b"", AT_REST
        if (publisher := self._publishers.get(gid)) is not None:
            publisher.rest()

    def end(self, why: Reason) -> None:
        """End the motion; its publisher must rest before it moves the robot again."""
        gid, self.driver, self.stands = self.driver, b"", why
        if (publisher := self._publishers.get(gid)) is not None:
            publisher.lose()
            self._report(gid, publisher, why)

    def leave(self, gid: bytes, why: Reason) -> None:
        """Note that a publisher is gone; if it comes back, as through a new router, it must rest first."""
        if gid == self.driver:
            self.end(why)
        elif (publisher := self._publishers.get(gid)) is not None:
            publisher.lose()

    def end_all(self, why: Reason) -> None:
        """End the motion; every publisher must rest first."""
        self.end(why)
        for publisher in self._publishers.values():
            publisher.lose()

    def malformed(self, gid: bytes, why: str) -> None:
        """Refuse a message that cannot be decoded."""
        self._refuse(gid, self._publisher(gid), Reason("malformed", why))

    def _publisher(self, gid: bytes) -> Publisher:
        publisher = self._publishers.setdefault(gid, Publisher())
        self._publishers.move_to_end(gid)
        while len(self._publishers) > MOST_PUBLISHERS:
            oldest = next(iter(self._publishers))
            if oldest == self.driver:
                self.end(Reason("busy", "too many publish there"))
            self._publishers.pop(oldest)
        return publisher

    def _unfit(self, publisher: Publisher, asked: MotionMessage) -> Reason | None:
        if publisher.sequence is None and asked.by.sequence > 1 and not asked.arrived_s - self.joined_s >= JOINING_S:
            publisher.lose()  # its first message, number 1, came before
        if publisher.sequence is not None and asked.by.sequence <= publisher.sequence:
            return Reason("repeated", "")
        publisher.sequence = asked.by.sequence
        late_s = publisher.clock.late_s((asked.wall_ns - asked.by.sent_ns) / S_NS, asked.arrived_s)
        if not late_s <= self._limits.late_s:
            return Reason("late", f"it came {late_s:.1f} s late")
        made_ns = asked.motion.made_ns
        if made_ns is not None and not abs(old_s := (asked.by.sent_ns - made_ns) / S_NS) <= self._limits.late_s:
            when = "in the past" if old_s > 0 else "in the future"
            return Reason("late", f"its header's stamp is {abs(old_s):.1f} s {when}")
        return asked.motion.trouble

    def _refuse(self, gid: bytes, publisher: Publisher, why: Reason) -> None:
        if gid == self.driver:
            self.end(why)
        else:
            publisher.lose()
            self._report(gid, publisher, why)

    def _report(self, gid: bytes, publisher: Publisher, why: Reason) -> None:
        """Report each code once, until the publisher rests."""
        if why.code not in publisher.reported:
            publisher.reported.add(why.code)
            self.lost.append((gid, why))

    def _limited(self, twist: Stamped, ttl_s: float) -> TwistCommand:
        """Scale a twist down to the limits, in its direction."""
        speed, turn = hypot(twist.vx_mps, twist.vy_mps), abs(twist.wz_rps)
        share = min(1.0, self._limits.speed_mps / max(speed, 1e-9), self._limits.turn_rps / max(turn, 1e-9))
        return TwistCommand(
            vx_mps=twist.vx_mps * share, vy_mps=twist.vy_mps * share, wz_rps=twist.wz_rps * share, ttl_s=ttl_s
        )


def _rest(asked: MotionMessage) -> str:
    return "an empty trajectory" if isinstance(asked.motion, Way) else "a twist of zero"
