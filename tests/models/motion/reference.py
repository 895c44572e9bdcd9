"""Who may move the base, once more and as simply as can be: an independent model to hold the drive kernel against."""

from math import inf, isnan, nan

from tests.models.motion.message import Message
from tests.models.motion.senses import FULL_DPS, Sense
from tests.models.motion.surroundings import Surroundings

MAX_POWER, ACCEL_PER_S, MAX_RUN_S, TTL_S = 0.8, 2.0, 5.0, 0.3
LATE_S, CHECKS_S = 0.3, 0.2
PAUSE_S = 0.25
MOTORS_S = 0.3
EARLY_S = 0.03
OFFERS = 8
TURN_POWER, TURN_SPARE_S, TURN_TOLERANCE_DEG = 0.2, 4.0, 1.0
STUCK_S, STUCK_DEG, AWAY_DEG = 1.0, 2.0, 5.0
WAY_TOLERANCE_M, RANGE_TOLERANCE_M, WRONG_M = 0.02, 0.06, 0.15


class Lease:
    """A lease as the model knows it."""

    __slots__ = (
        "asked",
        "begun",
        "behind_s",
        "changed",
        "epoch",
        "goal",
        "last_m",
        "last_seen",
        "message",
        "name",
        "nearest",
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
        self.asked = self.begun = self.nearest = nan
        self.epoch = ""


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
        self.attitude, self.odometry = Sense("attitude"), Sense("odometry")

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
        self.around.forget(now)
        self.attitude.forget()
        self.odometry.forget()

    def _offers_end(self, now: float) -> None:
        armed = self.armed(now)
        self.offers = [offer for offer in self.offers if armed and now < offer.until]

    def _hold_ends(self, now: float) -> None:
        hold = self.hold
        if hold is None:
            return
        interval_s = hold.message.interval_s if hold.message.moves else 0.0
        timed_out = interval_s > 0.0 and not now < hold.changed + interval_s
        ran_out = hold.message.moves and not now - hold.changed < MAX_RUN_S
        dead = not self.armed(now) or not now < hold.until
        if dead or timed_out or ran_out or self._at_range(hold, now) or self._lost(hold, now):
            self.hold = None

    def _lost(self, hold: Lease, now: float) -> bool:
        """Say whether a turn or a way has lost what it goes by, or its time is over."""
        if hold.message.turns:
            return not (self._sees(self.attitude, hold, now) and now < self._turn_ends(hold))
        if self._travels(hold.message):
            return not self._sees(self.odometry, hold, now) or self.odometry.stalled
        return False

    def _at_range(self, hold: Lease, now: float) -> bool:
        message = hold.message
        if not (message.power > 0.0 and message.range_cm > 0.0):
            return False
        return self._passed(message, hold.last_m) or not now - hold.last_seen <= 0.3

    @staticmethod
    def _travels(message: Message) -> bool:
        return not message.turns and message.power > 0.0 and message.distance_cm > 0.0

    @staticmethod
    def _sees(sense: Sense, hold: Lease, now: float) -> bool:
        return sense.known(now) and sense.epoch == hold.epoch

    @staticmethod
    def _turn_ends(hold: Lease) -> float:
        return hold.changed + TURN_SPARE_S + 2.0 * abs(hold.asked) / (TURN_POWER * FULL_DPS)

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

    def feel(self, sense: Sense, told: dict[str, object], at: float, now: float) -> None:
        """Attitude or odometry came."""
        sense.hear(told, min(at, now))
        hold = self.hold
        if hold is not None and (hold.message.turns if sense is self.attitude else self._travels(hold.message)):
            self._hold_ends(now)
            hold.nearest = min(hold.nearest, abs(self.left(hold)))

    def left(self, hold: Lease) -> float:
        """Return how far a turn (degrees, clockwise) or a way (metres ahead) has yet to go, by what was told."""
        sense = self.attitude if hold.message.turns else self.odometry
        return hold.asked - (sense.value - hold.begun)

    @property
    def nears_a_range(self) -> bool:
        """Say whether a range that is asked for is as near as readings tell: a base that stands there has reached it."""
        hold = self.hold
        if hold is None or not (hold.message.power > 0.0 and hold.message.range_cm > 0.0):
            return False
        return abs(hold.last_m - hold.message.range_cm / 100) <= RANGE_TOLERANCE_M

    def ended(self, how: str, why: str, standing: bool) -> str:
        """Take the kernel's word, a code, that what is held came to an end by itself; return why it cannot be so, or nothing."""
        hold = self.hold
        if how == "reached" and standing and self.nears_a_range:
            self.hold = None
            return ""
        if hold is None or not (hold.message.turns or self._travels(hold.message)):
            return f"nothing that could have ended: {how} {why}"
        left, self.hold = self.left(hold), None
        if how == "reached":
            past = not hold.message.turns and left * hold.asked <= 0.0
            near = TURN_TOLERANCE_DEG if hold.message.turns else WAY_TOLERANCE_M
            return "" if standing and (past or abs(left) <= near + 1e-6) else f"{left} to go: {why}"
        if why == "stuck" and hold.message.turns:
            return "" if self.attitude.range_over(STUCK_S) <= STUCK_DEG else f"it turns: {why}"
        if why == "not_followed" and hold.message.turns:
            return "" if abs(left) > hold.nearest + AWAY_DEG - 1e-6 else f"it does not: {why}"
        if why == "not_followed":
            return "" if abs(left) > abs(hold.asked) + WRONG_M - 1e-6 else f"they do not: {why}"
        return f"it need not have ended: {how} {why}"

    # commands

    def command(self, message: Message, arrived: float, now: float, name: str, checked: bool) -> bool | None:
        """Return whether a command is accepted (None: cannot be told) and do what follows; `name` is its new lease's."""
        if not message.moves and not message.lease:
            self.stop(message.source, arrived if message.remote else self._dated(message, arrived), now)
            return True
        verdict = self._verdict(message, arrived, now, checked)
        if verdict is False:
            self._note_insisting(message, arrived, now)
        elif verdict is True:
            self._accept(message, arrived, now, name)
        return verdict

    def settle(self, message: Message, arrived: float, now: float, name: str, accepted: bool) -> None:
        """Take the kernel's word for what could not be told."""
        if accepted:
            self._accept(message, arrived, now, name)
        else:
            self._note_insisting(message, arrived, now)

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
        moves = message.moves
        dated = self._dated(message, arrived)
        if moves and not 0.0 <= now - min(arrived, dated) <= LATE_S + (CHECKS_S if checked else 0.0):
            return False
        if moves and message.remote and not message.lease and not message.answerable:
            return False
        if checked and not message.check:
            return False
        if not self._may_hold(message, dated):
            return False
        if not moves:
            return True
        if self.estop or not self.armed(now) or self._insists(message, arrived, now):
            return False
        hold = self.hold
        if hold is not None and message.lease == hold.name and message.what == hold.message.what:
            return True
        return self._way_is_free(message, now)

    def _may_hold(self, message: Message, dated: float) -> bool:
        hold, quoted = self.hold, self._quoted(message.lease)
        foreign = quoted is not None and message.source != quoted.message.source
        if foreign and message.remote and message.moves:
            return False
        if hold is not None and quoted is hold:
            newest = max(hold.said, -inf if hold.renewed is None else hold.renewed)
            return not message.moves or dated > newest
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
        if message.turns and not self._may_turn(message, now):
            return False
        if self._travels(message) and not (message.angle_deg in {0.0, 180.0} and self.odometry.known(now)):
            return False
        blocked = self.around.blocked(message.towards_deg, now)
        return None if blocked is None else not blocked

    def _may_turn(self, message: Message, now: float) -> bool:
        blind = message.heading_deg is not None and isnan(self.attitude.heading_deg)
        return self.attitude.known(now) and not blind

    def _insists(self, message: Message, arrived: float, now: float) -> bool:
        """Say whether its source sent this without a pause after what was refused."""
        return min(now, self._dated(message, arrived)) < self.insisting.get(message.source, -inf)  # NaN means now

    def _note_insisting(self, message: Message, arrived: float, now: float) -> None:
        if not message.moves:
            return
        hold, source = self.hold, message.source
        streams = hold is not None and self._streams(hold, message)
        if self.estop or streams or self._insists(message, arrived, now):
            until = min(now, self._dated(message, arrived)) + PAUSE_S
            self.insisting[source] = max(until, self.insisting.get(source, -inf))

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
        if message.turns:
            lease.asked, lease.begun, lease.epoch = self._turn(message), self.attitude.value, self.attitude.epoch
        elif self._travels(message):
            sense = 1.0 if message.angle_deg == 0.0 else -1.0
            lease.asked, lease.begun = sense * message.distance_cm / 100, self.odometry.value
            lease.epoch = self.odometry.epoch
        lease.nearest = abs(lease.asked)
        return lease

    def _turn(self, message: Message) -> float:
        """Return how far to turn; to a heading not more than half a turn, and a whole half of it clockwise."""
        if message.turn_deg is not None:
            return message.turn_deg
        assert message.heading_deg is not None
        clockwise_deg = (message.heading_deg - self.attitude.heading_deg) % 360.0
        return clockwise_deg if clockwise_deg <= 360.0 - clockwise_deg else clockwise_deg - 360.0

    def _offer(self, lease: Lease, behind_s: float, now: float) -> None:
        own = [offer for offer in self.offers if offer.message.source == lease.message.source]
        gone = own or (self.offers[:1] if len(self.offers) >= OFFERS else [])
        lease.behind_s, lease.until = behind_s, now + lease.ttl_s
        self.offers = [*(offer for offer in self.offers if offer not in gone), lease]
