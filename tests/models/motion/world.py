"""A seeded world around the kernel: clients, links that break, devices that fail, a thief, a clock that jumps.

Everything is drawn from one seed and nothing sleeps or asks for the time, so the same seed is the same history.
"""

from collections import deque
from collections.abc import Callable
from heapq import heappop, heappush
from math import inf, nan
from random import Random

from lbr.operations.drive import kernel
from tests.models.motion.arena import Arena, Decide
from tests.models.motion.clients import Client
from tests.models.motion.message import Message
from tests.models.motion.surroundings import SIDES

PERIOD_S = 0.02
SENSE_S = 0.1
ATTITUDE_S = 0.04
OVERHEARD = 64
DISTANCES_M = (0.1, 0.19, 0.22, 0.28, 0.35, 0.5, 0.7, 1.0, 1.5, 2.5, 4.0, inf, inf)

Job = Callable[[], float]


class World:
    """Draws what happens next; `run` takes it step by step."""

    def __init__(self, seed: int, decide: Decide = kernel.decide) -> None:
        self.dice = Random(seed)
        self.arena = Arena(decide)
        self.clients = _clients(self.dice)
        self._time = self._shift = 0.0
        self._queue: list[tuple[float, int, Job | Message, Client | None]] = []
        self._count = 0
        self._link_until = dict.fromkeys((client.source for client in self.clients), 0.0)
        self._overheard: deque[Message] = deque(maxlen=OVERHEARD)
        self._leases: deque[str] = deque(["nobody's"], maxlen=OVERHEARD)
        self._distances = dict.fromkeys(SIDES, 2.0)
        self._estop = False
        self._motors_away = self._ranges_away = 0.0
        self._start()

    @property
    def clock_s(self) -> float:
        """Return the base's monotonic clock."""
        return self._time + self._shift

    def run(self, until_step: int) -> None:
        """Let happen what happens until this many events have reached the kernel."""
        arena, queue = self.arena, self._queue
        while arena.steps < until_step:
            self._time, _, what, client = heappop(queue)
            arena.now = self._time + self._shift
            if isinstance(what, Message):
                self._deliver(what, client)
            else:
                again_s = what()
                if again_s < inf:
                    self._after(again_s, what)

    # what clients use

    def send(self, message: Message, by: Client) -> None:
        """Carry a message: at once and surely on this machine; late, twice, in bursts or never from another."""
        dice = self.dice
        self._after(self._way_s(by), message, by)
        if by.remote and dice.random() < 0.03:
            self._after(0.5 * dice.random(), message, by)

    def stop(self, source: str) -> None:
        """Stop the base."""
        self.arena.stop(source)

    # what happens

    def _start(self) -> None:
        self._shift = 100.0
        self.arena.now = self.clock_s
        jobs: tuple[Job, ...] = (
            self._tick,
            self._motors,
            self._ranges,
            self._attitude,
            self._odometry,
            self._nature,
            self._thief,
            self._stopper,
            self._button,
            self._clock,
        )
        for job in jobs:
            self._after(0.01 * self.dice.random(), job)
        for client in self.clients:
            self._after(self.dice.random(), lambda client=client: client.act(self))  # type: ignore[misc]

    def _after(self, seconds: float, what: Job | Message, client: Client | None = None) -> None:
        self._count += 1
        heappush(self._queue, (self._time + seconds, self._count, what, client))

    def _deliver(self, message: Message, client: Client | None) -> None:
        reply = self.arena.command(message)
        if reply.accepted:
            self._overheard.append(message)
            if reply.lease:
                self._leases.append(reply.lease)
        if client is None:
            return
        if client.remote:
            self._after(self._way_s(client), lambda: self._answer(client, reply))
        else:
            client.answered(reply)

    def _answer(self, client: Client, reply: object) -> float:
        client.answered(reply)  # type: ignore[arg-type]
        return inf

    def _way_s(self, client: Client) -> float:
        dice = self.dice
        if not client.remote:
            return 0.002 * dice.random() if dice.random() < 0.98 else 0.4 * dice.random()
        heals = self._link_until[client.source]
        if heals > self._time:
            return heals - self._time + 0.001 * dice.random()
        if dice.random() < 0.01:
            self._link_until[client.source] = self._time + 8.0 * dice.random() ** 2
        return 0.03 * dice.random() if dice.random() < 0.97 else 0.35 * dice.random()

    def _tick(self) -> float:
        self.arena.tick()
        return PERIOD_S if self.dice.random() < 0.995 else 0.5 * self.dice.random()

    def _motors(self) -> float:
        dice, arena = self.dice, self.arena
        chance = dice.random()
        if chance < 0.004:
            arena.motors(armed=False)
        elif chance < 0.008:
            arena.motors_lost()
        elif chance < 0.01:
            arena.motors(at=arena.now - 0.5 * dice.random())
        else:
            arena.motors()
        return SENSE_S if chance < 0.995 else dice.random()

    def _ranges(self) -> float:
        dice, arena = self.dice, self.arena
        chance = dice.random()
        if chance < 0.9:
            for side, metres in self._distances.items():
                if metres < inf:
                    self._distances[side] = metres + (0.001 if dice.random() < 0.5 else -0.001)
        if chance < 0.15:
            self._distances[dice.choice(SIDES)] = dice.choice(DISTANCES_M)
        elif chance < 0.17:
            self._distances[dice.choice(SIDES)] = nan
        elif chance < 0.2:
            self._distances = {side: 1.0 + 2.0 * dice.random() for side in SIDES}
        frozen_s = 1.5 * dice.random() if 0.97 < chance < 0.98 else 0.0
        for count in range(int(frozen_s / SENSE_S)):
            self._after(count * SENSE_S, self._same_again)
        late_s = 0.4 * dice.random() if chance > 0.99 else 0.0
        arena.ranges(dict(self._distances), at=arena.now - late_s, twice=dice.random() < 0.95)
        return frozen_s + SENSE_S if chance < 0.985 else dice.random()

    def _attitude(self) -> float:
        """Fast and mostly right; now and then silent, late, mad, again or not known."""
        dice, arena = self.dice, self.arena
        chance = dice.random()
        if chance > 0.012:
            arena.attitude()
        elif chance < 0.002:
            arena.body.epochs["attitude"] += 1
            arena.attitude()
        elif chance < 0.004:
            arena.attitude(valid=False)
        elif chance < 0.006:
            arena.attitude(value=dice.choice((nan, inf, None, arena.body.turned_deg + dice.choice((-90.0, 4.0, 30.0)))))
        elif chance < 0.008:
            arena.attitude(heading=dice.choice((nan, None, -1.0, 361.0)))
        else:
            arena.attitude(at=arena.now - 0.3 * dice.random())
        return ATTITUDE_S if dice.random() > 0.004 else 0.6 * dice.random()

    def _odometry(self) -> float:
        dice, arena = self.dice, self.arena
        chance = dice.random()
        if chance > 0.03:
            arena.odometry()
        elif chance < 0.004:
            arena.body.epochs["odometry"] += 1
            arena.odometry()
        elif chance < 0.008:
            arena.odometry(valid=False)
        elif chance < 0.012:
            arena.odometry(value=dice.choice((nan, inf, None, arena.body.way_m + dice.choice((-3.0, 0.1)))))
        elif chance < 0.026:
            arena.odometry(stalled=True)
        else:
            arena.odometry(at=arena.now - 0.4 * dice.random())
        return SENSE_S if dice.random() > 0.005 else 0.6 * dice.random()

    def _nature(self) -> float:
        """Something holds the base, or its wires are swapped; not for long."""
        body = self.arena.body
        body.gain = self.dice.choice((0.0, 0.0, -1.0, 0.5)) if body.gain == 1.0 else 1.0
        return (8.0 if body.gain != 1.0 else 15.0) * self.dice.random()

    def _same_again(self) -> float:
        self.arena.ranges(dict(self._distances))
        return inf

    def _thief(self) -> float:
        """Replay what was overheard, and quote leases that are not one's own."""
        dice = self.dice
        if self._overheard and dice.random() < 0.7:
            for _ in range(1 + int(4 * dice.random() ** 3)):
                self._deliver(dice.choice(self._overheard), None)
        else:
            lease = dice.choice(self._leases)
            power, remote = dice.choice((0.0, 0.5, 0.9)), dice.random() < 0.5
            sent = self.clock_s - (dice.random() if dice.random() < 0.5 else 0.0)
            self._deliver(
                Message(source="thief", power=power, lease=lease, remote=remote, sent=sent, ahead_s=0.0), None
            )
        return 0.5 * dice.random()

    def _stopper(self) -> float:
        dice = self.dice
        source = dice.choice(self.clients).source
        self.arena.stop(source, self.clock_s - (0.1 * dice.random() if dice.random() < 0.3 else 0.0))
        if self._overheard and dice.random() < 0.3:
            self._deliver(self._overheard[-1], None)
        return 3.0 * dice.random()

    def _button(self) -> float:
        self._estop = not self._estop
        self.arena.latch(self._estop)
        return (1.5 if self._estop else 20.0) * self.dice.random()

    def _clock(self) -> float:
        """Now and then the clock says something mad once, or steps for good."""
        dice, arena = self.dice, self.arena
        chance = dice.random()
        if chance < 0.5:
            arena.now = dice.choice((nan, inf, -inf, -1.0, self.clock_s - 5.0, self.clock_s + 1e9))
            arena.tick()
        elif chance < 0.6:
            self._shift += dice.choice((-3600.0, -0.3, 0.3, 3600.0))
            arena.now = self.clock_s
            arena.tick()
        return 60.0 * dice.random()


def _clients(dice: Random) -> tuple[Client, ...]:
    return (
        Client("console", clock_ahead_s=0.0),
        Client("bench"),
        Client("stuck", habit="streams", clock_ahead_s=0.0),
        Client("page", remote=True, clock_ahead_s=1000.0 * dice.random()),
        Client("phone", remote=True, clock_ahead_s=-50.0),
        Client("plain", remote=True),
        Client("far stuck", habit="streams", remote=True, clock_ahead_s=0.0),
    )
