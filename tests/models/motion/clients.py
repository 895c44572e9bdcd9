"""Who wants to move the base in a simulated world: honest ones, careless ones, and ones behind a bad link."""

from math import isnan, nan
from random import Random
from typing import Literal, Protocol

from msgspec.structs import replace

from lbr.messages.leases import CommandReply
from tests.models.motion.message import Message

RENEW_S = 0.1
ANGLES = (0.0, 0.0, 0.0, 30.0, -30.0, 90.0, -90.0, 150.0, 180.0, 180.0, 210.0)
TWIST_POWERS = frozenset({0.2, 0.6})
"""What asks for these is said as a twist, where it has no bounds."""
POWERS = (0.05, 0.2, 0.4, 0.6, 0.8, 1.0)
TURNS = (-360.0, -90.0, -2.0, 0.0, 5.0, 45.0, 90.0, 180.0)
HEADINGS = (0.0, 90.0, 180.0, 270.0, 360.0)
DISTANCES_CM = (2.0, 20.0, 100.0, 500.0)
TTLS = (None, None, None, None, 0.05, 0.15, 0.6, 1.0)

Habit = Literal["renews", "streams"]


class Post(Protocol):
    """Where clients hand in their messages."""

    dice: Random
    clock_s: float

    def send(self, message: Message, by: "Client") -> None:
        """Carry a message to the base, sooner or later, and the reply back."""

    def stop(self, source: str) -> None:
        """Stop the base."""


class Client:
    """One sender: asks, renews what it was given, changes its mind, and ends in one of several ways."""

    def __init__(
        self, source: str, *, habit: Habit = "renews", remote: bool = False, clock_ahead_s: float = nan
    ) -> None:
        self.source = source
        self.habit = habit
        self.remote = remote
        self.clock_ahead_s = clock_ahead_s
        self.lease = ""
        self.wanted: Message | None = None
        self.until = 0.0

    def act(self, post: Post) -> float:
        """Do what is to be done now; return in how many seconds to come back."""
        dice, now = post.dice, post.clock_s
        if self.wanted is None or isnan(now):
            return self._begin(post)
        if not now < self.until:
            return self._end(post)
        if self.habit == "streams":
            post.send(self._now(self.wanted, now, lease=""), self)
            return 0.05
        if dice.random() < (0.02 if self.wanted.turns or self.wanted.distance_cm else 0.1):
            self.wanted = self._choose(dice)
        if self.lease or self.remote:
            post.send(self._now(self.wanted, now, lease=self.lease), self)
        return RENEW_S * (0.5 + dice.random()) if dice.random() < 0.95 else 0.35

    def answered(self, reply: CommandReply) -> None:
        """Learn what became of a command."""
        if reply.accepted:
            self.lease = reply.lease or self.lease
        elif reply.code == "dead_lease":
            self.lease = ""

    def _begin(self, post: Post) -> float:
        dice = post.dice
        self.lease, self.wanted = "", self._choose(dice)
        self.until = post.clock_s + 6.0 * dice.random() ** 2
        post.send(self._now(self.wanted, post.clock_s, lease="", asks=True), self)
        return 0.02 + 0.1 * dice.random()

    def _end(self, post: Post) -> float:
        dice, wanted = post.dice, self.wanted
        assert wanted is not None
        way = dice.random()
        if way < 0.4:
            post.stop(self.source)
        elif way < 0.6:
            post.send(
                Message(source=self.source, power=0.0, lease=self.lease, remote=self.remote, sent=post.clock_s), self
            )
        self.wanted = None
        return 3.0 * dice.random() ** 2

    def _choose(self, dice: Random) -> Message:
        kind, angle_deg = dice.random(), dice.choice(ANGLES)
        straight = angle_deg in {0.0, 180.0} and kind > 0.3
        range_cm = dice.choice((40.0, 80.0)) if straight and dice.random() < 0.2 else 0.0
        found = Message(
            source=self.source,
            power=0.0 if kind < 0.3 else dice.choice(POWERS),
            angle_deg=angle_deg,
            range_cm=range_cm,
            turn_deg=dice.choice(TURNS) if kind < 0.2 else None,
            heading_deg=dice.choice(HEADINGS) if 0.2 <= kind < 0.3 else None,
            distance_cm=dice.choice(DISTANCES_CM) if straight and kind < 0.7 else 0.0,
            interval_s=dice.choice((0.1, 0.5, 2.0, 6.0)) if kind > 0.3 and dice.random() < 0.2 else 0.0,
            ttl_s=dice.choice(TTLS),
            take_over=dice.random() < 0.3,
            remote=self.remote,
            answerable=dice.random() < 0.9,
            ahead_s=self.clock_ahead_s,
            check=None if dice.random() < 0.9 else dice.random() < 0.7,
        )
        bounded = found.range_cm or found.distance_cm or found.interval_s or found.turns
        return found if bounded or found.power not in TWIST_POWERS else replace(found, twist=True)

    def _now(self, wanted: Message, now: float, *, lease: str, asks: bool = False) -> Message:
        return Message(
            wanted.source,
            wanted.power,
            wanted.angle_deg,
            lease,
            wanted.range_cm,
            wanted.interval_s,
            wanted.ttl_s,
            wanted.take_over,
            wanted.remote,
            wanted.answerable,
            now,
            wanted.ahead_s,
            wanted.check if asks else None,
            wanted.turn_deg,
            wanted.heading_deg,
            wanted.distance_cm,
            wanted.twist,
        )
