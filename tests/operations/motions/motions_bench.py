"""Motions with joints operation on the other side of the wire, scripted, and time that is set by hand."""

from itertools import count
from math import nan
from types import SimpleNamespace
from typing import Any

from lbr.capability.context import Received
from lbr.messages.attitude import AttitudeState
from lbr.messages.codes import Code, Reason
from lbr.messages.drive import GoalResult
from lbr.messages.joints import (
    CaptureCommand,
    Joint,
    JointsState,
    JointState,
    KeyFrame,
    Motion,
    PlayCommand,
)
from lbr.messages.leases import CommandReply, StopCommand, refused
from lbr.operations.motions import KIND
from lbr.testing import FakeCall, FakeContext
from tests.support.replies import dead

STEP_S = 0.02
JOINTS = (
    Joint(name="right_elbow", device_id=5, side="right", lower_rad=-2.0, upper_rad=0.1, speed_rps=3.0),
    Joint(name="left_elbow", device_id=6, side="left", sign=-1, lower_rad=-2.0, upper_rad=0.1, speed_rps=3.0),
    Joint(name="neck", device_id=19, lower_rad=-1.0, upper_rad=1.0, speed_rps=3.0),
)


def frame(duration_s: float = 0.5, **positions: float) -> KeyFrame:
    return KeyFrame(positions=positions, duration_s=duration_s)


MOTIONS = (
    Motion(name="ready", frames=(frame(right_elbow=-0.1, left_elbow=-0.1),)),
    Motion(name="wave", frames=(frame(right_elbow=-0.2), frame(right_elbow=-0.4), frame(right_elbow=-0.3))),
    Motion(
        name="walk",
        frames=(frame(neck=0.1), frame(neck=-0.1)),
        lead_in="ready",
        lead_out="ready",
    ),
    Motion(name="get_up_face", frames=(frame(right_elbow=-0.2), frame(right_elbow=-0.4))),
    Motion(name="empty", frames=()),
    Motion(name="stand", frames=(frame(neck=0.0), frame(right_elbow=-0.1)), slot=7, slot_s=2.0),
    Motion(name="sit", frames=(), slot=21, slot_s=1.0, limp=True),
    Motion(name="greet", frames=(frame(neck=0.1), frame(neck=-0.1)), lead_in="stand", lead_out="sit"),
    Motion(name="endless", frames=(), slot=8),
)


HOW: dict[str, Code] = {
    "reached": "done",
    "stopped": "stopped",
    "superseded": "taken_over",
    "lapsed": "lapsed",
    "fault": "latched",
}


class FakeJoints:
    """What joints operation does with key frames, without joints."""

    def __init__(self) -> None:
        self.refusal = ""
        self.silent = False
        self.lease = self.goal = self.holder = ""
        self.why_dead, self.code_dead = "", HOW["stopped"]
        self.ends: list[float] = []
        self.renewed = 0.0
        self.frames: list[KeyFrame] = []
        self.commands: list[Any] = []
        self.halts: list[str] = []
        self.lost = False
        self.results: list[GoalResult] = []
        self.stopped_s: float | None = None
        self.feet_s: float | None = None
        self._numbers = count(1)

    def move(self, message, now):
        self.commands.append(message)
        if message.lease:
            if message.lease != self.lease:
                return dead(self.why_dead, self.code_dead)
        elif self.holder and not message.take_over:
            return refused(Reason("held", f"held by {self.holder}"))
        if None not in (message.asked_s, self.stopped_s) and message.asked_s <= self.stopped_s:
            return refused(Reason("stopped", "a stop came after it"))
        if self.refusal:
            return refused(Reason("no_torque", self.refusal))
        anew = (message.frames and not message.append) or message.stored
        if not message.lease or anew:
            number = next(self._numbers)
            self.lease, self.goal = message.lease or f"lease-{number}", f"joints-{number}"
            self.holder, self.ends, self.frames = "motions", [], []
        self.renewed = now
        if message.stored:
            self.ends.append(now + message.stored.duration_s)
        for one in message.frames:
            self.ends.append(max(now, self.ends[-1] if self.ends else now) + one.duration_s)
            self.frames.append(one)
        return CommandReply(accepted=True, lease=self.lease, ttl_s=0.3, goal=self.goal)

    def halt(self, message):
        self.at_once = message.at_once
        self.halts.append(message.reason)
        self.lost = message.lost
        if self.holder:
            self.end("stopped", f"stopped by motions: {message.reason}")
        return CommandReply(accepted=True, reason="stopped")

    def end(self, how, why):
        self.code_dead = HOW[how]
        note = why.partition(", but ")[2]
        self.results.append(GoalResult(goal=self.goal, result=how, reason=why, code=HOW[how], note=note, elapsed_s=1.0))
        self.lease = self.holder = self.goal = ""
        self.why_dead = why

    def run(self, now):
        if self.holder != "motions":
            return
        if now - self.renewed > 0.3:
            self.end("lapsed", "not renewed within 0.3 s")
        elif now >= self.ends[-1]:
            self.end("reached", "")

    def stop(self, now, why):
        self.stopped_s = now
        if self.holder:
            self.end("stopped", why)

    def passed(self, now):
        return sum(end <= now for end in self.ends)


class World(FakeContext):
    """The context of motions, with joints that do as they are told."""

    def __init__(self):
        rows = (*JOINTS, *(row for motion in MOTIONS for row in motion.rows))
        super().__init__(KIND, KIND.settings(), robot="bioloid", name="motions", given=rows)
        self.body = FakeJoints()
        self.pose = {"right_elbow": -0.1, "left_elbow": -0.1, "neck": 0.0}
        self.unmeasured: dict[str, str] = {}
        self.doubted: set[str] = set()
        self.told_of_joints = True
        self.pitch_rad: float | None = None
        self.gone = {"power"}
        self.asked_joints = ("joints",)

    def ask(self, request, message, timeout_s, *, only=None):
        if self.body.silent:
            asked_at = self.now
            return SimpleNamespace(answers=lambda: {"joints": None} if self.now > asked_at + timeout_s else None)
        return super().ask(request, message, timeout_s, only=only)

    def answer(self, request, message):
        reply = self.body.move(message, self.now) if request == "move" else self.body.halt(message)
        return dict.fromkeys(self.asked_joints, reply)

    def targets(self, request):
        return self.asked_joints

    def latest(self, port):
        if port == "attitude":
            how = AttitudeState(valid=True, epoch="e", measured_s=self.now, roll_rad=0.0, pitch_rad=self.pitch_rad)
            return None if self.pitch_rad is None else Received(how, None, self.now, "attitude")
        if not self.told_of_joints:
            return None
        joints = {
            one.name: JointState(id=one.device_id, position_rad=self.pose[one.name], age_s=0.01) for one in JOINTS
        }
        missing = {name: JointState(id=0, reason=why) for name, why in self.unmeasured.items()}
        doubted = {name: JointState(id=19, trusted=False, raw=200) for name in self.doubted}
        state = JointsState(
            sequence=1,
            measured_s=self.now,
            moving=bool(self.body.holder),
            phase="following",
            joints=joints | missing | doubted,
            goal=self.body.goal or None,
            passed=self.body.passed(self.now),
            stopped_s=self.body.stopped_s,
            feet_s=self.body.feet_s,
            reason=self.body.why_dead,
            code=self.body.code_dead,
        )
        return Received(state, None, self.now, "joints")

    def take(self, port):
        if self.body.silent:
            return []
        results, self.body.results = self.body.results, []
        return [Received(result, None, self.now, "joints") for result in results]

    @property
    def state(self):
        return self.said("state")[-1]


class Stage:
    """A running capability, and people who play on it."""

    def __init__(self, world: World) -> None:
        self.world = world
        self.motions = KIND.load()(world)
        self.motions.open()

    def play(self, motion="wave", *, source="console", lease="", remote=False, sender_s=nan, **more):
        command = PlayCommand(motion=motion, lease=lease, **more)
        return self._call("play", command, source, remote=remote, sender_s=sender_s)

    def stop(self, source="phone", reason=""):
        return self._call("stop", StopCommand(reason=reason), source)

    def capture(self, motion="bow", **more):
        return self._call("capture", CaptureCommand(motion=motion, **more), "console")

    def run(self, seconds, renewing=None, *, source="console"):
        """Let time go by; `renewing`, a call that was accepted, is repeated at 10 Hz as its player would."""
        renew_at = self.world.now
        for _ in range(round(seconds / STEP_S)):
            if renewing is not None and self.world.now >= renew_at:
                renew_at += 0.1
                command, lease = renewing.message, renewing.answer.lease
                again = self.play(
                    command.motion,
                    source=source,
                    lease=lease,
                    times=command.times,
                    speed=command.speed,
                    mirror=command.mirror,
                )
                if again.answer is not None and not again.answer.accepted:
                    renewing = None
            self.world.body.run(self.world.now)
            self.motions.step()
            self.world.now += STEP_S

    def begun(self, motion="wave", **more):
        """Play, and return the call once it was answered."""
        call = self.play(motion, **more)
        self.run(2 * STEP_S)
        assert call.answer is not None
        return call

    def _call(self, name, message, source, **more):
        self.world.now += 0.001
        call = FakeCall(name, message, self.world.now, source, **more)
        self.motions.command(call)
        return call
