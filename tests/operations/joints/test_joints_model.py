"""Histories that Hypothesis chooses: whatever happens, one holder, within limits and speed, and nothing moves by itself."""

from math import inf, nan

from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule
from msgspec.structs import replace

from lbr.messages.joints import StoredMotion
from lbr.operations.joints.feet import LONGEST_S
from lbr.operations.joints.moving import MARGIN_RAD
from lbr.operations.joints.state import Tick
from tests.operations.joints.joints_bench import BODY, DT, NAMES, Bench, Servos, frame

SOURCES = ("console", "pad", "far")
IDS = {joint.device_id: name for name, joint in BODY.joints.items()}
sources = st.sampled_from(SOURCES)
angles = st.floats(-2.6, 2.6) | st.just(nan) | st.just(inf)
poses = st.dictionaries(st.sampled_from([*NAMES, "tail"]), angles, max_size=3)
good = st.sampled_from([name for name in NAMES if name != "right_grip"]).flatmap(
    lambda name: st.floats(BODY.joints[name].lower_rad, BODY.joints[name].upper_rad).map(lambda angle: {name: angle})
)
anywhere = st.dictionaries(st.sampled_from(NAMES), st.floats(-2.6, 2.6), min_size=1, max_size=1)
durations = st.none() | st.floats(0.05, 2.0) | st.just(nan)


class Motion(RuleBasedStateMachine):
    """What the kernel says is held against what anybody may expect of it."""

    def __init__(self):
        super().__init__()
        self.bench = Bench()
        self.bench.servos = Servos(share=0.3)
        self.told = self.bench.setpoint
        self.told_at = self.bench.now
        self.leases = {}
        self.outside = {}
        self.renewed = -inf
        self.steps = self.stepped = False
        self.bench.servos.stores = True
        self.bench.standing()
        self._look()

    @initialize(open_loop=st.booleans())
    def the_row_says(self, open_loop):
        state = self.bench.state
        self.bench.set(settings=replace(state.settings, open_loop=open_loop))

    def _look(self):
        """Hold the newest setpoint against the one before."""
        bench = self.bench
        after = bench.setpoint
        if after is None or after is self.told:
            return
        elapsed_s = min(bench.now - self.told_at, 0.055)  # what is refused lets time pass too
        before = {} if self.told is None else {goal.id: goal for goal in self.told.goals}
        self.steps = self._steps()
        halted = self.told is None or after.halt != self.told.halt
        for goal in after.goals:
            self._goal(before.get(goal.id), goal, elapsed_s, halted=halted)
        self.told, self.told_at = after, bench.now

    def _goal(self, before, goal, elapsed_s, *, halted):
        name = IDS[goal.id]
        joint = BODY.joints[name]
        if goal.position_rad is None:
            return
        beyond = BODY.beyond_rad(name, BODY.joint_rad(name, goal.position_rad))
        assert beyond <= self.outside.get(name, 0.0) + 1e-9
        if not beyond and name in self.outside and not BODY.beyond_rad(name, self.bench.measured(name)):
            self.outside.pop(name, None)  # it is back; until then its next motion begins where it is
        assert goal.speed_rps <= joint.speed_rps
        began = before is None or before.torque == 0.0 or before.position_rad is None
        if began or halted:
            allowed = inf
        elif self.bench.state.leases.live is None and not (self._just_ended() or self.steps):
            allowed = 0.0
        else:
            allowed = joint.speed_rps * max(elapsed_s, 0.0)
        if not began:
            assert abs(goal.position_rad - before.position_rad) <= allowed + 1e-6, name

    def _steps(self):
        """Say whether it steps to its feet, or did so until now; never for longer than it may."""
        feet = self.bench.state.feet
        steps, self.stepped = feet is not None or self.stepped, feet is not None
        assert feet is None or self.bench.now <= feet.begun + LONGEST_S + 1e-6
        return steps

    def _just_ended(self):
        return self.bench.results and self.bench.results[-1].result == "reached"

    def _pass(self):
        self.bench.now = round(self.bench.now + 0.0005, 6)

    @rule(rounds=st.integers(1, 30), hear=st.booleans() | st.just(True))
    def time_passes(self, rounds, hear):
        for _ in range(rounds):
            self.bench.now = round(self.bench.now + DT, 6)
            if hear:
                self.bench.hear()
                self._look()
            self.bench.give(Tick())
            self._look()

    @rule(gap_s=st.floats(0.05, 1.0))
    def the_loop_is_held_up(self, gap_s):
        self.bench.now = round(self.bench.now + gap_s, 6)
        self.time_passes(1, hear=True)

    def _ask(self, source, command):
        self._pass()
        before, offers = self.bench.state.leases.live, self.bench.state.leases.offers
        taking = {offer.id for offer in offers if offer.take_over}
        reply = self.bench.command(source=source, **command)
        self._look()
        if not reply.accepted:
            return
        if before is not None and self.bench.now < before.expires and command.get("lease") != before.id:
            assert command.get("take_over") or command.get("lease") in taking
        assert not self.bench.state.leases.estop
        self.leases[source] = reply.lease
        hold = self.bench.state.leases.live
        if hold is not None and hold.id == reply.lease:
            self.renewed = self.bench.now

    @rule(
        source=sources,
        positions=poses | anywhere | good,
        duration_s=durations,
        take_over=st.booleans(),
        mirror=st.booleans(),
    )
    def somebody_commands(self, source, positions, duration_s, take_over, mirror):
        more = {"remote": True, "sender_s": self.bench.now + 3.0} if source == "far" else {}
        command = {"positions": positions, "duration_s": duration_s, "take_over": take_over, "mirror": mirror, **more}
        self._ask(source, command)

    @rule(source=sources, positions=anywhere | good, duration_s=st.floats(0.05, 1.0), rounds=st.integers(2, 8))
    def somebody_moves_a_joint_for_a_while(self, source, positions, duration_s, rounds):
        self.somebody_commands(source, positions, duration_s, take_over=True, mirror=False)
        for _ in range(rounds):
            self.somebody_renews(source)
            self.time_passes(10, hear=True)

    @rule(
        source=sources,
        through=st.lists(good, min_size=1, max_size=3),
        append=st.booleans(),
        smooth=st.booleans(),
        stable=st.booleans(),
    )
    def somebody_goes_through_frames(self, source, through, append, smooth, stable):
        frames = tuple(replace(frame(0.2, **positions), stable=stable) for positions in through)
        lease = self.leases.get(source, "") if append or smooth else ""
        how = "smooth" if smooth else "linear"
        self._ask(source, {"frames": frames, "append": append, "lease": lease, "interpolation": how})

    @rule(
        source=sources,
        positions=good | anywhere,
        torque=st.none() | st.floats(0.2, 1.0),
        smooth=st.booleans(),
        holds=st.booleans(),
    )
    def somebody_joins(self, source, positions, torque, smooth, holds):
        how = "smooth" if smooth else "linear"
        lease = self.leases.get(source, "") if holds else ""
        command = {"positions": positions, "join": True, "torque": torque, "interpolation": how, "lease": lease}
        self._ask(source, command)

    @rule(source=sources, pose=good, limp=st.booleans(), holds=st.booleans())
    def somebody_has_the_controller_play(self, source, pose, limp, holds):
        lease = self.leases.get(source, "") if holds else ""
        playing = self.bench.state.move is not None and self.bench.state.move.stored is not None
        motion = StoredMotion(slot=4, duration_s=0.5, pose=pose, limp=limp)
        told, halt = self.bench.servos.stored, self.bench.state.halt
        self._ask(source, {"stored": motion, "lease": lease})
        broken_off = self.bench.state.halt > halt
        assert not playing or broken_off or self.bench.servos.stored == told, "it was told another while it played"

    @precondition(lambda self: self.bench.servos.stored is not None)
    @rule(phase=st.sampled_from(["over", "failed"]))
    def the_controller_says(self, phase):
        self.bench.servos.plays(phase, "test")

    @rule(source=sources)
    def somebody_renews(self, source):
        more = {"remote": True, "sender_s": self.bench.now + 3.0} if source == "far" else {}
        self._ask(source, {"lease": self.leases.get(source, "none"), **more})

    @rule()
    def anybody_stops(self):
        self._pass()
        self.bench.stop()
        self._look()
        assert self.bench.state.move is None

    @rule(source=sources, through=st.lists(good, min_size=1, max_size=3), rounds=st.integers(1, 30))
    def somebody_is_stopped_in_mid_step(self, source, through, rounds):
        self.somebody_goes_through_frames(source, through, append=False, smooth=True, stable=True)
        self.time_passes(rounds, hear=True)
        self.anybody_stops()
        self.time_passes(rounds, hear=True)

    @rule(engaged=st.booleans())
    def the_emergency_stop_changes(self, engaged):
        self._pass()
        self.bench.estop(engaged=engaged)
        self._look()
        assert self.bench.state.move is None

    @rule(servo=st.sampled_from(sorted(IDS)), how=st.sampled_from(["latched", "missing", "doubted", "well"]))
    def a_servo_changes(self, servo, how):
        servos = self.bench.servos
        servos.latched.pop(servo, None)
        servos.missing.discard(servo)
        servos.doubted.discard(servo)
        if how == "latched":
            servos.latched[servo] = ("overload",)
            servos.torque[servo] = 0.0
        elif how == "missing":
            servos.missing.add(servo)
        elif how == "doubted":
            servos.doubted.add(servo)

    @rule(name=st.sampled_from(NAMES), by_rad=st.floats(-0.5, 0.5))
    def somebody_pushes(self, name, by_rad):
        self.bench.push(name, self.bench.measured(name) + by_rad)
        if BODY.beyond_rad(name, self.bench.measured(name)) > MARGIN_RAD:
            self.outside[name] = BODY.beyond_rad(name, self.bench.measured(name))

    @rule(source=sources, names=st.lists(st.sampled_from(NAMES), max_size=2), on=st.booleans(), sure=st.booleans())
    def somebody_switches(self, source, names, on, sure):
        self._pass()
        self.bench.torque(*names, on=on, source=source, confirmed=sure)
        self._look()

    @rule()
    def the_driver_goes(self):
        self.bench.lose_servos()
        self._look()

    @precondition(lambda self: self.bench.setpoint is not None and self.bench.setpoint.lost)
    @rule()
    def the_driver_lets_go(self):
        self.bench.servos.released_at()

    @invariant()
    def a_holder_has_renewed_in_time(self):
        hold = self.bench.state.leases.live
        if hold is not None and self.bench.state.clock == self.bench.now:
            assert self.bench.now - self.renewed < hold.ttl_s

    @invariant()
    def what_is_stopped_does_not_move(self):
        if self.bench.state.leases.estop:
            assert (self.bench.state.move, self.bench.state.feet) == (None, None)

    @invariant()
    def the_controller_plays_for_who_holds(self):
        setpoint, move = self.bench.setpoint, self.bench.state.move
        if setpoint is not None and setpoint.stored is not None and self.bench.state.clock == self.bench.now:
            assert move is not None or not self.bench.state.adopted
            assert all(goal.position_rad is None for goal in setpoint.goals)

    @invariant()
    def each_goal_ends_once(self):
        goals = [result.goal for result in self.bench.results]
        assert len(goals) == len(set(goals))


TestMotion = Motion.TestCase
TestMotion.settings = settings(stateful_step_count=25, suppress_health_check=[HealthCheck.too_slow])
