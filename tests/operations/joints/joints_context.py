"""A robot around one joints capability, for tests: what it hears is set by hand, what it says is kept."""

from typing import Any

from lbr.capability.context import Received
from lbr.messages.joints import JointMove, JointsCommand, RecoverCommand, TorqueCommand
from lbr.messages.leases import StopCommand
from lbr.operations.joints.capability import Joints
from lbr.operations.joints.settings import JointsSettings
from tests.operations.fakes import FakeAsked, FakeCall, FakeEstop
from tests.operations.joints.joints_bench import ROWS, Servos


class FakeContext:
    """What the runtime gives a capability, without a bus; the servos hear each setpoint at once."""

    robot, name, device, devices, joints = "robot", "joints", None, (), ROWS

    def __init__(self, **settings):
        self.settings = JointsSettings(**settings)
        self.estop = FakeEstop()
        self.servos = Servos()
        self.now = 50.0
        self.published: list[tuple[str, Any]] = []
        self.events: list[tuple[str, str]] = []
        self.asked: list[FakeAsked] = []
        self.gone: set[str] = set()
        self._latest: dict[str, Received] = {}

    def clock(self):
        return self.now

    def publish(self, output, message):
        self.published.append((output, message))
        if output == "setpoint":
            self.servos.obey(message)

    def latest(self, port):
        return self._latest.get(port)

    def sources(self, port):
        return (port,)

    def alive(self, capability):
        return capability not in self.gone

    def ask(self, request, message, timeout_s):
        self.asked.append(FakeAsked(message))
        return self.asked[-1]

    def event(self, kind, text, *, level="info", data=None, code="", about=""):
        self.events.append((kind, text))

    def hear(self):
        self._latest["servos"] = Received(self.servos.state(self.now), None, self.now, "servos")

    def said(self, output):
        return [message for name, message in self.published if name == output]


class Robot:
    """A joints capability in its loop: 100 steps a second, with a sweep before each."""

    def __init__(self, **settings):
        self.ctx = FakeContext(**settings)
        self.joints = Joints(self.ctx)
        self.joints.open()
        self.ctx.now += 0.01  # what was not sent after it began, begins nothing

    def run(self, seconds, lease="", *, hear=True):
        for step in range(round(seconds * 100)):
            self.ctx.now = round(self.ctx.now + 0.01, 6)
            if hear:
                self.ctx.hear()
            if lease and step % 10 == 0:
                self.command(lease=lease)
            self.joints.step()
        return self

    def standing(self):
        self.run(0.05)
        assert self.call("torque", TorqueCommand(on=True)).accepted
        return self.run(0.05)

    def ask(self, name, message, **more):
        call = FakeCall(name, message, self.ctx.now, **more)
        self.joints.command(call)
        return call

    def call(self, name, message, **more):
        return self.ask(name, message, **more).answer

    def command(self, positions=None, *, source="console", **more):
        return self.call("command", JointsCommand(positions=positions or {}, **more), source=source)

    def move(self, joint, angle_deg, **more):
        return self.call("move", JointMove(joint=joint, angle_deg=angle_deg, **more))

    def stop(self):
        return self.call("stop", StopCommand(reason="test"), source="phone")

    def recover(self, *joints):
        return self.ask("recover", RecoverCommand(joints=joints))

    @property
    def setpoint(self):
        return self.ctx.said("setpoint")[-1]

    @property
    def state(self):
        return self.ctx.said("state")[-1]
