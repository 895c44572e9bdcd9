"""The kernel against a simple model of who may move it, over long random histories."""

from math import isfinite

from drive_bench import Bench, motors
from hypothesis import settings as budget
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule

from lbr.messages.drive import CheckVerdict

MAX_POWER = 0.8
ACCEL_PER_S = 2.0
TTL_S = 0.3
MAX_RUN_S = 1.0
EARLY_S = 1.5 / 50.0  # rounds of the loop by which a lease ends sooner, so that the wheels stand in time
LATE_S = 1e-9

sources = st.sampled_from(["console", "phone", "page"])
roles = st.sampled_from(["operate"] * 6 + ["admin", "view"])
powers = st.sampled_from([0.0, 0.1, 0.4, 0.8, 1.0])
angles = st.sampled_from([0.0, 30.0, 90.0, 180.0, 200.0, 270.0, -45.0])
one_in_four = st.sampled_from([False, False, False, True])
steps_s = st.sampled_from([0.0, 0.001, 0.02, 0.02, 0.02, 0.05, 0.1, 0.29, 0.31, 0.7])
readings = st.sampled_from([0.1, 0.24, 0.26, 0.3, 0.4, 0.6, 1.0, 3.0, "over_range", "missing", "invalid"])
bounds = st.sampled_from([{}, {}, {}, {"interval_s": 0.1}, {"interval_s": 0.5}, {"range_cm": 40.0}, {"range_cm": 80.0}])


class DriveMachine(RuleBasedStateMachine):
    """The model knows only: which lease was granted, until when, to which command; and what ended it."""

    @initialize()
    def begin(self):
        self.bench = Bench(max_power=MAX_POWER, accel_per_s=ACCEL_PER_S, max_run_s=MAX_RUN_S, blocked_s=3600.0)
        self.live = None
        self.until = self.changed = 0.0
        self.asked = {}
        self.granted = []
        self.estop = False
        self.motors_good_at = self.bench.now
        self.goals = set()
        self.seen_setpoints = 0
        self.before = (0.0, 0.0)
        self.before_at = self.bench.now
        self.distances = {}

    # what happens

    @rule(dt_s=steps_s, heard=st.sampled_from([True, True, True, False]))
    def time_passes(self, dt_s, heard):
        self._pass(dt_s, heard=heard)

    @precondition(lambda self: self.live)
    @rule(rounds=st.integers(5, 30), renewing=st.booleans())
    def it_drives_on(self, rounds, renewing):
        for count in range(rounds):
            if self.live and renewing and count % 5 == 0:
                self.somebody_quotes_a_lease("console", 0, same=True, power=0.0, angle=0.0)
            self._pass(0.02, heard=True)

    @rule(dt_s=steps_s, reason=st.sampled_from(["", "", "tripped"]))
    def motors_speak(self, dt_s, reason):
        self._pass(dt_s, heard=False)
        self.bench.motors = motors(armed=not reason, reason=reason)
        self._hear_motors()

    @rule(really=one_in_four)
    def motors_die(self, really):
        if really:
            self.bench.lose_motors()
            self.motors_good_at = -1.0
            self.live = None

    @rule(forward=readings, back=readings, left=readings)
    def ranges_come(self, forward, back, left):
        if self.live and self._over():
            self.live = None
        self.distances = {"forward": forward, "back": back, "left": left}
        self.bench.see(**self.distances)
        self._notice_goals()

    @rule(engaged=one_in_four)
    def estop_changes(self, engaged):
        if engaged == self.estop:
            return
        self.bench.estop(engaged)
        self.estop = engaged
        self.live = None if engaged else self.live

    @rule(source=sources, really=one_in_four)
    def somebody_stops(self, source, really):
        if really:
            self.bench.stop(source)
            self.live = None
            assert self.bench.replies[-1].accepted

    @rule(
        source=sources,
        role=roles,
        power=powers,
        angle=angles,
        bound=bounds,
        take_over=st.booleans(),
        check=st.sampled_from([True] * 8 + [False, None]),
    )
    def somebody_asks(self, source, role, power, angle, bound, take_over, check):
        verdict = None if check is None else CheckVerdict(accepted=check)
        asked = {"power": power, "angle_deg": angle, **bound}
        reply = self._send(asked, source=source, role=role, take_over=take_over, checks={"mine": verdict})
        if power == 0.0:
            assert reply.accepted
            self.live = None
            return
        if reply.accepted:
            assert role != "view"
            assert check is True
            assert self.live is None or take_over
            assert reply.lease not in self.granted
            self._grant(reply, asked)

    @precondition(lambda self: self.granted)
    @rule(source=sources, which=st.integers(0, 40), same=st.booleans(), power=powers, angle=angles)
    def somebody_quotes_a_lease(self, source, which, same, power, angle):
        lease = self.granted[-1 - which % len(self.granted)]
        asked = self.asked if same else {"power": power, "angle_deg": angle}
        reply = self._send(asked, source=source, role="operate", lease=lease)
        if reply.accepted:
            assert lease == self.live, "a dead lease moved it"
            assert reply.lease == lease
            changed = self.changed if asked == self.asked else self.bench.now
            self._grant(reply, asked, changed=changed)
        elif lease == self.live:
            assert not reply.reason.startswith("lease is dead"), "a live lease was called dead"
        else:
            assert reply.reason.startswith("lease is dead: ")

    # the model

    def _pass(self, dt_s, *, heard):
        self.bench.now += dt_s
        if self.live and self._over():
            self.live = None
        self.bench.event_tick()
        self._notice_goals()
        if heard:
            self._hear_motors()
            self.bench.see(**self.distances)
            self._notice_goals()

    def _hear_motors(self):
        self.bench.ranges_speak = False
        self.bench.sense()
        armed = self.bench.motors.armed
        self.motors_good_at = self.bench.now if armed else -1.0
        self.live = self.live if armed else None

    def _send(self, asked, **more):
        if self.live and self._over():
            self.live = None
        self.bench.now += 0.001
        if self.live and self._over():
            self.live = None
        reply = self.bench.drive(**asked, **more)
        self._notice_goals()
        return reply

    def _notice_goals(self):
        """What the sensors end, the model takes from the results; everything else it knows by itself."""
        ended = {result.goal for result in self.bench.results if result.result in {"fault", "reached"}}
        if self.live and self.goal in ended:
            self.live = None

    def _grant(self, reply, asked, changed=None):
        assert reply.ttl_s == TTL_S
        assert asked["power"] == 0.0 or not self.estop
        assert self.bench.now - self.motors_good_at <= TTL_S + LATE_S
        self.live = reply.lease
        self.granted.append(reply.lease)
        self.until = self.bench.now + reply.ttl_s - EARLY_S
        self.changed = self.bench.now if changed is None else changed
        self.asked = asked
        self.goal = reply.goal
        if reply.goal:
            self.goals.add(reply.goal)

    def _over(self):
        now = self.bench.now
        return (
            now >= self.until
            or now - self.motors_good_at > TTL_S
            or (self.asked["power"] > 0.0 and now - self.changed >= MAX_RUN_S)
            or (self.asked.get("interval_s", 0.0) > 0.0 and now >= self.changed + self.asked["interval_s"])
        )

    # what always holds

    @invariant()
    def only_a_live_lease_moves_it(self):
        for setpoint in self.bench.setpoints[self.seen_setpoints :]:
            if setpoint.left or setpoint.right:
                assert setpoint.lease in self.granted
        if any(self.bench.wheels):
            assert self.live is not None
            assert self.bench.state.hold.lease == self.live
        if self.live is None:
            assert self.bench.wheels == (0.0, 0.0)
        if self.estop:
            assert self.bench.wheels == (0.0, 0.0)

    @invariant()
    def no_output_exceeds_limit_or_what_was_asked(self):
        for setpoint in self.bench.setpoints[self.seen_setpoints :]:
            assert isfinite(setpoint.left)
            assert isfinite(setpoint.right)
            assert abs(setpoint.left) <= MAX_POWER
            assert abs(setpoint.right) <= MAX_POWER
        if any(self.bench.wheels):
            fastest = max(abs(wheel) for wheel in self.bench.wheels)
            assert fastest <= max(self.asked["power"], *map(abs, self.before)) + LATE_S

    @invariant()
    def growth_is_never_faster_than_the_slew(self):
        most = ACCEL_PER_S * (self.bench.now - self.before_at) + LATE_S
        previous = self.before
        for setpoint in self.bench.setpoints[self.seen_setpoints :]:
            now = (setpoint.left, setpoint.right)
            for was, wheel in zip(previous, now, strict=True):
                assert abs(wheel) <= abs(was) + most
                assert was * wheel >= 0.0, "the sense changed without a zero"
            previous = now
        if len(self.bench.setpoints) > self.seen_setpoints:
            self.before_at = self.bench.now
        self.seen_setpoints = len(self.bench.setpoints)
        self.before = self.bench.wheels

    @invariant()
    def every_goal_has_one_result_or_still_runs(self):
        told = [result.goal for result in self.bench.results]
        assert len(told) == len(set(told))
        hold = self.bench.state.hold
        running = {hold.goal.goal} if hold and hold.goal else set()
        assert self.goals - running == set(told) - running
        assert not running & set(told)

    @invariant()
    def a_blocked_direction_is_never_driven(self):
        left, right = self.bench.wheels
        if left + right > 0.2 and self.distances:
            assert self.distances["forward"] not in {0.1, 0.24, "missing", "invalid"} or self._stale_tick()

    def _stale_tick(self):
        """Readings act with the next setpoint; until then the last one stands."""
        return self.bench.state.ticked < self.bench.state.views["forward"].seen + LATE_S


TestDrive = DriveMachine.TestCase
TestDrive.settings = budget(max_examples=100, stateful_step_count=60, deadline=None)
