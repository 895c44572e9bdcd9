import threading
from pathlib import Path

import msgspec
import pytest

from lbr.apps.vision.direction import Angles
from lbr.apps.vision.eye import Eye, Look
from lbr.apps.vision.sketch import Sketch
from lbr.apps.vision.tracking import capability as module
from lbr.apps.vision.tracking.kind import KIND
from lbr.errors import InputError
from lbr.messages.camera import CameraState, JpegFrame
from lbr.messages.joints import Joint, JointsState, JointState
from lbr.messages.leases import CommandReply, StopCommand
from lbr.messages.tracking import LookCommand, Seen, TrackCommand
from lbr.testing import FakeCall, FakeContext
from tests.apps.vision.tracking_bench import Head, away_rad, project
from tests.support.replies import dead
from tests.support.waiting import until

JOINTS = (
    Joint(name="neck_yaw", device_id=23, lower_rad=-2.3, upper_rad=2.3, speed_rps=4.0),
    Joint(name="head_pitch", device_id=24, lower_rad=-0.8, upper_rad=0.9, speed_rps=3.0),
)


def picture(seen):
    """Return a whole picture, as far as that is known without decoding it, that says what it shows."""
    return b"\xff\xd8" + msgspec.json.encode(seen) + b"\xff\xd9"


class PromptEye:
    """Sees at once what a picture says that it shows."""

    def __init__(self, make, wake):
        self.trouble, self.ready, self._looks = "", True, []
        try:
            make()
        except InputError as err:
            self.trouble, self.ready = str(err), False

    def look(self, picture, taken_s):
        self._looks.append(Look(taken_s, msgspec.json.decode(picture[2:-2], type=Seen | None)))

    def looks(self):
        found, self._looks = self._looks, []
        return found

    def close(self):
        pass


class World(FakeContext):
    """The context of tracking: joints, a camera in the head and a ball; one tick is 5 ms."""

    def __init__(self, **settings):
        self.head = Head(delay_s=0.02)
        super().__init__(KIND, KIND.settings(**settings), robot="uxa90", name="tracking", given=JOINTS)
        self.ball = None
        self.trusted = True
        self.camera_on, self.camera_old_s = True, 0.0
        self.holder, self.lease, self.dead, self.goal, self.expires = None, "", "", "", 0.0
        self.leases = 0
        self.stopped_s, self.reason = None, ""
        self.target = None
        self.torque = {}
        self.silent = False
        self.tracking = None
        self.ticks = 0
        self._tell()

    # The other side of the bus

    def clock(self):
        return 100.0 + self.head.now

    def answer(self, request, message):
        if self.silent:
            return {"joints": None}
        return {"joints": self._halt(message) if request == "halt" else self._move(message)}

    def _move(self, command):
        if command.lease and command.lease != self.lease:
            return dead(self.dead, "stopped")
        if not command.lease:
            if self.holder is not None:
                return CommandReply(accepted=False, reason=f"held by {self.holder}")
            assert command.torque
            if self.stopped_s is not None and command.asked_s <= self.stopped_s:
                return CommandReply(accepted=False, reason="stopped since")
            self.leases += 1
            self.holder, self.lease = self.name, f"lease-{self.leases}"
        self.expires = self.clock() + command.ttl_s
        if command.positions:
            assert command.join
            assert command.stay
            assert all(joint.lower_rad <= command.positions[joint.name] <= joint.upper_rad for joint in JOINTS)
            self.torque |= dict.fromkeys(command.positions, command.torque) if command.torque else {}
            self.goal = f"goal-{len(self.asked) + 1}"
            self.target = Angles(command.positions["neck_yaw"], command.positions["head_pitch"])
            self.head.aim(self.target)
        return CommandReply(accepted=True, lease=self.lease, ttl_s=command.ttl_s, goal=self.goal)

    def _halt(self, message):
        self.stop("tracking")
        return CommandReply(accepted=True)

    def stop(self, who):
        self.stopped_s = self.clock()
        self.end(f"stopped by {who}")

    def end(self, why):
        self.dead = self.reason = why
        self.holder, self.lease, self.target = None, "", None
        self.head.aim(self.head.angles)

    # Time

    def run(self, seconds):
        for _ in range(round(seconds / Head.TICK_S)):
            self.head.tick()
            self.ticks += 1
            if self.target is not None and self.clock() > self.expires:
                self.end("its lease lapsed")
            if self.ticks % 10 == 0:
                self._tell()
            if self.ticks % 13 == 0 and self.camera_on:
                self._shoot()
            if self.tracking is not None and self.ticks % 6 == 0:
                self.tracking.step()

    def _tell(self):
        if self.silent:
            return
        states = {
            joint.name: JointState(
                id=joint.device_id,
                position_rad=self.head.angles[axis] if self.trusted else None,
                goal_rad=self.head.goal[axis],
                age_s=0.0,
            )
            for axis, joint in enumerate(JOINTS)
        }
        self._put(
            "joints",
            JointsState(
                sequence=self.ticks,
                measured_s=self.clock(),
                moving=self.holder is not None,
                phase="following",
                joints=states,
                holder=self.holder,
                stopped_s=self.stopped_s,
                reason=self.reason,
            ),
        )
        on = "streaming" if self.camera_on else "off"
        self._put("camera", CameraState(on=self.camera_on, phase=on, device="head_camera"))

    def _shoot(self):
        seen = project(self.head.angles, self.ball) if self.ball is not None else None
        self._put("frame", JpegFrame(picture(seen)), late_s=self.camera_old_s)

    def _put(self, port, message, late_s=0.0):
        self.arrive(port, message, source="camera_head" if port == "camera" else "joints", late_s=late_s)

    @property
    def state(self):
        return self.said("state")[-1]

    @property
    def moves(self):
        return [asked.message for asked in self.asked if asked.request == "move" and asked.message.positions]


@pytest.fixture
def world(monkeypatch):
    monkeypatch.setattr(module, "Eye", PromptEye)
    monkeypatch.setattr(module, "load", lambda: None)
    monkeypatch.setattr(module, "check", lambda settings, target: None)
    monkeypatch.setattr(module, "finder", lambda settings, target: None)
    return World()


def begin(world, **more):
    world.tracking = KIND.load()(world)
    world.tracking.open()
    return track(world, **more)


def track(world, target="colour", asked_s=None):
    call = FakeCall("track", TrackCommand(target=target))
    call.arrived = world.clock() if asked_s is None else asked_s
    world.tracking.command(call)
    return call


def test_the_head_follows_the_ball_and_rests_when_it_is_in_the_middle(world):
    world.ball = Angles(0.4, 0.2)
    call = begin(world)
    world.run(3.0)
    assert call.answer == CommandReply(accepted=True, reason="the head follows a colour")
    assert away_rad(project(world.head.angles, world.ball)) < 0.04
    assert world.torque == {"neck_yaw": 0.6, "head_pitch": 0.6}
    moved = len(world.moves)
    world.run(2.0)
    assert len(world.moves) == moved, "the head rests"
    assert world.holder == "tracking"
    world.ball = Angles(0.0, 0.0)
    world.run(3.0)
    assert away_rad(project(world.head.angles, world.ball)) < 0.04
    assert world.state.following
    assert world.state.pictures_hz == pytest.approx(15.0, abs=2.0)


def test_the_joints_are_asked_no_more_than_fifteen_times_a_second(world):
    world.ball = Angles(0.4, 0.2)
    begin(world)
    world.run(0.2)
    before = len(world.moves)
    for step in range(40):
        world.ball = Angles(0.4 + 0.01 * step, 0.2)
        world.run(0.05)
    assert len(world.moves) - before <= 31
    assert world.head.angles.yaw_rad > 0.6


def test_feedback_that_is_not_trusted_does_not_keep_it_from_following(world):
    world.ball, world.trusted = Angles(0.4, 0.2), False
    begin(world)
    world.run(4.0)
    assert away_rad(project(world.head.angles, world.ball)) < 0.04


@pytest.mark.parametrize("after_s", [0.1, 0.35, 3.0])
def test_a_stop_of_the_joints_ends_it_also_while_the_head_rests_and_it_never_resumes(world, after_s):
    world.ball = Angles(0.4, 0.2)
    begin(world)
    world.run(after_s)
    world.stop("console")
    stands = len(world.asked)
    world.ball = Angles(-0.1, 0.0)
    world.run(3.0)
    assert not world.state.following
    assert world.state.reason == "stopped by console"
    assert all(one.request == "move" and one.message.lease for one in world.asked[stands:]), "all to a dead lease"
    assert world.events[-1][0] == "tracking_ended"
    assert track(world).answer is None
    world.run(1.0)
    assert world.state.following


def test_its_own_stop_has_the_head_hold(world):
    world.ball = Angles(0.4, 0.2)
    begin(world)
    world.run(0.15)
    call = FakeCall("stop", StopCommand(reason="enough"), source="tester")
    world.tracking.command(call)
    assert call.answer.accepted
    assert world.asked[-1].request == "halt"
    assert world.state.reason == "stopped by tester: enough"
    world.tracking.command(FakeCall("stop", StopCommand(), source="tester"))


def test_it_does_not_begin_while_somebody_else_has_the_joints(world):
    world.holder = "web"
    call = begin(world)
    world.run(0.5)
    assert call.answer.reason == "held by web"
    assert not world.state.following


def test_a_lost_ball_has_the_head_stay_then_turn_ahead_slowly_then_it_gives_up(world):
    world.settings = KIND.settings(give_up_s=8.0)
    world.ball = Angles(0.4, 0.2)
    begin(world)
    world.run(3.0)
    looks = world.head.angles
    world.ball = None
    world.run(1.5)
    assert world.head.angles == pytest.approx(looks, abs=0.01)
    assert world.state.reason == "it is not in the picture"
    world.run(1.0)
    assert 0.05 < world.head.angles.yaw_rad < looks.yaw_rad - 0.02
    world.run(3.0)
    assert world.head.angles == pytest.approx((0.0, 0.0), abs=0.03)
    world.run(3.0)
    assert "give_up_s" in world.state.reason
    assert not world.state.following


@pytest.mark.parametrize("how", ["off", "old"])
def test_without_pictures_the_head_stays_and_it_is_degraded_with_a_reason(world, how):
    world.ball = Angles(0.4, 0.2)
    begin(world)
    world.run(3.0)
    looks = world.head.angles
    world.camera_on, world.camera_old_s = how != "off", 2.0
    world.ball = Angles(0.0, 0.0)
    world.run(5.0)
    assert world.head.angles == pytest.approx(looks, abs=0.01)
    expected = "the camera is off: switch camera_head on" if how == "off" else "only old ones"
    assert expected in world.health[-1]
    assert expected in world.state.reason
    world.camera_on, world.camera_old_s = True, 0.0
    world.run(2.0)
    assert away_rad(project(world.head.angles, world.ball)) < 0.04
    assert world.health[-1] == "ready"


def test_joints_that_fall_silent_end_it(world, wording):
    world.ball = Angles(0.4, 0.2)
    begin(world)
    world.run(3.0)
    world.silent = True
    world.run(3.0)
    wording(world.state.reason)


def test_what_looks_at_pictures_is_loaded_before_anybody_can_have_the_head_follow(world, monkeypatch):
    loaded = []
    monkeypatch.setattr(module, "load", lambda: loaded.append(len(world.asked)))
    begin(world)
    assert loaded == [0]


def test_a_process_that_is_held_up_itself_does_not_say_that_the_joints_are_silent(world):
    world.ball = Angles(0.4, 0.2)
    begin(world)
    world.run(1.0)
    tracking, world.tracking = world.tracking, None
    world.run(0.8)  # within the lease: nothing is asked and nothing is read
    world.tracking = tracking
    world.run(2.0)
    assert world.state.following, world.state.reason
    assert away_rad(project(world.head.angles, world.ball)) < 0.04
    world.tracking = None
    world.run(1.2)  # longer than the lease lives
    world.tracking = tracking
    world.run(0.5)
    assert not world.state.following
    assert world.state.reason == "its lease lapsed"


def test_an_eye_that_opens_late_is_answered_for_in_time_and_the_stop_ends_what_has_not_begun(world, monkeypatch):
    monkeypatch.setattr(PromptEye, "ready", property(lambda self: not slow, lambda *_: None), raising=False)
    slow = [True]
    world.ball = Angles(0.4, 0.2)
    call = begin(world)
    world.run(1.6)
    assert (call.answer.accepted, "eye" in call.answer.reason) == (True, True)
    world.tracking.command(FakeCall("stop", StopCommand(), source="tester"))
    slow.clear()
    moved = len(world.moves)
    world.run(1.0)
    assert len(world.moves) == moved
    assert world.events[-1] == ("tracking_ended", "the head follows no colour any more: stopped by tester")


def test_what_cannot_be_followed_is_refused_with_a_reason(world, monkeypatch):
    world.camera_on = False
    world.run(0.1)
    assert begin(world).answer.reason == "the camera is off: switch camera_head on"
    world.camera_on = True
    world.run(0.1)
    world.given = JOINTS[:1]
    assert "no row for joint head_pitch" in track(world).answer.reason
    world.given = JOINTS
    world.unheard("joints")
    assert "have not been reported" in track(world).answer.reason
    world.run(0.1)
    monkeypatch.undo()
    monkeypatch.setattr(module, "Eye", PromptEye)
    call = track(world, "face")
    world.run(0.1)
    assert "face_model" in call.answer.reason
    assert world.asked == []


def test_a_look_saves_the_marked_picture_and_says_what_is_in_it(world, monkeypatch, tmp_path):
    monkeypatch.setattr(module, "sketch", lambda settings, target, data: Sketch(f"sees no {target}", data))
    world.home = str(tmp_path)
    begin(world)
    call = FakeCall("look", LookCommand())
    world.tracking.command(call)
    assert call.answer is None, "a camera that rested has a picture soon"
    until(lambda: world.run(0.02) or call.answer)
    assert call.answer.reason == f"sees no colour; saved as {call.answer.path}"
    assert Path(call.answer.path).read_bytes() == picture(None)


def test_a_look_without_a_picture_says_so_soon(world):
    begin(world)
    world.camera_old_s = 5.0
    call = FakeCall("look", LookCommand())
    world.tracking.command(call)
    world.run(0.8)
    assert "no pictures come" in call.answer.reason


@pytest.mark.parametrize("later", [False, True])
def test_a_stop_while_the_eye_is_not_ready_yet_ends_it_also_if_it_came_before_the_question(world, monkeypatch, later):
    monkeypatch.setattr(PromptEye, "ready", property(lambda self: not slow, lambda *_: None), raising=False)
    slow = [True]
    world.ball = Angles(0.4, 0.2)
    if later:
        world.run(0.1)
        world.stop("console")
        call = begin(world, asked_s=world.clock() - 0.05)
    else:
        call = begin(world)
        world.run(0.1)
        world.stop("console")
    moved = len(world.moves)
    world.run(0.5)
    slow.clear()
    world.run(2.0)
    assert call.answer.reason == ("stopped since" if later else "stopped by console")
    assert all(move.lease for move in world.moves[moved:]), "no new lease is asked for"
    assert world.holder is None
    assert not world.state.following


def test_an_eye_that_fails_refuses_and_lets_the_joints_go(world, monkeypatch):
    def fail(settings, target):
        raise InputError("no model of a YuNet face detector")

    monkeypatch.setattr(module, "finder", fail)
    call = begin(world)
    world.run(0.5)
    assert call.answer.reason == "no model of a YuNet face detector"
    assert world.asked[-1].request == "halt"


def test_one_at_a_time(world):
    begin(world)
    world.run(0.2)
    assert track(world, "face").answer.reason == "the head follows a colour already; stop that first"


def test_the_end_of_the_process_has_the_head_hold(world):
    world.ball = Angles(0.4, 0.2)
    begin(world)
    world.run(0.1)
    world.tracking.close()
    assert world.asked[-1].request == "halt"


def test_a_sender_that_is_killed_in_mid_move_leaves_the_head_to_the_lease(world):
    world.ball = Angles(0.4, 0.2)
    begin(world)
    while world.holder != "tracking" or away_rad(project(world.target, world.head.angles)) < 0.1:
        world.run(Head.TICK_S)
    world.tracking = None
    asked = len(world.asked)
    world.run(1.1)
    assert world.holder is None
    held = world.head.angles
    world.run(2.0)
    assert len(world.asked) == asked
    assert world.head.angles == pytest.approx(held, abs=0.02)


def test_an_eye_looks_at_the_newest_picture_and_keeps_nobody_waiting():
    gate, woken = threading.Event(), threading.Event()

    def find(picture):
        gate.wait(5.0)
        return Seen(x=0.0, y=0.0, radius=len(picture) / 10)

    eye = Eye(lambda: find, woken.set)
    until(lambda: eye.ready)
    eye.look(b"1", 1.0)
    until(lambda: eye._next is None)
    for number in range(2, 6):
        eye.look(b"1" * number, float(number))
    gate.set()
    looks = []
    until(lambda: looks.extend(eye.looks()) or len(looks) == 2)
    assert [look.taken_s for look in looks] == [1.0, 5.0]
    assert woken.is_set()
    eye.close()


@pytest.mark.parametrize("when", ["at once", "at a picture"])
def test_an_eye_that_cannot_see_says_why(when):
    def fail(*_):
        raise InputError("no glasses")

    eye = Eye(fail if when == "at once" else lambda: fail, lambda: None)
    eye.look(b"1", 1.0)
    until(lambda: eye.trouble)
    assert eye.trouble == "no glasses"
