"""A servo bus without servos, as a file of a user's own: each is at once where it is told to be, as its gate lets it."""

from dataclasses import replace

from msgspec import Struct

from lbr.capability import Capability, Rows
from lbr.drivers.dynamixel import KIND as DYNAMIXEL
from lbr.drivers.servos import gate
from lbr.messages.joints import Joint
from lbr.messages.servos import ServosState, ServoState

VALID_S = 0.5
"""Longer than a busy machine holds up the joints, which would leave the servos to themselves."""


class NoSettings(Struct, frozen=True, forbid_unknown_fields=True):
    """Whatever the row sets."""


class ScriptedServos(Capability):
    rate_hz = 100.0

    def __init__(self, ctx) -> None:
        super().__init__(ctx)
        self._angles: dict[int, float] = {joint.device_id: joint.zero_rad for joint in ctx.rows(Joint)}
        self._torque: dict[int, float] = dict.fromkeys(self._angles, 0.0)
        self._gate = gate.first(ctx.clock())
        self._sweep = 0

    def step(self) -> None:
        now = self.ctx.clock()
        for received in self.ctx.take("setpoint"):
            self._gate = gate.receive(self._gate, received.message, received.arrived, now, VALID_S)
        self._gate = gate.tick(self._gate, now, VALID_S)
        for goal in self._gate.goals.values() if self._gate.follows else ():
            self._torque[goal.id] = goal.torque
            if goal.torque and goal.position_rad is not None:
                self._angles[goal.id] = goal.position_rad
        self._sweep += 1
        held = "following" if self._gate.follows else "holding"
        servos = tuple(
            ServoState(id=id_, position_rad=angle, torque=self._torque[id_], age_s=0.0)
            for id_, angle in self._angles.items()
        )
        state = ServosState(
            sweep=self._sweep,
            measured_s=now,
            armed=True,
            phase=held if any(self._torque.values()) else "released",
            servos=servos,
            halt=self._gate.halt or 0,
            reason=self._gate.reason,
        )
        self.ctx.publish("state", state)


KIND = replace(
    DYNAMIXEL,
    name="scripted_servos",
    entry=ScriptedServos,
    settings=NoSettings,
    device=None,
    rows=(Rows(Joint),),
)
