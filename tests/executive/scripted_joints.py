"""Joints operation without joints, as a file of a user's own: says that all of them were measured at 0.25 rad."""

from dataclasses import replace

from lbr.capability import Capability
from lbr.messages.joints import Joint, JointsState, JointState
from lbr.messages.leases import CommandReply
from lbr.operations.joints import KIND as JOINTS


class ScriptedJoints(Capability):
    def step(self) -> None:
        now = self.ctx.clock()
        joints = {one.name: JointState(id=one.device_id, position_rad=0.25, age_s=0.0) for one in self.ctx.rows(Joint)}
        state = JointsState(sequence=1, measured_s=now, moving=False, phase="released", joints=joints)
        self.ctx.publish("state", state)

    def command(self, call) -> None:
        call.reply(CommandReply(accepted=True, lease="a-lease", ttl_s=0.3, goal="a-goal"))


KIND = replace(JOINTS, name="scripted_joints", entry=ScriptedJoints)
