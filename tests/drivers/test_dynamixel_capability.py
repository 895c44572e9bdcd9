import os
import signal
import sys
import time
from concurrent.futures import Future
from contextlib import suppress
from functools import partial
from pathlib import Path

import pytest

from lbr.drivers.dynamixel import KIND, capability
from lbr.drivers.dynamixel.bus import STATE_ADDRESS, STATE_BYTES, Bus
from lbr.drivers.dynamixel.capability import Dynamixel
from lbr.drivers.dynamixel.model import Ax12
from lbr.drivers.dynamixel.table import position_rad
from lbr.drivers.servos.bus_thread import BusThread
from lbr.drivers.servos.line import ServoLine
from lbr.drivers.servos.register_release import RegisterRelease
from lbr.errors import DeviceError
from lbr.messages.joints import Joint
from lbr.messages.servos import RecoverServos, ServoGoal, ServoSetpoint
from lbr.testing import FakeCall
from tests.drivers.peers import DriverContext
from tests.drivers.servo_peers import MemoryLine, ServoChain, status
from tests.support import programs
from tests.support.waiting import HANG_S, until

SETTINGS = '{"device": "servos", "guard": false, "reply_margin_s": 0.03, "sweep_hz": 250}'
START = BusThread.start
STEP_S, MOST_S = 0.004, 100.0


class Context(DriverContext):
    """The context of a driver of servos, in the test's own time."""

    def __init__(self, chain, settings=SETTINGS, address="/memory/servos"):
        super().__init__(KIND, KIND.parse(settings), address, "dynamixel")
        self.wired["setpoint"] = ("joints",)
        self.given = tuple(
            Joint(name=f"joint_{servo}", device_id=servo, lower_rad=-2.0, upper_rad=2.0, speed_rps=3.0)
            for servo in chain.servos
        )

    def clock(self):
        return self.now


class Rig:
    """A driver, its chain and the thread of its bus in the test's time, and a mover that sends when told."""

    def __init__(self, patch, chain, settings=SETTINGS):
        self.chain, self.threads, self.sent = chain, [], None
        self.ctx = Context(chain, settings)
        line = partial(MemoryLine, chain, self.ctx)
        patch.setattr(capability, "open_servo_line", lambda _device, baud, margin_s: line(baud, margin_s))
        patch.setattr(BusThread, "start", lambda thread: self.threads.insert(0, thread))
        self.driver = Dynamixel(self.ctx)
        self.driver.open()

    def close(self):
        """Close it as its process does: the bus's thread does what is left."""
        while self.threads:
            START(self.threads.pop())
        self.driver.close()

    def send(self, **fields):
        """Say from now on what every servo is to do; none: fall silent."""
        self.sent = fields

    def step(self):
        if self.sent is not None:
            goals = self.sent.get("goals") or tuple(ServoGoal(id=servo) for servo in self.chain.servos)
            message = ServoSetpoint(goals=goals, **{k: v for k, v in self.sent.items() if k != "goals"})
            self.ctx.give(message, source="joints")
        self.driver.step()
        until_s = self.ctx.now + STEP_S
        for thread in self.threads:
            while self.ctx.now < until_s and (rest_s := thread.turn()) is not None:
                self.ctx.now += max(0.0, min(rest_s, until_s - self.ctx.now))

    def until(self, condition):
        last_s = self.ctx.now + MOST_S
        while not (self.step() or (self.ctx.published and condition())):
            assert self.ctx.now < last_s

    def servo(self, servo):
        return next(state for state in self.ctx.state.servos if state.id == servo)

    def seen(self):
        return bool(self.ctx.published) and all(s.voltage_v is not None for s in self.ctx.state.servos)

    def on(self, **fields):
        self.send(**fields)
        self.until(lambda: all(servo.torque for servo in self.chain.servos.values()) and self.all_on())

    def all_on(self):
        return all(state.torque for state in self.ctx.state.servos)

    def stuck(self, raw):
        """Every servo is on its way here, and stays."""
        for servo in self.chain.servos.values():
            servo.stuck = raw
            servo.settle()
        self.until(lambda: all(state.raw == raw for state in self.ctx.state.servos))

    def go(self, raw, **fields):
        goals = tuple(ServoGoal(id=servo, position_rad=position_rad(raw)) for servo in self.chain.servos)
        self.send(goals=goals, **fields)
        self.until(lambda: all(servo.goal == raw for servo in self.chain.servos.values()))


@pytest.fixture
def start(chain, monkeypatch):
    rigs = []

    def start(settings=SETTINGS):
        rigs.append(Rig(monkeypatch, chain, settings))
        return rigs[-1]

    yield start
    for rig in rigs:
        rig.close()


@pytest.fixture
def rig(start):
    return start()


def test_starting_moves_nothing_and_tells_every_servo(rig, chain):
    rig.until(rig.seen)
    rig.ctx.now += 6.0
    rig.until(rig.seen)
    assert rig.ctx.kinds() == ["servo_set_up"]
    state = rig.ctx.state
    assert (state.phase, state.halt) == ("released", 0)
    assert state.armed
    assert [servo.raw for servo in state.servos] == [513, 514, 515]
    assert rig.servo(1).position_rad == pytest.approx(0.00512, abs=1e-5)
    assert (rig.servo(1).voltage_v, rig.servo(1).temperature_c, rig.servo(1).torque) == (11.1, 35.0, 0.0)
    assert not chain.writes(24)
    assert not chain.writes(30)


def test_a_fault_of_the_buss_thread_ends_the_driver(rig, chain):
    def fault(_request, _usual):
        raise ValueError("a fault")

    rig.until(rig.seen)
    chain.answer = fault
    START(rig.threads.pop())
    with pytest.raises(RuntimeError, match="the servos' bus: ValueError: a fault"):
        until(rig.driver.step)


def test_its_state_tells_whether_anything_came_over_its_line(rig):
    rig.ctx.device.tap.opened()
    rig.until(lambda: rig.ctx.state.heard is False)
    rig.ctx.device.tap.came(b"\xff")
    rig.until(lambda: rig.ctx.state.heard)
    rig.close()
    rig.driver.degraded("away")
    assert rig.ctx.state.heard is None


def test_torque_comes_on_where_the_servo_is(rig, chain):
    chain.servos[1].put(36, 300)
    rig.on()
    assert chain.servos[1].goal == chain.servos[1].position == 300
    order = [request[5] for request in chain.log if request[2] == 1 and request[4] == 3 and request[5] >= 24]
    assert order[:2] == [30, 24]
    assert rig.ctx.state.phase == "following"


@pytest.mark.parametrize(("sources", "said"), [(("joints",), "'joints' is not on the bus"), ((), "wired")])
def test_without_a_sender_on_the_bus_no_setpoint_would_be_followed(rig, sources, said):
    rig.ctx.wired["setpoint"] = ("joints", "others")
    rig.ctx.gone.add("others")
    rig.on()
    assert rig.ctx.state.armed, "one is enough"
    rig.ctx.wired["setpoint"] = sources
    rig.ctx.gone.add("joints")
    rig.until(lambda: not rig.ctx.state.armed)
    assert said in rig.ctx.state.reason


def test_setpoints_of_anybody_else_are_not_followed(rig, chain):
    rig.until(rig.seen)
    for _ in range(50):
        rig.ctx.give(ServoSetpoint(goals=(ServoGoal(id=1),), lease="a"), source="another")
        rig.step()
    assert (rig.ctx.state.phase, chain.servos[1].torque) == ("released", 0)


def test_goals_and_speeds_are_followed_by_all_at_once(rig, chain):
    rig.on()
    chain.log.clear()
    goals = tuple(ServoGoal(id=servo, position_rad=0.5, speed_rps=1.1624) for servo in chain.servos)
    rig.send(goals=goals, lease="a")
    rig.until(lambda: all(servo.goal == 610 and servo.word(32) == 100 for servo in chain.servos.values()))
    assert all(request[2] == 0xFE for request in chain.writes(30))


def test_silence_holds_then_fades_then_lets_go_and_wants_to_be_switched_on_anew(rig, chain):
    rig.on(lease="a")
    rig.go(600, lease="a")
    rig.stuck(570)
    rig.sent = None
    rig.until(lambda: rig.ctx.state.phase == "holding")
    rig.until(lambda: all(servo.goal == 570 for servo in chain.servos.values()))
    assert "no setpoint within 0.1 s" in rig.ctx.state.reason
    rig.ctx.now += 32.0
    rig.until(lambda: rig.ctx.state.phase == "releasing")
    rig.until(lambda: all(0 < servo.torque < 700 for servo in chain.servos.values()))
    rig.ctx.now += 5.0
    rig.until(lambda: not any(servo.torque for servo in chain.servos.values()))
    rig.until(lambda: rig.ctx.state.phase == "released")
    rig.until(lambda: "let_go" in rig.ctx.kinds())
    assert [kind for kind in rig.ctx.kinds() if kind in {"mover_lost", "let_go"}] == ["mover_lost", "let_go"]
    rig.send(lease="b")
    chain.log.clear()
    rig.until(lambda: len(chain.log) > 30)
    assert not any(servo.torque for servo in chain.servos.values())
    assert "switch its torque off" in rig.servo(1).reason
    rig.send(goals=tuple(ServoGoal(id=servo, torque=0.0) for servo in chain.servos))
    rig.until(lambda: not rig.servo(1).reason)
    rig.on(lease="b")


def test_a_stop_is_told_to_every_servo_before_anything_else(rig, chain):
    rig.on(halt=1)
    rig.go(600, halt=1)
    rig.stuck(550)
    chain.log.clear()
    rig.send(halt=2)
    rig.until(lambda: all(servo.goal == 550 for servo in chain.servos.values()))
    assert chain.writes(30)[0][6] == 2, "goal positions alone"


def test_the_emergency_stop_holds_and_is_acknowledged_when_every_servo_was_read_to_hold(rig, chain):
    rig.on()
    rig.go(600)
    rig.stuck(580)
    rig.ctx.estop.engaged, rig.ctx.estop.reason = True, "test"
    rig.until(lambda: rig.ctx.estop.acknowledged[-1:] == [(True, "")])
    assert all(servo.goal == 580 for servo in chain.servos.values())
    assert all(servo.torque for servo in chain.servos.values())
    rig.ctx.estop.engaged = False
    chain.log.clear()
    rig.sent = None
    rig.until(lambda: rig.ctx.estop.acknowledged[-1] == (False, "released"))
    rig.until(lambda: len(chain.log) > 20)
    assert all(servo.goal == 580 for servo in chain.servos.values())
    assert rig.ctx.estop.acknowledged.count((False, "released")) == 1


def test_the_emergency_stop_may_let_go_at_once(chain, start):
    rig = start(SETTINGS.replace("{", '{"on_estop": "release", ', 1))
    rig.on()
    rig.ctx.estop.engaged = True
    rig.until(lambda: not any(servo.torque for servo in chain.servos.values()))
    rig.until(lambda: rig.ctx.estop.acknowledged[-1] == (True, ""))


def test_a_servo_that_does_not_answer_keeps_the_stop_unacknowledged(rig, chain):
    rig.on()
    chain.dead.add(2)
    rig.ctx.estop.engaged = True
    rig.until(lambda: "joint_2 (servo 2)" in rig.ctx.estop.acknowledged[-1][1])
    assert rig.ctx.estop.acknowledged[-1][0] is False


def test_servos_that_have_not_confirmed_an_emergency_stop_are_read_next(monkeypatch):
    rig = Rig(monkeypatch, ServoChain(18))
    rig.on()
    stopped_s, rig.ctx.estop.engaged = rig.ctx.now, True
    rig.until(lambda: rig.ctx.estop.acknowledged[-1:] == [(True, "")])
    assert rig.ctx.now - stopped_s < 4.5 * STEP_S
    rig.close()


def test_a_stop_is_not_acknowledged_while_servos_are_still_looked_for(chain, start):
    chain.dead.add(2)
    rig = start()
    rig.ctx.estop.engaged = True
    rig.step()
    assert rig.ctx.estop.acknowledged == [(False, "the servos are still being looked for")]


def test_an_overload_is_latched_until_it_is_recovered_and_recovering_moves_nothing(rig, chain):
    rig.on()
    chain.servos[2].trip(0x20)
    rig.until(lambda: rig.servo(2).latched == ("overload",))
    rig.until(lambda: chain.servos[2].table[24] == 0)
    assert chain.servos[2].word(34) == 0
    assert chain.servos[1].torque
    chain.servos[2].error = 0
    call = FakeCall("recover", RecoverServos())
    rig.driver.command(call)
    rig.until(lambda: call.answer is not None)
    assert call.answer.accepted
    assert chain.servos[2].word(34) == 1023
    chain.log.clear()
    rig.until(lambda: len(chain.log) > 20 and rig.servo(2).latched == ())
    assert chain.servos[2].torque == 0, "not before somebody had it off"
    rig.send(goals=(ServoGoal(id=1), ServoGoal(id=3)))
    rig.until(lambda: not rig.servo(2).reason)
    rig.on()


@pytest.mark.parametrize("asked", [True, False])
def test_a_recovery_is_answered_when_all_of_its_servos_were_tried(rig, asked):
    rig.on()
    session, jobs = rig.driver._session, [Future(), Future()]
    waiting = iter(jobs)
    for servo in (1, 2):
        session.targets.servos[servo].latched = ("overload",)
    call = FakeCall("recover", RecoverServos())
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(session.thread, "submit", lambda _job, _priority: next(waiting))
        rig.driver.command(call)
    jobs[0].set_result("")
    rig.driver.answer(session)
    assert call.answer is None
    jobs[1].set_result("is still too hot") if asked else jobs[1].cancel()
    rig.driver.answer(session)
    assert call.answer.code == "failed"
    assert ("joint_1" in call.answer.reason, "joint_2" in call.answer.reason) == (False, True)


def test_every_sweep_is_published_at_once(rig):
    rig.until(rig.seen)
    rig.ctx.published.clear()

    def five_in_a_row():
        for _ in range(20):
            rig.step()
        sweeps = [state.sweep for state in rig.ctx.said("state")]
        return any(later - first == 4 for first, later in zip(sweeps, sweeps[4:], strict=False))

    rig.until(five_in_a_row)


def test_a_recovery_of_a_servo_that_no_joint_has_or_of_a_line_that_is_away_is_refused(rig):
    rig.until(rig.seen)
    calls = [FakeCall("recover", RecoverServos(ids=ids)) for ids in ((1, 9), ())]
    rig.driver.command(calls[0])
    rig.close()
    rig.driver.command(calls[1])
    assert [call.answer.code for call in calls] == ["unknown_name", "unreachable"]
    assert "servo 9" in calls[0].answer.reason


def test_a_recovery_that_waits_is_refused_once_when_its_line_goes(rig):
    rig.on()
    rig.driver._session.targets.servos[1].latched = ("overload",)
    call = FakeCall("recover", RecoverServos())
    rig.driver.command(call)
    rig.driver.degraded("unplugged")
    rig.driver.degraded("unplugged")
    assert (call.answer.code, call.answer.reason) == ("unreachable", "unplugged")


def test_a_servo_that_is_still_hot_is_not_recovered(rig, chain):
    rig.on()
    chain.servos[2].table[43] = 71
    chain.servos[2].trip(0x04)
    rig.until(lambda: rig.servo(2).latched == ("overheat",))
    call = FakeCall("recover", RecoverServos(ids=(2,)))
    rig.driver.command(call)
    rig.until(lambda: call.answer is not None)
    assert "joint_2 (servo 2) is still too hot: 71 degrees C" in call.answer.reason
    assert rig.servo(2).latched


def test_a_servo_without_power_is_named_and_never_comes_back_with_torque_by_itself(rig, chain):
    rig.on()
    chain.dead.add(2)
    rig.until(lambda: rig.servo(2).reason == "does not answer" and rig.servo(2).raw is None)
    assert rig.servo(1).raw is not None
    assert any("joint_2 (servo 2)" in phase for phase in rig.ctx.health)
    chain.servos[2].boot()
    chain.dead.clear()
    rig.until(lambda: "lost its torque" in rig.servo(2).reason)
    assert chain.servos[2].torque == 0
    rig.until(lambda: rig.ctx.health[-1] == "ready")
    assert [phase == "ready" for phase in rig.ctx.health] == [True, False, True]


@pytest.mark.parametrize("end", [{"halt": 2}, {"halt": 1, "lost": True}, "estop"])
def test_a_servo_that_hears_again_after_a_motion_has_ended_does_not_catch_up_with_it(rig, chain, end):
    rig.on(halt=1)
    rig.go(600, halt=1)
    chain.dead.add(2)
    rig.send(goals=tuple(ServoGoal(id=servo, position_rad=position_rad(700)) for servo in chain.servos), halt=1)
    rig.until(lambda: chain.servos[1].goal == 700 and rig.servo(2).raw is None)
    if end == "estop":
        rig.ctx.estop.engaged = True
    else:
        rig.send(**end)
    rig.until(lambda: rig.servo(2).goal_rad is None)
    ended = rig.ctx.state.sweep
    rig.until(lambda: rig.ctx.state.sweep > ended + 1)  # all that was written before has been read by the chain
    chain.dead.clear()
    rig.until(lambda: rig.servo(2).raw == 600 and rig.servo(2).goal_rad is not None)
    rig.until(lambda: len(chain.log) > 20)
    assert chain.servos[2].goal == 600
    if end == "estop":
        rig.until(lambda: rig.ctx.estop.acknowledged[-1] == (True, ""))


def test_a_stop_takes_no_servo_back_to_where_it_was_when_it_was_measured_last(rig, chain):
    rig.on(halt=1)
    rig.go(600, halt=1)
    chain.answer = lambda request, _usual: b"" if request[2] == 2 else None
    rig.go(700, halt=1)
    rig.until(lambda: rig.servo(2).age_s > 0.06)
    rig.send(halt=2)
    rig.until(lambda: rig.ctx.state.halt == 2)
    chain.log.clear()
    rig.until(lambda: len(chain.log) > 20)
    assert chain.servos[2].goal == 700


def test_torque_that_was_found_is_held_where_the_servo_is(chain, start):
    chain.servos[1].write(24, b"\1")
    chain.servos[1].stuck = 400
    chain.servos[1].settle()
    rig = start()
    rig.until(lambda: chain.servos[1].goal == 400)
    assert rig.ctx.state.phase == "holding"
    rig.ctx.now += 36.0
    rig.until(lambda: chain.servos[1].torque == 0)


def test_a_servo_that_is_found_with_torque_keeps_it_until_its_mover_knows_of_it(chain, start):
    chain.servos[2].write(24, b"\1")
    chain.dead.add(2)
    rig = start()
    rig.send(goals=(ServoGoal(id=1), ServoGoal(id=3)))
    rig.until(lambda: rig.ctx.state.phase == "following")
    chain.dead.clear()
    rig.until(lambda: rig.servo(2).torque)
    assert chain.servos[2].torque
    rig.until(lambda: not chain.servos[2].torque)


def test_nothing_is_said_before_every_servo_was_looked_for(chain, start):
    chain.servos[3].write(24, b"\1")
    chain.dead.add(2)
    rig = start()
    rig.until(lambda: rig.ctx.published)
    first = {servo.id: servo for servo in rig.ctx.published[0][1].servos}
    assert (first[1].torque, first[2].torque, first[3].torque) == (0.0, None, 1.0)
    assert rig.ctx.published[0][1].phase == "holding"


def test_of_many_servos_three_are_named_and_the_others_counted():
    driver = Dynamixel(Context(ServoChain(5)))
    assert driver.named([1, 2, 3], "away:") == "away: joint_1 (servo 1), joint_2 (servo 2), joint_3 (servo 3)"
    assert driver.named([5, 1, 2, 3, 4], "away:").endswith("joint_2 (servo 2) and 2 more")


def test_without_its_device_row_or_rows_of_joints_it_says_what_to_add(chain):
    ctx = Context(chain)
    rows, ctx.given = ctx.given, ()
    with pytest.raises(DeviceError, match="table joint"):
        Dynamixel(ctx).open()
    ctx.given, ctx.device = rows, None
    with pytest.raises(DeviceError, match="no device row 'servos'"):
        Dynamixel(ctx).open()


def test_an_emergency_stop_while_the_line_is_away_is_not_called_done(chain):
    ctx = Context(chain)
    driver = Dynamixel(ctx)
    driver.degraded("unplugged")
    assert ctx.estop.acknowledged == []
    ctx.estop.engaged = True
    driver.degraded("unplugged")
    assert ctx.estop.acknowledged == [(False, "unplugged")]
    assert (ctx.state.reason, ctx.state.armed, ctx.state.estop) == ("unplugged", False, True)
    assert (ctx.state.sweep, ctx.state.servos) == (0, ())


def test_an_empty_bus_is_degraded_and_says_what_to_look_at(chain, start):
    chain.dead.update(chain.servos)
    rig = start()
    rig.ctx.now += 2.0
    with pytest.raises(DeviceError, match="'servos': none of its 3 servos answers; is their power on"):
        rig.until(lambda: False)
    assert not rig.driver.answers()
    assert rig.ctx.health == []
    rig.close()
    rig.driver.degraded("away")
    assert rig.ctx.state.reason == "away"


def test_a_line_that_babbles_or_echoes_is_told_of_and_the_servos_are_read_all_the_same(rig, chain):
    chain.echo = True
    chain.answer = lambda _request, usual: bytes(range(64)) + usual if usual else None
    rig.until(rig.seen)
    assert [servo.raw for servo in rig.ctx.state.servos] == [513, 514, 515]
    rig.ctx.now += 6.0
    rig.until(lambda: "babble" in rig.ctx.kinds())
    for _ in range(10):
        rig.step()
    assert rig.ctx.kinds().count("babble") == 1
    chain.answer = lambda _request, _usual: None
    rig.until(lambda: "echo" in rig.ctx.kinds())
    for _ in range(10):
        rig.step()
    assert rig.ctx.kinds().count("echo") == 1


@pytest.mark.parametrize(("ending", "torque"), [("hold", True), ("release", False)])
def test_closing_holds_or_lets_go_as_the_row_says(chain, start, ending, torque):
    rig = start(SETTINGS.replace("{", f'{{"on_close": "{ending}", ', 1))
    rig.on()
    rig.stuck(530)
    rig.close()
    assert all(bool(servo.torque) is torque for servo in chain.servos.values())
    assert not torque or all(servo.goal == 530 for servo in chain.servos.values())


def test_an_adapter_reads_all_at_once(monkeypatch):
    chain = ServoChain(18, adapter=True)
    rig = Rig(monkeypatch, chain)
    rig.until(lambda: rig.seen() and rig.ctx.state.bus.sync_read)
    assert {servo.id: servo.raw for servo in rig.ctx.state.servos} == {servo: 512 + servo for servo in chain.servos}
    chain.dead.add(9)
    rig.until(lambda: rig.servo(9).reason == "does not answer")
    rig.close()


@pytest.mark.parametrize(
    ("row", "complaint"),
    [
        ('{"device": "servos", "alarms": ["overheat"]}', "must hold `overload`"),
        ('{"device": "servos", "lowest_v": 12, "highest_v": 11}', "is not below"),
    ],
)
def test_a_bad_row_says_what_is_wrong(row, complaint):
    with pytest.raises(Exception, match=complaint):
        KIND.parse(row)


DRIVER = """
import sys, time
from tests.drivers.peers import DriverContext
from lbr.drivers.dynamixel import KIND
from lbr.drivers.dynamixel.capability import Dynamixel
from lbr.messages.joints import Joint
from lbr.messages.servos import ServoGoal, ServoSetpoint
settings = '{"device": "servos", "hold_s": %s, "release_s": 0.3, "reply_margin_s": 0.05, "guard_silence_ms": 1000}' % sys.argv[2]
ctx = DriverContext(KIND, KIND.parse(settings), sys.argv[1], "dynamixel")
ctx.wired["setpoint"] = ("joints",)
ctx.given = tuple(
    Joint(name=f"joint_{n}", device_id=n, lower_rad=-2.0, upper_rad=2.0, speed_rps=3.0) for n in (1, 2, 3)
)
servos = Dynamixel(ctx)
servos.open()
while True:
    goals = tuple(ServoGoal(id=n, position_rad=0.0, speed_rps=1.0) for n in (1, 2, 3))
    ctx.give(ServoSetpoint(goals=goals, lease="a"), source="joints")
    servos.step()
    time.sleep(0.01)
"""


@pytest.fixture
def driving(tty):
    """Starts a driver in a process of its own, whose servos are on their way; it is waited for, also where a test fails."""
    started = []

    def start(hold_s):
        environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[2])}
        process = programs.start([sys.executable, "-c", DRIVER, str(tty.path), str(hold_s)], env=environment)
        started.append(process)
        until(lambda: all(servo.torque and servo.goal == 512 for servo in tty.servos.values()))
        for servo in tty.servos.values():
            servo.stuck = 540
            servo.settle()
        asked = len(tty.log)  # whoever is asked again has been read before
        until(lambda: {request[2] for request in tty.log[asked:]} >= set(tty.servos))
        return process

    yield start
    for process in started:
        process.kill()
        process.wait()


def test_when_the_driver_hangs_its_guard_holds_the_servos_then_lets_them_go(tty, driving):
    process = driving(1.0)  # the guard gives up servos that it cannot read by then
    tty.log.clear()
    process.send_signal(signal.SIGSTOP)
    until(lambda: not any(servo.torque for servo in tty.servos.values()))
    assert process.wait(HANG_S) == -signal.SIGKILL
    assert [servo.goal for servo in tty.servos.values()] == [540, 540, 540]
    held, faded, let_go = (tty.log.index(tty.writes(address)[which]) for address, which in ((30, -1), (34, 0), (24, 0)))
    assert held < faded < let_go
    limits = [int.from_bytes(request[8:10], "little") for request in tty.writes(34)]
    assert limits == sorted(limits, reverse=True)
    assert len(limits) > 2


def test_a_guard_takes_no_answer_for_its_own_that_the_dead_driver_had_asked_for(tty):
    servo, fd = tty.servos[1], os.open(tty.path, os.O_RDWR | os.O_NOCTTY)
    with Bus(ServoLine(fd, "of the servos", 1_000_000, margin_s=0.5)) as bus:
        os.write(tty.master, status(1, bytes(servo.table[STATE_ADDRESS : STATE_ADDRESS + STATE_BYTES])))
        servo.put(36, 600)
        servo.table[24] = 1
        assert RegisterRelease(bus, Ax12(), [1]).hold()
        until(lambda: servo.goal == 600)


def test_a_guard_lets_servos_go_that_were_silent_when_the_driver_died(tty, driving):
    process = driving(3.0)  # a busy machine reads some servos late, and the guard gives up those it cannot read
    silent = {2, 3}
    tty.answer = lambda request, _usual: b"" if request[2] in silent else None
    process.kill()
    until(lambda: tty.servos[1].goal == 540)
    assert tty.servos[2].goal == 512
    silent.remove(2)
    until(lambda: tty.servos[2].goal == 540)
    until(lambda: not any(servo.torque for servo in tty.servos.values()))
    process.wait(HANG_S)


def test_a_guard_lets_servos_go_of_which_none_was_heard_when_the_driver_died(tty, driving):
    process = driving(1.0)
    tty.answer = lambda _request, _usual: b""
    process.kill()
    process.wait(HANG_S)
    tty.log.clear()
    until(lambda: {request[2] for request in tty.log} >= {1, 2, 3})
    tty.answer = lambda _request, _usual: None
    until(lambda: not any(servo.torque for servo in tty.servos.values()))
    assert all(servo.goal == 540 for servo in tty.servos.values())


def test_a_new_driver_takes_the_line_from_the_guard_and_goes_on_holding(tty, driving):
    process = driving(60.0)
    process.kill()
    process.wait()
    until(lambda: all(servo.goal == 540 for servo in tty.servos.values()))
    ctx = Context(tty, address=tty.path)
    ctx.clock = time.monotonic
    driver, opened = Dynamixel(ctx), []

    def opens():
        with suppress(DeviceError):  # the guard may just be looking whether somebody took the line
            driver.open()
            opened.append(driver)
        return opened

    def follows():
        ctx.give(ServoSetpoint(goals=tuple(ServoGoal(id=servo) for servo in tty.servos), lease="b"), source="joints")
        driver.step()
        return ctx.state.phase == "following"

    until(opens)
    until(lambda: driver.step() or (ctx.published and ctx.state.phase == "holding"))
    until(follows)
    assert all(servo.torque for servo in tty.servos.values())
    driver.close()


def test_at_rest_lost_torque_a_push_and_a_latched_fault_are_told_as_ever(rig, chain):
    rig.on()
    rig.until(lambda: rig.ctx.state.rests)
    chain.servos[1].stuck = 600
    chain.servos[1].settle()
    rig.until(lambda: rig.servo(1).raw == 600)
    rig.until(lambda: rig.ctx.state.rests)
    chain.servos[2].table[24] = 0
    rig.until(lambda: "torque_lost" in rig.ctx.kinds())
    rig.until(lambda: rig.ctx.state.rests)
    chain.servos[3].trip(0x20)
    rig.until(lambda: rig.servo(3).latched == ("overload",))


def test_the_first_goal_after_a_rest_is_followed(rig, chain):
    rig.on()
    rig.until(lambda: rig.ctx.state.rests and rig.driver.rate_hz == 10.0)
    rig.go(600)
    rig.until(lambda: rig.servo(1).raw == 600 and rig.ctx.state.phase == "following")
