"""A robot around one joints capability, for tests: what it hears is set by hand, what it says is kept."""

from lbr.messages.joints import JointMove, JointsCommand, RecoverCommand, TorqueCommand
from lbr.messages.leases import StopCommand
from lbr.operations.joints import KIND
from lbr.operations.joints.capability import Joints
from lbr.operations.joints.settings import JointsSettings
from lbr.testing import FakeCall, FakeContext
from tests.operations.joints.joints_bench import ROWS, Servos


class JointsContext(FakeContext):
    """The context of joints; the servos hear each setpoint at once."""

    def __init__(self, **settings):
        super().__init__(KIND, JointsSettings(**settings), name="joints", given=ROWS)
        self.servos = Servos()

    def publish(self, output, message, **more):
        super().publish(output, message, **more)
        if output == "setpoint":
            self.servos.obey(message)

    def hear(self):
        self.arrive("servos", self.servos.state(self.now))


class Robot:
    """A joints capability in its loop: 100 steps a second, with a sweep before each."""

    def __init__(self, **settings):
        self.ctx = JointsContext(**settings)
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
