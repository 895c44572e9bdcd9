"""Who may move the base, once more and as simply as can be: an independent model to hold the drive kernel against."""

from math import inf, isnan, nan

from benchmarks.motion.message import Message
from benchmarks.motion.surroundings import Surroundings

MAX_POWER, ACCEL_PER_S, MAX_RUN_S, TTL_S = 0.8, 2.0, 5.0, 0.3
LATE_S, CHECKS_S = 0.3, 0.2
PAUSE_S = 0.25
MOTORS_S = 0.3
EARLY_S = 0.03
OFFERS = 8


class Lease:
    """A lease as the model knows it."""

    __slots__ = (
        "behind_s",
        "changed",
        "goal",
        "last_m",
        "last_seen",
        "message",
        "name",
        "renewed",
        "said",
        "ttl_s",
        "until",
    )

    def __init__(self, name: str, message: Message, said: float, now: float) -> None:
        self.name = name
        self.message = message
        self.said = said
        self.changed = now
        self.renewed: float | None = None
        self.ttl_s = TTL_S if message.ttl_s is None else message.ttl_s
        self.until = 0.0
        self.behind_s = inf
        self.goal = ""
        self.last_m = self.last_seen = nan


class Reference:
    """Time and events in, verdicts out. Written for reading, not for sharing a line with the kernel."""

    def __init__(self) -> None:
        self.clock = -inf
        self.hold: Lease | None = None
        self.offers: list[Lease] = []
        self.estop = False
        self.stopped = self.begun = -inf
        self.insisting: dict[str, float] = {}
        self.armed_at = -inf
        self.lost_at = -inf
        self.around = Surroundings()

    # time

    def advance(self, now: float) -> None:
        """End what is over by now."""
        if not now >= self.clock:
            self._clock_went_back(now)
        self.clock = now
        self._offers_end(now)
        self._hold_ends(now)

    def _clock_went_back(self, now: float) -> None:
        self.hold, self.offers = None, []
        self.armed_at, self.lost_at = -inf, now
        self.stopped = self.begun = now
        recent = [source for source, until in self.insisting.items() if not self.clock >= until]
        self.insisting = dict.fromkeys(recent, now + PAUSE_S)
        self.around.forget()

    def _offers_end(self, now: float) -> None:
        armed = self.armed(now)
        self.offers = [offer for offer in self.offers if armed and now < offer.until]

    def _hold_ends(self, now: float) -> None:
        hold = self.hold
        if hold is None:
            return
        interval_s = hold.message.interval_s if hold.message.power > 0.0 else 0.0
        timed_out = interval_s > 0.0 and not now < hold.changed + interval_s
        ran_out = hold.message.power > 0.0 and not now - hold.changed < MAX_RUN_S
        if not self.armed(now) or not now < hold.until or timed_out or ran_out or self._at_range(hold, now):
            self.hold = None

    def _at_range(self, hold: Lease, now: float) -> bool:
        message = hold.message
        if not (message.power > 0.0 and message.range_cm > 0.0):
            return False
        return self._passed(message, hold.last_m) or not now - hold.last_seen <= 0.3

    def _passed(self, message: Message, value_m: float) -> bool:
        target_m = message.range_cm / 100
        return value_m <= target_m if message.angle_deg == 0.0 else value_m >= target_m

    def armed(self, now: float) -> bool:
        """Say whether the motors would follow."""
        return now - self.armed_at <= MOTORS_S

    # what happens

    def stop(self, source: str, sent: float, now: float) -> None:
        """Somebody stopped it."""
        self.insisting.pop(source, None)
        self.stopped = max(self.stopped, min(now, sent))  # NaN means now
        self.hold, self.offers = None, []

    def latch(self, engaged: bool, now: float) -> None:
        """The emergency stop was pressed or reset."""
        self.estop = engaged
        self.stopped = max(self.stopped, now)
        self.hold, self.offers = None, []

    def motors(self, armed: bool, at: float, now: float) -> None:
        """The motor driver spoke."""
        if not at < self.lost_at:
            self.armed_at = min(at, now) if armed else -inf
        self._offers_end_now(now)

    def motors_lost(self, now: float) -> None:
        """The motor driver is gone."""
        self.armed_at, self.lost_at = -inf, now
        self._offers_end_now(now)

    def _offers_end_now(self, now: float) -> None:
        self._offers_end(now)
        self._hold_ends(now)

    def ranges(self, distances: dict[str, float], at: float, now: float, *, twice: bool) -> None:
        """Distances came."""
        self.around.see(distances, min(at, now), twice=twice)
        hold = self.hold
        if hold is not None and hold.message.range_cm > 0.0:
            value_m = distances["forward"]
            if not isnan(value_m) and not at < hold.last_seen:
                hold.last_m, hold.last_seen = value_m, min(at, now)
            self._hold_ends(now)

    # commands

    def command(self, message: Message, arrived: float, now: float, name: str, checked: bool) -> bool | None:
        """Return whether a command is accepted (None: cannot be told) and do what follows; `name` is its new lease's."""
        if message.power == 0.0 and not message.lease:
            self.stop(message.source, arrived if message.remote else self._dated(message, arrived), now)
            return True
        verdict = self._verdict(message, arrived, now, checked)
        if verdict is False:
            self._note_insisting(message, now)
        elif verdict is True:
            self._accept(message, arrived, now, name)
        return verdict

    def settle(self, message: Message, arrived: float, now: float, name: str, accepted: bool) -> None:
        """Take the kernel's word for what could not be told."""
        if accepted:
            self._accept(message, arrived, now, name)
        else:
            self._note_insisting(message, now)

    def _quoted(self, name: str) -> Lease | None:
        known = [lease for lease in [self.hold, *self.offers] if lease is not None and lease.name == name]
        return known[0] if name and known else None

    def _behind_s(self, message: Message, arrived: float, lease: Lease | None) -> float:
        if not message.remote or isnan(message.ahead_s):
            return inf
        seen_s = arrived - (message.sent + message.ahead_s)
        return min(seen_s, lease.behind_s) if lease and lease.message.source == message.source else seen_s

    def _dated(self, message: Message, arrived: float) -> float:
        if not message.remote:
            return arrived if isnan(message.ahead_s) else min(arrived, message.sent)
        behind_s = self._behind_s(message, arrived, self._quoted(message.lease))
        return arrived if behind_s == inf else message.sent + message.ahead_s + behind_s

    def _verdict(self, message: Message, arrived: float, now: float, checked: bool) -> bool | None:
        moves = message.power > 0.0
        dated = self._dated(message, arrived)
        if moves and not 0.0 <= now - min(arrived, dated) <= LATE_S + (CHECKS_S if checked else 0.0):
            return False
        if moves and message.remote and not message.lease and not message.answerable:
            return False
        if message.role == "view" or (checked and not message.check):
            return False
        if not self._may_hold(message, dated):
            return False
        if not moves:
            return True
        if self.estop or not self.armed(now) or not now >= self.insisting.get(message.source, -inf):
            return False
        hold = self.hold
        if hold is not None and message.lease == hold.name and message.what == hold.message.what:
            return True
        return self._way_is_free(message, now)

    def _may_hold(self, message: Message, dated: float) -> bool:
        hold, quoted = self.hold, self._quoted(message.lease)
        foreign = quoted is not None and message.source != quoted.message.source
        if foreign and message.remote and message.power > 0.0:
            return False
        if hold is not None and quoted is hold:
            newest = hold.said
            if message.what == hold.message.what:
                newest = max(newest, -inf if hold.renewed is None else hold.renewed)
            return message.power == 0.0 or dated > newest
        if message.lease and quoted is None:
            return False
        takes = message.take_over or (quoted is not None and quoted.message.take_over)
        if hold is not None and (not takes or self._streams(hold, message)):
            return False
        return (self.estop or dated > self.stopped) and dated > self.begun

    def _way_is_free(self, message: Message, now: float) -> bool | None:
        if message.interval_s > MAX_RUN_S:
            return False
        if message.range_cm > 0.0:
            forward = self.around.sights["forward"]
            if forward.unknown(now) or self._passed(message, forward.value_m):
                return False
        blocked = self.around.blocked(message.angle_deg, now)
        return None if blocked is None else not blocked

    def _note_insisting(self, message: Message, now: float) -> None:
        if not message.power > 0.0:
            return
        hold, source = self.hold, message.source
        streams = hold is not None and self._streams(hold, message)
        if self.estop or streams or not now >= self.insisting.get(source, -inf):
            self.insisting[source] = now + PAUSE_S

    def _streams(self, hold: Lease, message: Message) -> bool:
        return hold.message.source == message.source and hold.renewed is None and not message.lease

    def _accept(self, message: Message, arrived: float, now: float, name: str) -> None:
        dated, quoted = self._dated(message, arrived), self._quoted(message.lease)
        behind_s = self._behind_s(message, arrived, quoted)
        if quoted is None and message.remote:
            self._offer(Lease(name, message, dated, now), behind_s, now)
            return
        lease = self._lease_after(message, quoted, dated, now, name)
        if quoted is not None:
            lease.renewed = dated if quoted.renewed is None else max(dated, quoted.renewed)
        if quoted is None:
            lease.behind_s = behind_s
        else:
            lease.behind_s = (
                min(quoted.behind_s, behind_s) if message.source == quoted.message.source else quoted.behind_s
            )
        lease.ttl_s = TTL_S if message.ttl_s is None else message.ttl_s
        since = now if lease.renewed is None else lease.renewed
        lease.until = since + lease.ttl_s - min(EARLY_S, lease.ttl_s / 5)
        if lease is not self.hold and (self.hold is None or lease.name != self.hold.name):
            self.begun = max(self.begun, lease.said)
        self.offers = [offer for offer in self.offers if offer is not quoted]
        self.hold = lease

    def _lease_after(self, message: Message, quoted: Lease | None, dated: float, now: float, name: str) -> Lease:
        if quoted is not None and quoted is self.hold and message.what == quoted.message.what:
            return quoted
        lease = Lease(message.lease or name, message, dated, now)
        if quoted is not None:
            lease.message = message.by(quoted.message.source)
        if quoted is not None and quoted is self.hold:
            lease.said = max(quoted.said, dated)
        if message.range_cm > 0.0:
            forward = self.around.sights["forward"]
            lease.last_m, lease.last_seen = forward.value_m, forward.seen
        return lease

    def _offer(self, lease: Lease, behind_s: float, now: float) -> None:
        own = [offer for offer in self.offers if offer.message.source == lease.message.source]
        gone = own or (self.offers[:1] if len(self.offers) >= OFFERS else [])
        lease.behind_s, lease.until = behind_s, now + lease.ttl_s
        self.offers = [*(offer for offer in self.offers if offer not in gone), lease]
