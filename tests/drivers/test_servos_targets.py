"""What servos are told and how they are read, step by step, with a line that does what the test says."""

from concurrent.futures import Future
from itertools import pairwise
from operator import itemgetter
from pathlib import Path
from types import SimpleNamespace

import pytest

from lbr.drivers.dynamixel.bus import Bus
from lbr.drivers.servos.contract import SETTING_UP, Seen, SlowState, Snapshot
from lbr.drivers.servos.gate import first, receive, tick
from lbr.drivers.servos.poller import SINGLY_FIRST_S, SYNC_READ_FAILURES, WRITING_S, Poller
from lbr.drivers.servos.rest import Rest
from lbr.drivers.servos.targets import FADE_STEP, REPEAT_S, ServoTargets
from lbr.drivers.servos.torque import RELEASED, Target, Torque
from lbr.messages.servos import ServoGoal, ServoSetpoint

VALID_S = 0.1
PLACE = {"error": 0, "position": 512, "speed": 0, "position_rad": 0.0, "load_fraction": 0.0}


class Line:
    """A bus's thread that keeps jobs until the test does them, stops first."""

    def __init__(self):
        self.jobs = []

    def submit(self, job, priority, _key=None):
        future = Future()
        self.jobs.append((priority, job, future))
        return future

    def work(self, bus):
        jobs, self.jobs = sorted(self.jobs, key=itemgetter(0)), []
        for _, job, future in jobs:
            if future.set_running_or_notify_cancel():
                future.set_result(job(bus))


class Servo:
    """A bus of one servo that does as it is told."""

    def __init__(self):
        self.torque, self.limits = False, []
        self.goals, self.placed = [], []

    def torque_on(self, _servo, _speed, _limit):
        self.torque = True
        return 512

    def torque_off(self, _servos):
        self.torque = False

    def write_limits(self, limits):
        self.limits.append(limits[1])

    def write_goals(self, goals):
        self.goals += goals.values()

    def write_positions(self, goals):
        self.placed += goals.values()


MODEL = SimpleNamespace(
    full_torque=1000,
    latched=lambda _servo, _seen: (),
    speed_raw=lambda speed_rps: 100 if speed_rps is None else round(100 * speed_rps),
    torque_raw=lambda share: round(share * 1000),
    most_torque=lambda _servo: 1000,
    position_raw=lambda angle_rad: 512 + round(100 * angle_rad),
    holding_goal=lambda position, _speed, _goal: position,
)


class Bench:
    def __init__(self):
        self.now, self.sweep, self.told = 0.0, 0, []
        self.age_s, self.slow_age_s, self.goal = 0.0, 0.0, 512
        self.line, self.bus, self.rest = Line(), Servo(), Rest(lambda: self.now)
        self.targets = ServoTargets(
            [1], self.line, lambda: self.now, MODEL, lambda kind, text, level: self.told.append(kind), self.rest
        )
        self.gate = first(0.0)

    def hear(self, *goals, after_s=0.0, **fields):
        born = self.now + after_s
        self.gate = receive(self.gate, ServoSetpoint(goals=goals, lease="a", **fields), born, born, VALID_S)

    def step(self, *, strength=1.0, follows=True, works=True):
        self.now += 0.01
        self.sweep += 1
        if follows:
            self.hear(ServoGoal(id=1, position_rad=0.0))
        self.gate = tick(self.gate, self.now, VALID_S)
        motion = SimpleNamespace(**PLACE)
        slow = SlowState(self.now - self.slow_age_s, self.bus.torque, self.goal, 100, 1000, 12.0, 30.0)
        snapshot = Snapshot(self.sweep, self.now, {1: Seen(motion, self.now - self.age_s, slow)})
        self.targets.apply(self.gate, strength, snapshot)
        if works:
            self.line.work(self.bus)
        return snapshot

    def on(self):
        for _ in range(3):
            self.step()
        assert self.targets.servos[1].on
        self.told.clear()


def test_a_servo_that_loses_its_torque_while_that_fades_is_told():
    bench = Bench()
    bench.on()
    bench.step(strength=0.9, works=False)
    bench.bus.torque = False
    for share in (0.8, 0.7, 0.6):
        bench.step(strength=share, follows=False, works=False)
    assert bench.told == ["torque_lost"]


@pytest.mark.parametrize("per_step", [0.0005, 0.002, 0.01])
def test_torque_that_fades_is_written_in_steps_that_are_worth_a_packet_and_not_too_often(per_step):
    bench = Bench()
    bench.on()
    for _ in range(15):
        bench.step(follows=False)
    assert bench.bus.limits == []
    written_at = []
    for step in range(90):
        count = len(bench.bus.limits)
        bench.step(strength=1.0 - per_step * step, follows=False)
        written_at += [bench.now] * (len(bench.bus.limits) - count)
    limits = [1000, *bench.bus.limits]
    assert limits[-1] == pytest.approx(1000 * (1.0 - per_step * 89), abs=60)
    assert all(before - after >= 1000 * FADE_STEP for before, after in pairwise(limits))
    assert all(after - before >= REPEAT_S / 2 - 1e-9 for before, after in pairwise(written_at))


def test_the_least_torque_is_not_none_and_of_a_servo_without_torque_nothing_fades():
    bench = Bench()
    for _ in range(20):
        bench.step(strength=0.5, follows=False)
    assert bench.bus.limits == []
    bench.on()
    bench.bus.limits.clear()
    for _ in range(20):
        bench.step(strength=1e-6, follows=False)
    assert bench.bus.limits == [1]


@pytest.mark.parametrize(("age_s", "places"), [(0.04, [512]), (0.06, [])])
def test_a_servo_is_held_only_where_it_was_measured_just_now(age_s, places):
    bench = Bench()
    bench.on()
    bench.bus.placed.clear()
    bench.age_s = age_s
    bench.hear(ServoGoal(id=1), halt=1)
    bench.step(follows=False)
    assert bench.bus.placed == places


@pytest.mark.parametrize(("age_s", "told"), [(0.24, True), (0.26, False)])
def test_a_servo_that_was_not_heard_for_a_while_is_told_no_goals(age_s, told):
    bench = Bench()
    bench.on()
    bench.bus.goals.clear()
    bench.age_s = age_s
    for _ in range(20):
        bench.step()
    assert bool(bench.bus.goals) is told


def test_a_servo_that_gets_no_torque_is_asked_again_five_times_a_second():
    bench = Bench()
    asked = []
    bench.bus.torque_on = lambda *_: asked.append(bench.now) or "is too hot"
    for _ in range(100):
        bench.step()
    assert len(asked) == 5


def test_a_servo_whose_bus_failed_as_it_was_to_get_torque_is_asked_again():
    bench = Bench()
    while not bench.line.jobs:
        bench.step(works=False)
    for _, _, future in bench.line.jobs:
        future.set_exception(OSError("gone"))
    bench.line.jobs.clear()
    bench.on()


def test_a_servo_that_has_latched_a_fault_says_which_and_stays_without_torque_though_the_fault_passes(monkeypatch):
    bench = Bench()
    bench.on()
    monkeypatch.setattr(MODEL, "latched", lambda _servo, _seen: ("overload",))
    bench.step()
    monkeypatch.undo()
    for _ in range(100):
        bench.step()
    assert (bench.told, bench.bus.torque, bench.targets.servos[1].on) == (["servo_latched"], False, False)
    assert "overload" in bench.targets.servos[1].blocked


@pytest.mark.parametrize(("torque", "limit"), [(0.3, 300), (0.0001, 1)])
def test_a_goal_that_asks_for_less_torque_gets_it_at_once(torque, limit):
    bench = Bench()
    bench.on()
    bench.hear(ServoGoal(id=1, position_rad=0.0, torque=torque), after_s=0.01)
    bench.step(follows=False)
    assert bench.bus.limits == [limit]


def test_a_servo_gets_torque_with_the_speed_and_the_limit_of_its_goal():
    bench, asked = Bench(), []
    bench.bus.torque_on = lambda *given: asked.append(given) or 512
    for _ in range(2):
        bench.hear(ServoGoal(id=1, position_rad=0.0, speed_rps=2.5, torque=0.3), after_s=0.01)
        bench.step(follows=False)
    assert asked == [(1, 250, 300)]


def test_lost_torque_is_told_however_often_new_goals_are_sent():
    bench = Bench()
    bench.on()
    for angle_rad in (0.1, 0.2, 0.3):
        bench.hear(ServoGoal(id=1, position_rad=angle_rad), after_s=0.01)
        bench.step(follows=False)
        bench.bus.torque, bench.slow_age_s = False, 0.011
    assert bench.told == ["torque_lost"]


def test_a_hold_that_a_servo_does_not_confirm_is_told_again_until_it_does():
    bench = Bench()
    bench.on()
    for _ in range(15):
        bench.step(follows=False)
    bench.bus.placed.clear()
    bench.goal = 600
    for _ in range(3):
        bench.step(follows=False)
    assert bench.bus.placed == [512] * 3
    bench.goal = 512
    bench.step(follows=False)
    bench.bus.placed.clear()
    bench.step(follows=False)
    assert bench.bus.placed == []


def test_a_goal_that_changes_is_sent_at_once_and_one_that_does_not_ten_times_a_second_or_twice_at_rest():
    bench = Bench()
    bench.on()
    for _ in range(20):
        bench.step()
    bench.hear(ServoGoal(id=1, position_rad=0.1), after_s=0.01)
    bench.step(follows=False)
    assert bench.bus.goals[-1] == (522, 100)
    bench.step()
    assert bench.bus.goals[-1] == (512, 100)
    bench.bus.goals.clear()
    for times in (4, 8):
        for _ in range(45 if times == 4 else 200):
            bench.step()
        assert bench.bus.goals == [(512, 100)] * times
    assert bench.rest.lasts
    bench.hear(ServoGoal(id=1, position_rad=0.1), after_s=0.01)
    bench.step(follows=False)
    assert not bench.rest.lasts


def test_an_order_about_torque_ends_the_rest():
    bench = Bench()
    bench.on()
    for _ in range(100):
        bench.step()
    assert bench.rest.lasts
    bench.targets.release("over")
    assert not bench.rest.lasts


def test_a_servo_without_torque_has_nothing_to_confirm_when_all_are_to_hold():
    bench = Bench()
    bench.step(follows=False)
    bench.goal = 600
    assert bench.targets.unconfirmed(bench.step(follows=False), released=False) == []


def test_why_a_servo_gets_no_torque_is_told_once_for_each_reason():
    bench = Bench()
    for reason, times in (("is too hot", 1), ("does not answer", 2)):
        bench.bus.torque_on = lambda *_, reason=reason: reason
        for _ in range(100):
            bench.step()
        assert bench.told == ["torque_refused"] * times


def test_torque_that_was_found_is_left_before_any_setpoint_came_and_taken_once_one_leaves_it_out():
    bench = Bench()
    bench.bus.torque = True
    for _ in range(200):
        bench.step(follows=False)
    assert (bench.bus.torque, bench.bus.goals, bench.bus.placed) == (True, [], [])
    bench.hear(after_s=0.01)
    bench.step(follows=False)
    assert not bench.bus.torque


def test_torque_that_was_found_with_an_old_position_is_held_once_there_is_a_new_one():
    bench = Bench()
    bench.bus.torque, bench.age_s = True, 0.06
    for bench.age_s in (0.06,) * 5 + (0.04,) * 5:
        bench.step(follows=False)
        assert bench.bus.placed == ([] if bench.age_s > 0.05 else [512])


def test_no_servo_gets_torque_before_the_guard_listens():
    bench = Bench()
    bench.targets.guarded = False
    for _ in range(5):
        bench.step()
    assert not bench.bus.torque
    bench.targets.guarded = True
    bench.step()
    assert bench.bus.torque


@pytest.mark.parametrize("call", ["torque_on", "write_goals", "write_positions", "write_limits", "torque_off"])
def test_what_a_driver_raises_while_it_tells_a_servo_something_is_not_passed_over(call):
    bench = Bench()
    if call != "torque_on":
        bench.on()
    assert bench.targets.broken is None
    setattr(bench.bus, call, lambda *_: (513).to_bytes(1, "little"))
    with pytest.raises(OverflowError):  # noqa: PT012 - which of the steps says it differs
        for _ in range(12):
            bench.step(strength=0.5)
        bench.targets.hold(bench.step(works=False))
        bench.targets.release("over")
        bench.line.work(bench.bus)
    assert isinstance(bench.targets.broken, OverflowError)


def test_a_lost_line_is_no_fault_of_what_was_told():
    bench = Bench()
    bench.bus.torque_on = lambda *_: Path("/nowhere").read_bytes()
    with pytest.raises(OSError, match="nowhere"):
        bench.step()
    assert bench.targets.broken is None


def test_a_servo_that_is_just_getting_torque_has_not_confirmed_a_stop():
    bench = Bench()
    for _ in range(3):
        snapshot = bench.step(works=False)
    assert bench.targets.turning
    assert bench.targets.unconfirmed(snapshot, released=False) == [1]


def test_a_servo_whose_state_was_not_read_since_it_was_told_something_goes_on_as_it_is_told():
    bench = Bench()
    while not bench.targets.servos[1].on:
        bench.slow_age_s = 10.0 * bool(bench.targets.servos[1].switching)
        bench.step()
    bench.slow_age_s = 10.0
    bench.bus.placed.clear()
    bench.bus.goals.clear()
    for _ in range(20):
        bench.step()
    assert bench.bus.placed == []
    assert bench.bus.goals


def test_a_goal_that_waits_for_the_line_does_not_come_after_a_stop():
    bench = Bench()
    bench.on()
    bench.line.work(bench.bus)
    for _ in range(15):
        snapshot = bench.step(works=False)
    bench.bus.goals.clear()
    bench.targets.hold(snapshot)
    bench.line.work(bench.bus)
    assert (bench.bus.goals, bench.bus.placed[-1:]) == ([], [512])


def test_a_servo_that_is_just_getting_torque_gets_none_after_a_release():
    bench = Bench()
    for _ in range(3):
        bench.step(works=False)
    assert bench.targets.turning
    bench.targets.release("over")
    bench.line.work(bench.bus)
    assert not bench.bus.torque
    assert not bench.targets.turning


def test_a_servo_that_did_not_hear_of_its_release_is_told_again():
    bench = Bench()
    bench.on()
    bench.targets.release("over")
    bench.line.work(bench.bus)
    bench.bus.torque, bench.slow_age_s = True, 0.011
    bench.step(follows=False)
    assert bench.bus.torque, "it was read before that"
    bench.slow_age_s = 0.0
    bench.step(follows=False)
    assert not bench.bus.torque


def test_a_servo_that_gets_torque_where_it_is_need_not_be_held_there():
    bench = Bench()
    for _ in range(5):
        bench.hear(ServoGoal(id=1), after_s=0.01)
        bench.step(follows=False)
    assert bench.bus.torque
    assert bench.bus.placed == []


def test_a_servo_that_is_to_stay_where_it_is_is_held_there_once():
    bench = Bench()
    bench.on()
    bench.bus.placed.clear()
    for _ in range(5):
        bench.hear(ServoGoal(id=1), after_s=0.01)
        bench.step(follows=False)
    assert bench.bus.placed == [512]


class Released(Torque):
    """Servos without registers to read back."""

    def __init__(self):
        super().__init__([1, 2], lambda servo: Target(servo, known=True, on=True, blocked="was released"), lambda: 9.0)
        self.told = []

    def release(self, why):
        self.off(list(self.servos.values()), why)

    def off(self, targets, why):
        self.told.append(([target.id for target in targets], why))


def test_a_servo_that_a_setpoint_leaves_out_is_released_and_may_have_torque_again_later():
    servos = Released()
    gate = receive(first(9.0), ServoSetpoint(goals=(ServoGoal(id=1),), lease="a"), 9.01, 9.01, VALID_S)
    assert servos.turning
    assert servos.advance(gate, 1.0), "a lease begins with a stop"
    assert servos.told == [([2], "")]
    assert [target.blocked for target in servos.servos.values()] == ["was released", ""]
    assert not servos.advance(gate, 0.0)
    assert servos.told[1:] == [([1, 2], RELEASED)]


def test_a_servo_that_was_never_read_is_released_too_as_it_may_have_torque():
    bench = Bench()
    bench.bus.torque = True
    bench.targets.release("over")
    bench.line.work(bench.bus)
    assert not bench.bus.torque


def test_torque_that_was_lost_before_a_hold_is_told_all_the_same():
    bench = Bench()
    bench.on()
    bench.targets.hold(bench.step(follows=False, works=False))
    bench.line.work(bench.bus)
    bench.bus.torque, bench.slow_age_s = False, 0.011
    bench.step(follows=False)
    assert bench.told == ["torque_lost"]


def test_a_release_is_confirmed_once_every_servo_was_read_without_torque():
    bench = Bench()
    bench.on()
    assert bench.targets.unconfirmed(bench.step(), released=True) == [1]
    bench.targets.release("over")
    assert bench.targets.unconfirmed(bench.step(follows=False, works=False), released=True) == [1]
    bench.line.work(bench.bus)
    assert bench.targets.unconfirmed(bench.step(follows=False), released=True) == []


def test_a_release_that_goals_had_waited_before_is_confirmed_as_any_other():
    bench = Bench()
    bench.on()
    for _ in range(15):
        bench.step(works=False)
    bench.targets.release("over")
    bench.line.work(bench.bus)
    assert bench.targets.unconfirmed(bench.step(follows=False), released=True) == []


def test_a_stop_is_confirmed_once_every_servo_was_read_to_hold_where_it_is():
    bench = Bench()
    bench.on()
    bench.targets.hold(bench.step(follows=False))
    assert bench.targets.unconfirmed(bench.step(follows=False, works=False), released=False) == [1]
    bench.line.work(bench.bus)
    assert bench.targets.unconfirmed(bench.step(follows=False), released=False) == []


def test_a_lost_acknowledgement_takes_no_torque_if_the_servo_says_that_it_has_it():
    bus = Bus.__new__(Bus)
    bus.read_motion = lambda _servo: SimpleNamespace(**PLACE)
    bus.write = lambda *_: True
    bus.put = lambda *_: False
    bus.get = lambda *_: 1
    assert bus.torque_on(1, 100, 1000) == 512
    bus.get = lambda *_: 0
    assert isinstance(bus.torque_on(1, 100, 1000), str)


class Deaf:
    """A bus that reads all servos at once, unless the machine is too busy."""

    together_errors, cut_short, written_all = True, False, 0
    motion = SimpleNamespace(**PLACE)

    def __init__(self, *, busy=True, together=True):
        self.busy, self.together, self.asked = busy, together, []
        self.trouble = "" if together else "does not answer"

    def read_together(self, servos):
        self.asked.append("all")
        return None if self.busy else [self.motion] * len(servos)

    def read_motion(self, _servo):
        self.asked.append("one")
        return self.motion

    def read_state(self, _servo, _patience_s):
        return self.motion, SlowState(0.0, False, 512, 100, 1000, 12.0, 30.0)


class Polled:
    """A poller of a bus, on a clock of the test."""

    def __init__(self, bus, servos=(1, 2), *more, **named):
        self.now, self.bus = 0.0, bus
        self.poller = Poller(servos, lambda: self.now, *more, **named)

    @property
    def snapshot(self):
        return self.poller.snapshot

    def sweep(self, times=1, *, each_s=0.01):
        for _ in range(times):
            swept = self.snapshot.sweep
            while self.snapshot.sweep == swept:
                wait_s = self.poller.turn(self.bus)
                self.now += wait_s
            self.now += each_s


@pytest.mark.parametrize("late", [1, 3, 4])
def test_a_servo_is_away_at_the_start_once_four_looks_got_no_answer(late):
    bus, looks = Deaf(together=False), []
    answer = bus.read_state

    def read(servo, patience_s):
        looks.append(servo)
        return None if len(looks) <= late else answer(servo, patience_s)

    bus.read_state = read
    polled = Polled(bus, [1])
    while not polled.snapshot.searched:
        polled.poller.turn(bus)
    assert len(looks) >= min(late + 1, 4)
    assert polled.snapshot.servos[1].reason == ("does not answer" if late == 4 else "")


def test_reading_all_at_once_is_tried_again_after_a_busy_time():
    polled = Polled(bus := Deaf())
    polled.sweep(SYNC_READ_FAILURES + 2)
    bus.asked.clear()
    polled.sweep(2)
    assert set(bus.asked) == {"one"}
    assert not polled.snapshot.together
    bus.busy = False
    polled.now += SINGLY_FIRST_S
    polled.sweep()
    bus.asked.clear()
    polled.sweep()
    assert set(bus.asked) == {"all"}
    assert polled.snapshot.together


def test_lost_answers_with_good_ones_between_do_not_end_reading_all_at_once():
    polled = Polled(bus := Deaf())
    for bus.busy in (False, False, *(True, False) * (SYNC_READ_FAILURES + 1)):
        polled.sweep()
    assert polled.snapshot.together


def test_a_sweep_begins_right_after_goals_were_written_and_the_next_waits_a_little_longer_for_them():
    polled = Polled(bus := Deaf(busy=False), (1, 2), 0.01)

    def rest_after_a_sweep():
        while (rest_s := polled.poller.turn(bus)) == 0.0:
            pass
        return rest_s

    assert rest_after_a_sweep() == pytest.approx(0.01)
    polled.now += 0.004
    bus.written_all += 1
    swept = polled.snapshot.sweep
    assert polled.poller.turn(bus) == pytest.approx(0.006), "too early"
    polled.now += 0.002
    assert rest_after_a_sweep() == pytest.approx(0.011)
    assert polled.snapshot.sweep == swept + 1
    polled.now += 0.011
    assert rest_after_a_sweep() == pytest.approx(0.01)


def test_a_servo_that_reports_another_error_is_looked_at_next():
    polled, read = Polled(bus := Deaf(busy=False), (1, 2, 3)), []
    answer = bus.read_state
    bus.read_state = lambda servo, patience_s: read.append(servo) or answer(servo, patience_s)
    polled.sweep(6)
    read.clear()
    polled.sweep()
    assert len(read) == 1, "one a sweep"
    read.clear()
    bus.motion = SimpleNamespace(**{**PLACE, "error": 0x20})
    polled.sweep(2)
    assert set(read) == {1, 2, 3}


def test_an_adapter_that_leaves_out_the_servos_errors_does_not_hide_them():
    polled, waits_s = Polled(bus := Deaf(busy=False), (1, 2), 0.01, rest_period_s=0.1), []
    bus.together_errors, bad = False, SimpleNamespace(**{**PLACE, "error": 0x20})
    slow = bus.read_state(1, 0.0)[1]
    bus.read_state = lambda servo, _patience_s: (bad, slow) if servo == 1 else (bus.motion, slow)
    while polled.now < 2.0:
        waits_s.append(polled.poller.turn(bus))
        polled.now += waits_s[-1]
        assert polled.snapshot.sweep < 3 or [polled.snapshot.servos[servo].error for servo in (1, 2)] == [0x20, 0]
    assert max(waits_s) > 0.09, "nor do they end the rest"


def test_a_servo_that_falls_silent_and_comes_back_is_told_once_each_and_is_looked_for_ever_more_seldom():
    bus, told, asked, silent = Deaf(together=False), [], [], set()
    polled = Polled(bus, (1, 2), tell=lambda kind, *_: told.append(kind))
    answer = bus.read_state

    def read(servo, *_):
        asked.append((servo, polled.now))
        return None if servo in silent else bus.motion

    bus.read_motion = read
    bus.read_state = lambda servo, patience_s: read(servo) and answer(servo, patience_s)
    polled.sweep(100)
    silent.add(2)
    polled.sweep(2000)
    assert told == ["servo_silent"]
    missed = [round(at, 2) for servo, at in asked if servo == 2 and 1.0 <= at < 1.12]
    assert missed == [1.0, 1.01, 1.02, 1.03], "then it is left out for a while"
    assert polled.snapshot.servos[2].reason == "does not answer"
    times = [at for servo, at in asked if servo == 2 and at > 1.1]
    gaps = [after - before for before, after in pairwise(times)]
    assert 1.9 < max(gaps) < 2.1
    assert len(times) < 25
    silent.clear()
    polled.sweep(300)
    assert told == ["servo_silent", "servo_back"]
    assert not polled.snapshot.servos[2].reason


def test_sweeps_and_answers_are_counted_and_a_sweep_is_timed():
    polled = Polled(bus := Deaf(together=False), (1, 2), 0.01)
    answer = bus.read_motion

    def read(servo):
        polled.now += 0.001
        return answer(servo)

    bus.read_motion = read
    while polled.now < 2.5:
        wait_s = polled.poller.turn(bus)
        polled.now += wait_s
    assert polled.snapshot.sweep_s == pytest.approx(0.001)
    assert polled.snapshot.sweeps_hz == pytest.approx(100.0, abs=0.5)
    assert polled.snapshot.states_hz == pytest.approx(200.0, abs=0.5)


def test_before_the_first_round_nothing_was_read_at_any_rate():
    snapshot = Poller([1, 2], lambda: 5.0).snapshot
    assert (snapshot.sweep, snapshot.sweeps_hz, snapshot.states_hz, snapshot.sweep_s) == (0, 0.0, 0.0, 0.0)


@pytest.mark.parametrize(("wrong", "least_s"), [(SETTING_UP, 0.0), ("is of another kind", 0.09)])
def test_servos_that_are_being_set_up_are_swept_as_fast_as_ever(wrong, least_s):
    asked = []

    def prepare(_bus, servo):
        asked.extend([polled.now] if servo == 2 else [])
        return wrong if servo == 2 else ""

    polled, waits_s = Polled(bus := Deaf(busy=False), (1, 2), 0.01, prepare, rest_period_s=0.1), []
    while polled.now < 2.0:
        waits_s.append(polled.poller.turn(bus))
        polled.now += waits_s[-1]
    assert least_s <= max(waits_s) <= least_s + 0.02
    asked = asked[asked.count(0.0) - 1 :] if wrong == SETTING_UP else []
    assert all(after - before >= WRITING_S - 1e-9 for before, after in pairwise(asked))


@pytest.mark.parametrize("together", [False, True])
def test_an_answer_that_was_not_waited_for_because_of_a_stop_is_not_missed(together):
    polled, told = Polled(bus := Deaf(busy=False, together=together), tell=lambda kind, *_: told.append(kind)), []
    polled.sweep(5)
    bus.cut_short, bus.busy = True, True
    bus.read_motion = bus.read_state = lambda *_: None
    polled.sweep(20)
    assert told == []
    assert {seen.reason for seen in polled.snapshot.servos.values()} == {""}


def test_a_search_that_a_stop_cut_short_is_none():
    bus = Deaf(together=False)
    bus.cut_short = True
    polled = Polled(bus, (1, 2), 0.01, lambda *_: "does not answer")
    polled.sweep(20, each_s=0.0)
    assert not polled.snapshot.searched
    bus.cut_short = False
    polled.sweep(5, each_s=0.0)
    assert {seen.reason for seen in polled.snapshot.servos.values()} == {"does not answer"}


def test_of_servos_on_their_way_one_is_read_in_full_in_each_sweep_and_at_rest_more():
    polled, read = Polled(bus := Deaf(busy=False), range(1, 11), 0.01, rest_period_s=0.1), []
    answer = bus.read_state
    bus.read_state = lambda servo, patience_s: read.append(servo) or answer(servo, patience_s)
    polled.sweep(2, each_s=0.0)
    read.clear()
    polled.sweep(20, each_s=0.0)
    assert sorted(read) == sorted([*range(1, 11)] * 2)
    polled.sweep(50, each_s=0.0)
    read.clear()
    polled.sweep(5, each_s=0.0)
    assert sorted(read) == [*range(1, 11)]


def test_what_never_answers_is_asked_less_and_less_and_told_of_once():
    polled, told, tried_s = Polled(bus := Deaf(), tell=lambda kind, *_: told.append(kind)), [], []
    for _ in range(1200):
        count = bus.asked.count("all")
        polled.sweep(each_s=0.05)
        tried_s += [polled.now] * (bus.asked.count("all") - count)
    gaps_s = [after_s - before_s for before_s, after_s in pairwise(tried_s[SYNC_READ_FAILURES - 1 :])]
    assert gaps_s == [pytest.approx(expected_s, abs=0.051) for expected_s in (0.5, 1.0, 2.0, 4.0, 8.0, 16.0)]
    assert told == ["sync_read"]
    assert bus.asked.count("all") < 0.02 * bus.asked.count("one")
