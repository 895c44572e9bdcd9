"""A servo bus without servos, as a file of a user's own: each is at once where it is told to be, while it is told so."""

from dataclasses import replace

from msgspec import Struct

from lbr.capability import Capability, Rows
from lbr.drivers.dynamixel import KIND as DYNAMIXEL
from lbr.messages.joints import Joint
from lbr.messages.servos import ServosState, ServoState

VALID_S = 0.1


class NoSettings(Struct, frozen=True, forbid_unknown_fields=True):
    """Whatever the row sets."""


class ScriptedServos(Capability):
    rate_hz = 100.0

    def __init__(self, ctx) -> None:
        super().__init__(ctx)
        self._angles: dict[int, float] = {joint.device_id: joint.zero_rad for joint in ctx.rows(Joint)}
        self._torque: dict[int, float] = dict.fromkeys(self._angles, 0.0)
        self._sweep = 0

    def step(self) -> None:
        now = self.ctx.clock()
        newest = self.ctx.latest("setpoint")
        fresh = newest is not None and newest.age_s(now) <= VALID_S
        told = newest.message if fresh else None
        if told is not None and not told.lost:
            for goal in told.goals:
                self._torque[goal.id] = goal.torque
                if goal.torque and goal.position_rad is not None:
                    self._angles[goal.id] = goal.position_rad
        self._sweep += 1
        phase = "released" if not any(self._torque.values()) else "following"
        if phase == "following" and (told is None or told.lost):
            phase = "holding"
        servos = tuple(
            ServoState(id=id_, position_rad=angle, torque=self._torque[id_], age_s=0.0)
            for id_, angle in self._angles.items()
        )
        state = ServosState(
            sweep=self._sweep,
            measured_s=now,
            armed=True,
            phase=phase,
            servos=servos,
            halt=newest.message.halt if newest is not None else 0,
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
