"""Everything that can happen to the drive kernel, in an order that Hypothesis chooses and shrinks."""

from math import inf, nan
from typing import Any

from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, precondition, rule
from msgspec.structs import replace

from tests.models.motion.arena import Arena
from tests.models.motion.message import Message
from tests.models.motion.surroundings import GUARDED, SIDES

AHEAD_S = {"console": 0.0, "bench": nan, "page": 1e4, "phone": -50.0, "plain": nan}
REMOTE = {"page", "phone", "plain"}

sources = st.sampled_from(sorted(AHEAD_S))
powers = st.sampled_from([0.0, 0.1, 0.4, 0.8, 1.0])
angles = st.sampled_from(sorted(GUARDED))
rarely = st.sampled_from([False, False, False, True])
steps_s = st.sampled_from([0.0, 0.001, 0.02, 0.02, 0.02, 0.05, 0.1, 0.29, 0.31, 0.7])
ages_s = st.sampled_from([0.0, 0.0, 0.0, 0.01, 0.1, 0.29, 0.31, 5.0])
metres = st.sampled_from([0.1, 0.22, 0.27, 0.4, 1.0, 3.0, inf, nan])
times = st.sampled_from([nan, inf, -inf, -1.0, 0.0, 1e9])
bounds = st.sampled_from([{}, {}, {}, {"interval_s": 0.1}, {"interval_s": 0.5}, {"interval_s": 9.0}])
ranges_cm = st.sampled_from([0.0, 0.0, 0.0, 40.0, 80.0])
ttls_s = st.sampled_from([None, None, None, 0.05, 1.0])
turns = st.sampled_from([-360.0, -90.0, -1.0, 0.0, 3.0, 45.0, 180.0])
headings = st.sampled_from([0.0, 76.0, 77.0, 90.0, 257.0, 360.0])
checks = st.sampled_from([None] * 8 + [True, False])


class MotionMachine(RuleBasedStateMachine):
    """Sources, leases, stops, faults, sensors and clocks; the arena compares kernel and model after each."""

    @initialize()
    def begin(self) -> None:
        self.arena = Arena()
        self.leases: list[tuple[str, Message]] = []
        self.sent: list[Message] = []
        self.distances = dict.fromkeys(SIDES, 2.0)
        self.frozen = False
        self.arena.motors()
        self._hear()
        self.arena.tick()

    # time

    @rule(dt_s=steps_s, heard=st.sampled_from([True, True, True, False]))
    def time_passes(self, dt_s: float, heard: bool) -> None:
        self.arena.now += dt_s
        if heard:
            self._hear()
        self.arena.tick()

    @precondition(lambda self: self.arena.holder)
    @rule(rounds=st.integers(5, 40))
    def it_drives_on(self, rounds: int) -> None:
        for count in range(rounds):
            self.arena.now += 0.02
            if count % 5 == 0:
                self._hear()
                if held := self.arena.model.hold:
                    self._say(held.message, lease=held.name)
            elif count % 2 == 0 and not self.frozen:
                self.arena.attitude()
            self.arena.tick()

    @rule(time=times, really=rarely)
    def the_clock_says_something_mad(self, time: float, really: bool) -> None:
        if really:
            good, self.arena.now = self.arena.now, time
            self.arena.tick()
            self.arena.now = good

    @rule(by_s=st.sampled_from([-3600.0, -0.001, 0.3, 3600.0]), really=rarely)
    def the_clock_is_set(self, by_s: float, really: bool) -> None:
        if really:
            self.arena.now += by_s

    # devices

    @rule(armed=rarely, late_s=ages_s)
    def motors_speak(self, armed: bool, late_s: float) -> None:
        self.arena.motors(armed=not armed, at=self.arena.now - late_s)

    @rule(really=rarely)
    def motors_die(self, really: bool) -> None:
        if really:
            self.arena.motors_lost()

    @rule(side=st.sampled_from(SIDES), value=metres, late_s=ages_s, twice=st.booleans())
    def a_distance_changes(self, side: str, value: float, late_s: float, twice: bool) -> None:
        self.distances = {**self.distances, side: value}
        self.arena.ranges(self.distances, at=self.arena.now - late_s, twice=twice)

    @rule()
    def ranges_freeze_or_thaw(self) -> None:
        self.frozen = not self.frozen

    @rule(
        changes=st.sampled_from(
            [{}, {}, {"valid": False}, {"value": nan}, {"value": None}, {"heading": None}, {"heading": nan}]
        ),
        late_s=ages_s,
    )
    def the_attitude_speaks(self, changes: dict[str, Any], late_s: float) -> None:
        self.arena.attitude(at=self.arena.now - late_s, **changes)

    @rule(
        changes=st.sampled_from([{}, {}, {"valid": False}, {"value": nan}, {"stalled": True}, {"speed": None}]),
        late_s=ages_s,
    )
    def the_odometry_speaks(self, changes: dict[str, Any], late_s: float) -> None:
        self.arena.odometry(at=self.arena.now - late_s, **changes)

    @rule(kind=st.sampled_from(["attitude", "odometry"]), really=rarely)
    def counting_begins_anew(self, kind: str, really: bool) -> None:
        if really:
            self.arena.body.epochs[kind] += 1

    @rule(by_deg=st.sampled_from([-180.0, -3.0, 4.0, 40.0]), by_m=st.sampled_from([-2.0, 0.1, 1.0]), really=rarely)
    def it_is_carried_away(self, by_deg: float, by_m: float, really: bool) -> None:
        if really:
            self.arena.body.turned_deg += by_deg
            self.arena.body.way_m += by_m

    @rule(gain=st.sampled_from([1.0, 1.0, 0.5, 0.0, -1.0]))
    def the_floor_changes(self, gain: float) -> None:
        self.arena.body.gain = gain

    # people

    @rule(engaged=rarely)
    def the_emergency_stop_changes(self, engaged: bool) -> None:
        if engaged != self.arena.model.estop:
            self.arena.latch(engaged)

    @rule(source=sources, late_s=ages_s, really=rarely)
    def somebody_stops(self, source: str, late_s: float, really: bool) -> None:
        if really:
            self.arena.stop(source, self.arena.now - late_s)

    @rule(
        source=sources,
        power=powers,
        angle=angles,
        bound=bounds,
        range_cm=ranges_cm,
        twist=st.booleans(),
        ttl_s=ttls_s,
        take_over=st.booleans(),
        answerable=st.booleans(),
        check=checks,
        age_s=ages_s,
    )
    def somebody_asks(
        self, angle: float, range_cm: float, bound: dict[str, Any], twist: bool, age_s: float, **more: Any
    ) -> None:
        if twist:
            self._send(Message(angle_deg=angle, twist=True, **more), age_s)
            return
        bounded = {**bound, "range_cm": range_cm if angle in {0.0, 180.0} else 0.0}
        self._send(Message(angle_deg=angle, **bounded, **more), age_s)

    @rule(
        source=sources,
        turn_deg=turns,
        heading_deg=headings,
        to_heading=st.booleans(),
        ttl_s=ttls_s,
        take_over=st.booleans(),
        check=checks,
        age_s=ages_s,
    )
    def somebody_asks_for_a_turn(
        self, turn_deg: float, heading_deg: float, to_heading: bool, age_s: float, **more: Any
    ) -> None:
        message = Message(
            power=0.0,
            turn_deg=None if to_heading else turn_deg,
            heading_deg=heading_deg if to_heading else None,
            **more,
        )
        self._send(message, age_s)

    @rule(
        source=sources,
        power=powers,
        angle=st.sampled_from([0.0, 180.0, 30.0]),
        distance_cm=st.sampled_from([1.0, 10.0, 200.0]),
        range_cm=ranges_cm,
    )
    def somebody_asks_for_a_distance(
        self, source: str, power: float, angle: float, distance_cm: float, range_cm: float
    ) -> None:
        range_cm = range_cm if angle != 30.0 else 0.0
        message = Message(source=source, power=power, angle_deg=angle, distance_cm=distance_cm, range_cm=range_cm)
        self._send(message, 0.0)

    @precondition(lambda self: self.leases)
    @rule(source=sources, which=st.integers(0, 9), same=st.booleans(), power=powers, angle=angles, age_s=ages_s)
    def somebody_quotes_a_lease(
        self, source: str, which: int, same: bool, power: float, angle: float, age_s: float
    ) -> None:
        lease, asked = self.leases[-1 - which % len(self.leases)]
        if same:
            self._say(asked, lease=lease, age_s=age_s)
        else:
            self._send(Message(source=source, power=power, angle_deg=angle, lease=lease), age_s)

    @precondition(lambda self: self.sent)
    @rule(which=st.integers(0, 9))
    def something_is_replayed(self, which: int) -> None:
        self.arena.command(self.sent[-1 - which % len(self.sent)])

    def _hear(self) -> None:
        self.arena.motors()
        if not self.frozen:
            self.distances = {side: value + 0.001 for side, value in self.distances.items()}
        self.arena.ranges(self.distances)
        if not self.frozen:
            self.arena.attitude()
            self.arena.odometry()

    def _say(self, asked: Message, *, lease: str, age_s: float = 0.0) -> None:
        """Say once more what was asked, under its lease."""
        self._send(replace(asked, lease=lease, take_over=False, answerable=True, check=None), age_s)

    def _send(self, message: Message, age_s: float) -> None:
        remote, ahead_s = message.source in REMOTE, AHEAD_S[message.source]
        message = replace(message, sent=self.arena.now - age_s, remote=remote, ahead_s=ahead_s)
        reply = self.arena.command(message)
        self.sent = [*self.sent[-9:], message]
        if reply.lease and not message.lease:
            self.leases = [*self.leases[-9:], (reply.lease, message)]
