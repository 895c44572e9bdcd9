"""Figures of the kernel that are counted instead of measured: how often it was tried, and what went wrong."""

from collections.abc import Callable
from math import nan
from random import Random

import msgspec

from lbr.bus import stamp
from lbr.messages.leases import CommandReply
from tests.models.motion.arena import Arena, ViolationError
from tests.models.motion.message import Message
from tests.models.motion.surroundings import SIDES

TICK_S, SENSE_S, RENEW_S = 0.02, 0.1, 0.05
FAR_M, NEAR_M, TARGET_CM = 1.5, 0.6, 90.0
EARLY_S, LATE_S = 0.020, 0.040
OLD_S = 0.3
PERIOD_STEPS = 5
LARGEST = 2**63 - 1


class Count(msgspec.Struct, kw_only=True):
    """How often something was tried, and what must not have been."""

    figure: str
    tried: int = 0
    problems: list[str] = msgspec.field(default_factory=list)


class Stage:
    """An arena that lives: motors and ranges speak, ticks come, a little late at times."""

    def __init__(self, dice: Random) -> None:
        self.dice = dice
        self.arena = Arena()
        self.distances = dict.fromkeys(SIDES, FAR_M)
        self._steps = 0
        self.hear()
        self.arena.attitude()
        self.arena.tick()

    def hear(self) -> None:
        """Let motors and ranges speak."""
        for side in SIDES:
            self.distances[side] += self.dice.choice((-0.001, 0.001))
        self.arena.motors()
        self.arena.ranges(dict(self.distances))
        self.arena.odometry()

    def turn(self) -> None:
        """Let one tick pass."""
        self._steps += 1
        self.arena.now += TICK_S * self.dice.uniform(0.9, 1.2)
        if self._steps % PERIOD_STEPS == 0:
            self.hear()
        self.arena.attitude()
        self.arena.tick()

    @property
    def moves(self) -> bool:
        """Say whether the wheels turn."""
        return self.arena.state.left != 0.0 or self.arena.state.right != 0.0

    def drive(self, message: Message) -> tuple[str, Message]:
        """Begin a motion and renew it once; return its lease and what renews it."""
        lease = self.arena.command(message).lease
        self.arena.now += 0.001
        renewal = self.again(message, lease)
        if not self.arena.command(renewal).accepted:
            raise ViolationError(f"it does not begin: {renewal}")
        return lease, renewal

    def again(self, message: Message, lease: str) -> Message:
        """Return the same, said now."""
        return msgspec.structs.replace(message, lease=lease, sent=self.arena.now)

    def other(self, message: Message, lease: str) -> Message:
        """Return another motion of the same sender, or the same, said now."""
        if message.turns:
            return msgspec.structs.replace(self.again(message, lease), turn_deg=self.dice.choice((-90.0, 300.0)))
        return msgspec.structs.replace(self.again(message, lease), power=self.dice.choice((0.2, 0.5)))

    def asked(self, *, remote: bool, ahead_s: float) -> Message:
        """Return a motion that a client begins with: it drives, or it turns."""
        turns = self.dice.random() < 0.5
        power, turn_deg = (0.0, 300.0) if turns else (0.5, None)
        return Message("page", power, turn_deg=turn_deg, remote=remote, ahead_s=ahead_s, sent=self.arena.now)


def healed_partitions(n: int, seed: int = 1) -> Count:
    """F1: a link is cut for 0.3 to 8 s and then delivers everything at once; nothing old may be acted on."""
    dice, count = Random(seed), Count(figure="F1")
    while count.tried < n:
        stage = Stage(dice)
        ahead_s = dice.choice((nan, dice.uniform(-1e6, 1e6)))
        asked = stage.asked(remote=True, ahead_s=ahead_s)
        lease, _ = stage.drive(asked)
        held_back = _cut(stage, asked, lease, dice.uniform(0.3, 8.0))
        for message in held_back:
            _expect_rest(stage, message, count)
    return count


def _cut(stage: Stage, asked: Message, lease: str, seconds: float) -> list[Message]:
    """Return what a client sends into a link that is down, quoting its lease or asking again."""
    ends, due, sent = stage.arena.now + seconds, stage.arena.now, []
    while stage.arena.now < ends:
        stage.turn()
        if stage.arena.now >= due:
            due += RENEW_S
            quoted = stage.dice.choice((lease, lease, ""))
            sent.append(stage.other(asked, quoted))
    return sent


def _expect_rest(stage: Stage, message: Message, count: Count) -> None:
    count.tried += 1
    age_s = stage.arena.now - message.sent
    _tried(count, stage, message)
    if age_s > OLD_S and (stage.moves or stage.arena.holder):
        count.problems.append(f"it moves for a command {age_s:.2f} s old: {message}")
        stage.arena.stop("benchmark")


def replays(n: int, seed: int = 1) -> Count:
    """F2: whatever was once said is said again, byte for byte, while it still moves and after it; none may count."""
    dice, count = Random(seed), Count(figure="F2")
    while count.tried < n:
        stage = Stage(dice)
        remote = dice.random() < 0.5
        asked = stage.asked(remote=remote, ahead_s=dice.uniform(-1e6, 1e6))
        lease, renewal = stage.drive(asked)
        said = [asked, renewal]
        for _ in range(10):
            stage.turn()
            change = stage.other(asked, lease)
            if stage.arena.command(change).accepted:
                said.append(change)
            _again(stage, dice.choice(said), count)
        stage.arena.stop("page")
        for _ in range(50):
            stage.turn()
            _again(stage, dice.choice(said), count)
    return count


def _again(stage: Stage, message: Message, count: Count) -> None:
    count.tried += 1
    before = stage.arena.state.lease
    reply = _tried(count, stage, message)
    offered = message.remote and not message.lease
    if (reply is not None and reply.accepted and not offered) or stage.arena.state.lease != before:
        count.problems.append(f"a repetition counted: {message}")


def numbered(n: int, seed: int = 1) -> Count:
    """F3: stamps with duplicate, reordered, missing, wrapped, negative and huge numbers; order is what their time says."""
    dice, count = Random(seed), Count(figure="F3")
    stage, lease, newest = Stage(dice), "", 0
    while count.tried < n:
        if not stage.arena.holder or dice.random() < 0.005:
            stage = Stage(dice)
            asked = Message(source="page", power=0.5, remote=True, ahead_s=0.0, sent=stage.arena.now)
            lease, renewal = stage.drive(asked)
            newest = int(renewal.sent * 1e9)
        if dice.random() < 0.2:
            stage.turn()
        mono_ns, seq = _odd_numbers(dice, newest, int(stage.arena.now * 1e9))
        found = stamp.read(_attachment(seq, mono_ns))
        sent, ahead_s = (stage.arena.now, nan) if found is None else (found.mono_ns / 1e9, 0.0)
        message = Message("page", 0.5, lease=lease, remote=True, sent=sent, ahead_s=ahead_s)
        count.tried += 1
        before = stage.arena.state.lease
        reply = _tried(count, stage, message)
        if reply is None or (reply.accepted and found is not None and found.mono_ns <= newest):
            count.problems.append(f"{mono_ns} counted after {newest}")
        if reply is not None and not reply.accepted and stage.arena.state.lease not in {before, None}:
            count.problems.append(f"{mono_ns} was refused and still changed the hold")
        if reply is not None and reply.accepted and found is not None:
            newest = found.mono_ns
    return count


def _odd_numbers(dice: Random, newest: int, now: int) -> tuple[int, int]:
    """Return a time and a sequence number such as a careless or hostile sender gives."""
    way = dice.random()
    if way < 0.3:
        mono_ns = now
    elif way < 0.5:
        mono_ns = newest
    elif way < 0.7:
        mono_ns = newest - dice.randrange(1, 10**9)
    elif way < 0.8:
        mono_ns = (newest + dice.randrange(10**10)) % 2 ** dice.choice((31, 32, 63))
    else:
        mono_ns = dice.choice((0, -1, -newest, LARGEST, LARGEST + 1, 10**30, now + 10**9))
    return mono_ns, dice.choice((0, 1, -1, newest % 2**32, LARGEST, LARGEST + 1, 10**40))


def _attachment(seq: int, mono_ns: int) -> bytes:
    return b'{"source":"page","seq":%d,"mono_ns":%d,"wall_ns":0,"boot":"afar"}' % (seq, mono_ns)


def bounded_moves(n: int, seed: int = 1) -> Count:
    """S18: moves end with their time, not 20 ms sooner nor 40 ms later, and with the reading that crosses their range."""
    dice, count = Random(seed), Count(figure="S18")
    while count.tried < n:
        count.tried += 1
        move = _interval if dice.random() < 0.5 else _range
        if why := move(Stage(dice)):
            count.problems.append(why)
    return count


def _interval(stage: Stage) -> str:
    interval_s = stage.dice.uniform(0.1, 4.0)
    remote = stage.dice.random() < 0.5
    asked = Message(
        source="console", power=0.4, angle_deg=90.0, interval_s=interval_s, remote=remote, sent=stage.arena.now
    )
    lease, _ = stage.drive(asked)
    began = stage.arena.now if remote else asked.sent
    while stage.arena.holder and stage.arena.now < began + interval_s + 1.0:
        stage.turn()
        stage.arena.command(stage.again(asked, lease))
    late_s = stage.arena.now - began - interval_s
    if stage.moves or not -EARLY_S <= late_s <= LATE_S:
        return f"a move of {interval_s:.3f} s ended {late_s * 1000:.1f} ms late"
    return ""


def _range(stage: Stage) -> str:
    asked = Message(source="console", power=0.4, range_cm=TARGET_CM, sent=stage.arena.now)
    lease, _ = stage.drive(asked)
    for _ in range(stage.dice.randrange(5, 40)):
        stage.turn()
        stage.arena.command(stage.again(asked, lease))
    moved = stage.moves
    stage.distances["forward"] = NEAR_M
    stage.hear()
    return "" if moved and not stage.moves and not stage.arena.holder else "a range was crossed and it drives on"


def _tried(count: Count, stage: Stage, message: Message) -> CommandReply | None:
    try:
        return stage.arena.command(message)
    except ViolationError as err:
        count.problems.append(str(err))
        return None


FIGURES: dict[str, tuple[Callable[[int, int], Count], int]] = {
    "F1": (healed_partitions, 10_000),
    "F2": (replays, 10_000),
    "F3": (numbered, 100_000),
    "S18": (bounded_moves, 200),
}
"""Each with the amount that it is promised for."""
