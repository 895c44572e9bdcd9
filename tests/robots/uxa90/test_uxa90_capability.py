import itertools
import threading
import time

import msgspec
import pytest

from lbr.drivers.servos.bus_thread import READ
from lbr.errors import DeviceError
from lbr.messages.joints import Joint
from lbr.messages.servos import RecoverServos, ServoGoal, ServoSetpoint, ServosState, StoredPlay
from lbr.robots.uxa90.driver import KIND
from lbr.robots.uxa90.driver.capability import Uxa90
from lbr.robots.uxa90.driver.messages import ConfigureCommand, ControllerState, InquireCommand, TakeControlCommand
from lbr.robots.uxa90.driver.packets import position_rad
from lbr.testing import FakeCall
from tests.drivers.peers import DriverContext
from tests.robots.uxa90.uxa90_peers import Board
from tests.support.waiting import HANG_S, until

UNHEARD = "no servo answers"
SETTINGS = {"device": "board", "guard": False, "sweep_hz": 50, "settle_s": 0.05, "reply_s": 0.05}


def joint(servo):
    return Joint(name=f"joint_{servo}", device_id=servo, lower_rad=-2.0, upper_rad=2.0, speed_rps=3.0)


class Rig:
    """A driver in this process, its board, a clock that may jump, and a mover that sends when told."""

    def __init__(self, board, **settings):
        self.board = board
        self.ahead_s = 0.0
        row = msgspec.json.encode(SETTINGS | settings).decode()
        self.ctx = DriverContext(KIND, KIND.parse(row), board.path, "uxa90")
        self.ctx.wired["setpoint"] = ("joints",)
        self.ctx.given = tuple(joint(servo) for servo in board.servos)
        self.ctx.clock = lambda: time.monotonic() + self.ahead_s
        self.driver = Uxa90(self.ctx)
        self.sent = None
        self.driver.open()

    def send(self, **fields):
        """Say from now on what every servo is to do; none: fall silent."""
        self.sent = fields

    def at(self, counts, torque=1.0, **fields):
        """Have servos go to counts, all others be without torque."""
        goals = [ServoGoal(id=servo, position_rad=position_rad(at), torque=torque) for servo, at in counts.items()]
        goals += [ServoGoal(id=servo, torque=0.0) for servo in self.board.servos if servo not in counts]
        self.send(goals=tuple(goals), **fields)

    def idle(self, **fields):
        self.at({}, **fields)

    def step(self):
        if self.sent is not None:
            self.ctx.give(ServoSetpoint(**self.sent), source="joints")
        self.driver.step()
        time.sleep(0.001)

    def hurried(self, condition):
        """As `until`, but time passes faster."""

        def later():
            self.ahead_s += 0.03
            return condition()

        self.until(later)

    def until(self, condition):
        until(lambda: self.step() or (bool(self.ctx.published) and condition()))

    @property
    def state(self):
        return next(message for _, message in reversed(self.ctx.published) if isinstance(message, ServosState))

    @property
    def controller(self):
        return next(message for _, message in reversed(self.ctx.published) if isinstance(message, ControllerState))

    def servo(self, servo):
        return next(state for state in self.state.servos if state.id == servo)

    def known(self):
        self.idle()
        self.until(lambda: all(one.trusted for one in self.state.servos))
        self.board.forget()

    def on(self, **fields):
        """All servos hold where they are."""
        self.known()
        self.at({servo: one.position for servo, one in self.board.servos.items()}, **fields)
        self.until(lambda: all(one.level == 0 for one in self.board.servos.values()))

    def sweeps(self, count=3):
        last = self.state.sweep
        self.until(lambda: self.state.sweep >= last + count)


@pytest.fixture
def rig(board):
    rig = Rig(board)
    yield rig
    rig.driver.close()


def test_starting_takes_pc_control_reads_everything_and_moves_nothing(rig, board):
    rig.until(lambda: all(one.trusted for one in rig.state.servos))
    assert board.mode == "pc"
    assert [one.raw for one in rig.state.servos] == [100, 104, 108]
    assert rig.servo(0).position_rad == pytest.approx(position_rad(100), abs=1e-4)
    assert rig.servo(0).torque is None
    assert not rig.state.tells_torque
    assert (rig.state.phase, rig.state.mode, rig.state.armed, rig.state.stores) == ("holding", "pc", True, True)
    rig.until(lambda: rig.controller.trust)
    assert (rig.controller.firmware, rig.controller.serial) == ("C9 00", "6012000010005")
    assert {one[1] >> 5 for one in board.packets} == {5}, "reads alone"
    rig.idle()
    rig.until(lambda: rig.state.phase == "released")


def test_nothing_is_applied_before_it_is_known_where_the_servos_are(rig, board):
    rig.idle()
    rig.until(lambda: rig.state.mode == "pc")
    assert not rig.state.armed or all(one.trusted for one in rig.state.servos)
    rig.until(lambda: rig.state.armed)
    assert all(one.trusted for one in rig.state.servos)


def test_servos_that_a_mover_never_had_are_left_alone(rig, board):
    rig.known()
    rig.sweeps()
    assert not [one for one in board.packets if one[1] >> 5 != 5]
    rig.ahead_s += 60.0
    rig.sent = None
    rig.sweeps()
    assert not [one for one in board.packets if one[1] >> 5 != 5]


def test_a_move_leaves_as_exactly_its_packet_once(rig, board):
    rig.known()
    rig.at({0: 101}, torque=0.2)
    rig.until(lambda: board.servos[0].position == 101)
    rig.sweeps()
    assert [one.hex() for one in board.packets if one[1] >> 5 < 5] == ["ff806565"]
    assert rig.servo(0).torque == 0.2
    assert rig.servo(1).torque is None


def test_all_that_change_in_one_cycle_leave_in_one_write(rig, board):
    rig.on()
    board.forget()
    rig.at({0: 110, 1: 120, 2: 130}, torque=0.6)
    rig.until(lambda: board.servos[2].position == 130)
    assert board.heard(bytes.fromhex("FF406E2E FF417839 FF4282 40".replace(" ", "")))


def test_only_what_changed_is_written(rig, board):
    rig.on()
    board.forget()
    rig.at({0: 100, 1: 120, 2: 108})
    rig.until(lambda: board.servos[1].position == 120)
    rig.sweeps()
    assert board.moves() == [(1, 0, 120)]


def test_moves_are_answered_and_that_measures_too(board):
    rig = Rig(board, sweep_hz=0)
    rig.idle()
    rig.until(lambda: rig.state.armed)
    assert all(one.raw is None for one in rig.state.servos)
    rig.ahead_s += 0.5  # the line is quiet again after PC control was taken
    for count in itertools.islice(itertools.cycle((120, 121)), 100):
        rig.at({0: count}, torque=0.2)
        rig.until(lambda count=count: board.servos[0].position == count)
        for _ in range(20):
            rig.step()
        if rig.servo(0).trusted:  # what a busy machine reads too late is no measurement
            break
    assert rig.servo(0).raw in {120, 121}
    rig.driver.close()


@pytest.mark.parametrize("trust", ["never", "plausible"])
def test_a_servo_whose_place_nobody_knows_goes_at_the_weakest_level_first(board, trust):
    if trust == "plausible":
        board.answer = lambda packet, usual: b"" if len(packet) == 4 else usual
    rig = Rig(board, trust=trust)
    rig.idle()
    rig.until(lambda: rig.state.mode == "pc")
    rig.hurried(lambda: rig.state.armed)
    rig.at({0: 150}, torque=0.8)
    rig.until(lambda: board.moves(0) == [(0, 4, 150)])
    rig.at({0: 151}, torque=0.8)
    rig.until(lambda: board.moves(0)[-1] == (0, 4, 151))
    rig.ahead_s += 2.1
    rig.until(lambda: board.moves(0)[-1] == (0, 1, 151))
    rig.until(lambda: rig.servo(0).raw == (151 if trust == "never" else None))
    assert rig.servo(0).position_rad is None
    assert rig.servo(0).trusted in {False, None}
    rig.driver.close()


def test_torque_on_without_a_position_holds_where_it_is_or_says_that_it_cannot(rig, board):
    rig.known()
    rig.send(goals=(ServoGoal(id=1),))
    rig.until(lambda: board.moves() == [(1, 0, 104)])
    board.dead.add(2)
    rig.until(lambda: rig.servo(2).reason == "does not answer")
    rig.ahead_s += 1.0
    rig.send(goals=(ServoGoal(id=1), ServoGoal(id=2)))
    rig.sweeps()
    assert not board.moves(2)


def test_torque_off_is_a_passive_packet_for_each_servo_said_more_than_once(rig, board):
    rig.on()
    board.forget()
    rig.at({0: 100, 2: 108})
    rig.until(lambda: board.packets.count(bytes.fromhex("FFC11051")) == 3)
    rig.sweeps(10)
    assert board.packets.count(bytes.fromhex("FFC11051")) == 3
    assert [one.level for one in board.servos.values()] == [0, None, 0]
    assert rig.servo(1).torque == 0.0


def test_silence_holds_then_weakens_then_lets_go_and_wants_to_be_switched_on_anew(rig, board):
    rig.on(lease="a")
    rig.sent = None
    rig.until(lambda: rig.state.phase == "holding")
    rig.ahead_s += 33.0
    rig.until(lambda: rig.state.phase == "releasing")
    rig.until(lambda: all((one.level or 0) > 1 for one in board.servos.values()))
    assert [one.position for one in board.servos.values()] == [100, 104, 108]
    rig.ahead_s += 5.0
    rig.until(lambda: all(one.level is None for one in board.servos.values()))
    rig.until(lambda: "let_go" in rig.ctx.kinds() and rig.state.phase == "released")
    rig.at({0: 100}, lease="b")
    rig.sweeps()
    assert board.servos[0].level is None
    assert "switch its torque off" in rig.servo(0).reason
    rig.idle(lease="b")
    rig.until(lambda: not rig.servo(0).reason and rig.servo(0).trusted)
    rig.at({0: 100}, lease="b")
    rig.until(lambda: board.servos[0].level == 0)


def test_a_dead_lease_moves_nothing(rig, board):
    rig.on(lease="a")
    rig.sent = None
    rig.until(lambda: rig.state.phase == "holding")
    rig.at({0: 140, 1: 140, 2: 140}, lease="a")
    rig.sweeps()
    assert board.servos[0].position == 100
    assert "lease of this motion" in rig.state.reason


def test_a_stop_is_told_to_every_servo_and_one_that_is_elsewhere_holds_there(rig, board):
    rig.on(halt=1)
    board.servos[1].stuck = True
    rig.at({0: 120, 1: 120, 2: 120}, halt=1)
    rig.until(lambda: board.servos[0].position == 120)
    rig.sweeps()
    board.forget()
    rig.at({0: 120, 1: 120, 2: 120}, halt=2)
    rig.until(lambda: len(board.moves()) >= 3)
    assert board.moves()[:3] == [(0, 0, 120), (1, 0, 120), (2, 0, 120)]
    rig.sent = None
    rig.until(lambda: board.moves(1)[-1] == (1, 0, 104))


def test_a_goal_that_nobody_leads_a_servo_to_is_gone_to_at_the_weakest_level_first(rig, board):
    rig.on()
    board.servos[1].stuck = True
    board.forget()
    rig.at({0: 120, 1: 200, 2: 108})
    rig.until(lambda: board.moves(1))
    rig.sweeps()
    assert board.moves(0) == [(0, 0, 120)]
    assert set(board.moves(1)) == {(1, 4, 200)}
    rig.ahead_s += 2.0
    rig.until(lambda: board.moves(1)[-1] == (1, 0, 200))


def test_a_servo_with_a_trusted_place_away_from_its_goal_is_told_again(rig, board):
    rig.on()
    board.servos[1].stuck = True
    rig.at({0: 100, 1: 150, 2: 108})
    rig.until(lambda: board.moves(1)[-1] == (1, 0, 150))
    board.forget()
    rig.ahead_s += 1.1
    rig.until(lambda: board.moves() == [(1, 0, 150)])


@pytest.mark.parametrize(("how", "braked"), [("hold", False), ("break", True), ("release", False)])
def test_the_emergency_stop_does_as_the_row_says_and_is_acknowledged_when_all_were_read_to_rest(board, how, braked):
    rig = Rig(board, on_estop=how)
    rig.on()
    board.forget()
    rig.ctx.estop.engaged, rig.ctx.estop.reason = True, "test"
    rig.until(lambda: rig.ctx.estop.acknowledged[-1:] == [(True, "")])
    assert board.braked is braked
    assert (bytes.fromhex("FFDF207F") in board.packets) is braked
    assert [one.level for one in board.servos.values()] == ([0] * 3 if how == "hold" else [None] * 3)
    rig.until(lambda: rig.state.phase == ("holding" if how == "hold" else "released"))
    board.forget()
    rig.ctx.estop.engaged = False
    rig.until(lambda: rig.ctx.estop.acknowledged[-1] == (False, "released"))
    rig.sweeps()
    assert not board.moves()
    if how != "hold":
        assert "switch its torque off" in rig.servo(0).reason
    rig.driver.close()


def test_what_was_read_to_stand_still_stays_acknowledged_when_its_weight_or_a_hand_moves_it(rig, board):
    rig.on()
    rig.ctx.estop.engaged = True
    rig.until(lambda: rig.ctx.estop.acknowledged[-1:] == [(True, "")])
    board.servos[1].position += 30
    swept = rig.state.sweep
    rig.until(lambda: rig.state.sweep > swept + 4)
    assert rig.ctx.estop.acknowledged[-1] == (True, "")


def test_a_servo_that_does_not_rest_or_answer_keeps_the_stop_unacknowledged(rig, board):
    rig.on()
    board.dead.add(2)
    rig.ctx.estop.engaged = True
    rig.until(lambda: rig.ctx.estop.acknowledged and "joint_2 (servo 2)" in rig.ctx.estop.acknowledged[-1][1])
    assert rig.ctx.estop.acknowledged[-1][0] is False
    rig.until(lambda: board.braked)


def test_without_trust_the_stop_says_that_nothing_confirms_it(board):
    rig = Rig(board, trust="never")
    rig.idle()
    rig.until(lambda: rig.state.mode == "pc")
    rig.ctx.estop.engaged = True
    rig.until(lambda: board.braked)
    rig.until(lambda: "nothing confirms it" in rig.ctx.estop.acknowledged[-1][1])
    assert rig.ctx.estop.acknowledged[-1][0] is False
    rig.driver.close()


def play(count, slot=4, duration_s=1.9, **fields):
    return StoredPlay(slot=slot, count=count, duration_s=duration_s, **fields)


def test_a_stored_motion_is_played_once_and_pc_control_is_taken_again(rig, board):
    rig.known()
    rig.idle(lease="a", stored=play(5))
    rig.until(lambda: board.plays == [4])
    rig.until(lambda: rig.state.stored.phase == "playing")
    assert board.mode == "normal"
    assert rig.servo(0).torque == 1.0
    board.forget()
    rig.until(lambda: rig.state.mode == "normal")
    for _ in range(30):
        rig.step()
    assert not board.said, "neither packet nor question meanwhile"
    rig.ahead_s += 2.0
    rig.until(lambda: rig.state.stored.phase == "over")
    assert board.mode == "pc"
    rig.sweeps()
    assert not board.plays
    assert rig.state.stored.count == 5


def test_after_a_stored_motion_joints_are_held_at_their_own_torque_and_after_a_limp_one_not_at_all(rig, board):
    rig.known()
    rig.at({0: 100, 1: 104, 2: 108}, lease="a", stored=play(5))
    rig.until(lambda: rig.state.stored is not None and rig.state.stored.phase == "playing")
    board.forget()
    rig.ahead_s += 2.0
    rig.until(lambda: len(board.moves()) == 3)
    assert board.moves() == [(0, 0, 100), (1, 0, 104), (2, 0, 108)], "never weak: it stands on them"
    rig.at({0: 100, 1: 104, 2: 108}, lease="b", stored=play(6, slot=21, limp=True))
    rig.until(lambda: rig.state.stored.count == 6 and rig.state.stored.phase == "playing")
    board.forget()
    rig.ahead_s += 2.0
    rig.until(lambda: rig.state.stored.phase == "over")
    rig.sweeps()
    assert not board.moves()
    assert rig.servo(0).torque == 0.0
    assert "main board's motion" in rig.servo(0).reason


def test_a_stored_motion_may_be_played_without_leaving_pc_control(board):
    rig = Rig(board, stored_by="direct")
    rig.known()
    rig.idle(lease="a", stored=play(5))
    rig.until(lambda: board.plays == [4])
    assert board.heard(bytes.fromhex("FFE0E1000405"))
    assert board.mode == "pc"
    board.forget()
    rig.ahead_s += 2.0
    rig.until(lambda: rig.state.stored.phase == "over")
    assert not board.frames
    rig.driver.close()


def test_only_slots_of_the_row_are_played(rig, board):
    rig.known()
    rig.idle(lease="a", stored=play(5, slot=33))
    rig.until(lambda: rig.state.stored is not None and rig.state.stored.phase == "failed")
    assert "motion 33 of the main board may not be started" in rig.state.stored.reason
    assert not board.plays


@pytest.mark.parametrize("end", [{"halt": 1}, {"lost": True}, "silence", "estop"])
def test_a_stop_while_the_main_board_plays_takes_control_and_holds_everything_where_it_is(board, end):
    rig = Rig(board, on_estop="hold")
    rig.known()
    rig.at({0: 100, 1: 104, 2: 108}, lease="a", stored=play(5))
    rig.until(lambda: board.plays == [4])
    board.forget()
    for servo in board.servos.values():
        servo.position += 40
    if end == "estop":
        rig.ctx.estop.engaged = True
    elif end == "silence":
        rig.sent = None
    else:
        rig.at({0: 100, 1: 104, 2: 108}, lease="a", stored=play(5), **end)
        if "halt" in end:
            rig.until(lambda: rig.state.halt == 1)
            rig.sent = None
    rig.until(lambda: rig.state.stored.phase == "failed")
    rig.until(lambda: len(board.moves()) >= 3)
    assert board.frames[0][8] == 0x10
    assert board.moves()[:3] == [(0, 0, 140), (1, 0, 144), (2, 0, 148)]
    assert not board.plays
    rig.driver.close()


@pytest.mark.parametrize("end", ["halt", "close"])
def test_a_stored_motion_that_still_waits_for_the_line_when_a_stop_comes_is_not_begun(rig, board, end):
    rig.known()
    line_is_taken, line_is_free = threading.Event(), threading.Event()
    rig.driver._session.thread.submit(lambda _bus: line_is_taken.set() or line_is_free.wait(HANG_S), READ)
    line_is_taken.wait(HANG_S)
    rig.idle(lease="a", stored=play(5))
    rig.until(lambda: rig.state.stored is not None and rig.state.stored.phase == "playing")
    if end == "halt":
        rig.idle(lease="a", stored=play(5), halt=1)
        rig.until(lambda: rig.state.stored.phase == "failed")
        line_is_free.set()
        rig.sweeps()
    else:
        threading.Timer(0.05, line_is_free.set).start()
        rig.driver.close()
    until(lambda: any(frame[8] == 0x10 for frame in board.frames))
    assert not board.plays


def test_a_count_from_before_the_line_was_opened_is_never_played(rig, board):
    rig.send(goals=(), lease="a", stored=play(7))
    rig.until(lambda: rig.state.armed)
    rig.send(goals=(), lease="b", stored=play(7))
    rig.sweeps()
    assert not board.plays
    rig.idle(lease="b")
    rig.sweeps()
    rig.idle(lease="b", stored=play(7))
    rig.sweeps()
    assert not board.plays
    rig.idle(lease="b", stored=play(8))
    rig.until(lambda: board.plays == [4])


def test_when_the_cable_was_out_while_the_main_board_played_its_motion_is_ended_first_and_not_repeated(rig, board):
    rig.known()
    rig.idle(lease="a", stored=play(5))
    rig.until(lambda: board.plays == [4])
    board.unplug()
    with pytest.raises(DeviceError, match="went away"):
        rig.until(lambda: False)
    rig.driver.close()
    board.plug()
    board.forget()
    rig.driver.open()
    rig.until(lambda: rig.state.armed)
    assert [frame[8] for frame in board.frames[:2]] == [0x10, 0x12]
    rig.sweeps()
    assert (board.plays, rig.state.stored.phase) == ([], "failed")


def ask(rig, name, message):
    call = FakeCall(name, message)
    rig.driver.command(call)
    rig.until(lambda: call.answer is not None)
    return call.answer


def test_commands(rig, board):
    rig.known()
    assert ask(rig, "recover", RecoverServos()).accepted
    assert ask(rig, "take_control", TakeControlCommand()).accepted
    said = ask(rig, "inquire", InquireCommand(what="boundary", id=1))
    assert (said.accepted, said.values, said.text) == (True, (10, 240), "servo 1: boundary 10, 240")
    assert ask(rig, "inquire", InquireCommand(what="serial")).text == "6012000010005"
    assert "say which" in ask(rig, "inquire", InquireCommand(what="boundary")).reason
    assert "no joint has servo 9" in ask(rig, "inquire", InquireCommand(what="boundary", id=9)).reason
    board.dead.add(1)
    assert "does not report its boundary" in ask(rig, "inquire", InquireCommand(what="boundary", id=1)).reason
    said = ask(rig, "configure", ConfigureCommand(what="boundary", id=2, values=(1, 2)))
    assert not said.accepted
    assert '"maintenance": true' in said.reason


def test_maintenance_writes_a_register_and_reads_it_back(board):
    rig = Rig(board, maintenance=True)
    rig.known()
    said = ask(rig, "configure", ConfigureCommand(what="boundary", id=2, values=(20, 200)))
    assert (said.accepted, said.values) == (True, (20, 200))
    assert board.heard(bytes.fromhex("FFE21114C82F"))
    board.forget()
    rig.driver._session.bus.settle = lambda _within_s: False
    assert "did not get it" in ask(rig, "configure", ConfigureCommand(what="boundary", id=2, values=(20, 200))).reason
    assert not any(one[1] >> 5 == 7 for one in board.packets)
    del rig.driver._session.bus.settle
    for what, values, why in (
        ("id", (1,), "there is a servo 1 already"),
        ("overload", (255,), "outside 33..199"),
        ("position14", (1,), "can only be read"),
    ):
        assert why in ask(rig, "configure", ConfigureCommand(what=what, id=2, values=values)).reason
    board.answer = lambda packet, usual: bytes((10, 240)) if packet[2] == 0x12 else usual
    assert (
        "keeps its boundary" in ask(rig, "configure", ConfigureCommand(what="boundary", id=2, values=(21, 201))).reason
    )
    rig.driver.close()


def test_a_line_that_goes_away_in_mid_motion_is_degraded_comes_back_and_nothing_resumes(rig, board):
    rig.on(lease="a")
    board.unplug()
    with pytest.raises(DeviceError, match="went away"):
        rig.until(lambda: False)
    rig.driver.close()
    rig.driver.degraded("away")
    assert (rig.state.reason, rig.state.armed) == ("away", False)
    with pytest.raises(DeviceError, match="missing"):
        rig.driver.open()
    board.plug()
    board.forget()
    rig.driver.open()
    rig.at({0: 150, 1: 150, 2: 150}, lease="a")
    rig.until(lambda: rig.state.armed and all(one.trusted for one in rig.state.servos))
    rig.at({0: 150, 1: 150, 2: 150}, lease="b")
    rig.sweeps()
    assert not board.moves()
    assert "was out of reach" in rig.servo(0).reason
    rig.idle()
    rig.until(lambda: not rig.servo(0).reason)
    rig.at({0: 101}, lease="b")
    rig.until(lambda: board.moves() == [(0, 0, 101)])


def test_a_driver_that_begins_holds_what_another_left_where_it_is_until_a_new_motion(rig, board):
    rig.at({0: 150, 1: 104, 2: 108})
    rig.until(lambda: len(board.moves()) == 3)
    assert board.moves() == [(0, 0, 100), (1, 0, 104), (2, 0, 108)]
    rig.at({0: 102, 1: 104, 2: 108}, lease="new")
    rig.until(lambda: board.moves()[3:] == [(0, 0, 102)])


def test_pc_control_that_was_lost_is_taken_again_and_the_motion_ended(rig, board):
    rig.on(lease="a")
    board.mode = "normal"
    board.forget()
    rig.at({0: 150, 1: 150, 2: 150}, lease="a")
    rig.hurried(lambda: board.mode == "pc")
    board.forget()
    rig.until(lambda: "lease of this motion" in rig.state.reason)
    rig.sweeps()
    assert all(one.position < 110 for one in board.servos.values())


def test_pc_control_that_was_lost_is_noticed_before_every_servo_was_asked_in_vain(tmp_path):
    board = Board(tmp_path / "ttyBoard", count=25)
    rig = Rig(board)
    rig.known()
    board.mode = "normal"
    gone_s = rig.ctx.clock()
    rig.hurried(lambda: board.mode == "pc")
    assert rig.ctx.clock() - gone_s < 4.0
    rig.driver.close()
    board.finish()


def test_a_robot_without_power_is_degraded_and_says_what_to_look_at(rig, board):
    rig.on()
    board.silent = True
    with pytest.raises(DeviceError, match="none of its 3 servos answers any more; is the robot's power on"):
        rig.hurried(lambda: False)


def test_a_robot_that_was_never_heard_is_degraded_and_moves_nothing_by_itself_once_it_has_power(board):
    board.silent = True
    rig = Rig(board)
    rig.at({0: 127, 1: 127, 2: 127})
    with pytest.raises(DeviceError, match="none of its 3 servos answers; is the robot's power on"):
        rig.hurried(lambda: rig.state.armed)
    rig.driver.close()
    board.silent = False
    board.forget()
    rig.driver.open()
    rig.until(lambda: all(one.trusted for one in rig.state.servos))
    rig.sweeps()
    assert board.moves() == []
    rig.idle()
    rig.sweeps()
    rig.at({0: 127})
    rig.until(lambda: board.moves(0))
    rig.driver.close()


def test_servos_that_answer_only_after_they_were_told_are_held_where_they_are(rig, board):
    board.dead = set(board.servos)
    rig.idle()
    rig.hurried(lambda: rig.state.armed and rig.ctx.health[-1].startswith(UNHEARD))
    rig.at({0: 127, 1: 127, 2: 127}, lease="a")
    rig.hurried(lambda: all(one.torque for one in rig.state.servos))
    rig.ahead_s += 3.0
    rig.sweeps()
    board.forget()
    board.dead.clear()
    rig.hurried(lambda: all(one.trusted for one in rig.state.servos))
    rig.sweeps()
    assert sorted((servo, at) for servo, _, at in board.moves()) == [(0, 100), (1, 104), (2, 108)]
    assert "lease of this motion" in rig.state.reason


def test_servos_that_fall_silent_one_after_another_are_told_of_together(rig, board):
    rig.on()
    rig.until(lambda: rig.ctx.health[-1] == "ready")
    for servo in (0, 1):
        board.dead.add(servo)
        rig.until(lambda servo=servo: rig.servo(servo).reason)
    rig.until(lambda: rig.ctx.health[-1].startswith("not measured: joint_0 (servo 0), joint_1 (servo 1)"))
    assert len([one for one in rig.ctx.health if one != "ready"]) <= 2
    assert "servo_silent" not in rig.ctx.kinds()


@pytest.mark.parametrize(("ending", "level"), [("hold", 0), ("release", None)])
def test_closing_holds_or_lets_go_as_the_row_says(board, ending, level):
    rig = Rig(board, on_close=ending)
    rig.on()
    rig.driver.close()
    until(lambda: all(one.level is level for one in board.servos.values()))
