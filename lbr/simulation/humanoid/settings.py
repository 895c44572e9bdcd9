"""Settings of a `humanoid_world` row; the defaults are small servos on three lithium cells."""

from collections.abc import Sequence
from fnmatch import fnmatchcase
from typing import Annotated, Literal

from msgspec import Meta, Struct

from lbr.errors import InputError
from lbr.messages.units import Name
from lbr.simulation.balls import Ball
from lbr.simulation.settings import Battery, Compass, Imu


class Motor(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The motor of each servo, at `rated_v`: stall torque, speed without load, current; friction and rotor inertia are
    at the horn."""

    stall_nm: Annotated[float, Meta(gt=0.0, le=100.0)] = 1.5
    no_load_rps: Annotated[float, Meta(gt=0.0, le=100.0)] = 6.2
    rated_v: Annotated[float, Meta(gt=0.0, le=60.0)] = 12.0
    friction_nm: Annotated[float, Meta(ge=0.0, le=10.0)] = 0.06
    armature_kgm2: Annotated[float, Meta(gt=0.0, le=1.0)] = 0.005
    stall_a: Annotated[float, Meta(ge=0.0, le=50.0)] = 1.5


class Motors(Motor, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The motors of some `joints`: names or patterns such as `*_knee`."""

    joints: Annotated[tuple[str, ...], Meta(min_length=1)]


class Mounting(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The place of a servo on its joint: its angle at the joint's 0; sign -1: it turns the other way."""

    zero_rad: Annotated[float, Meta(ge=-3.0, le=3.0)] = 0.0
    sign: Literal[1, -1] = 1


class HumanoidWorldSettings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """`model`: a body in `$LBR_HOME/models` or of a robot, with the joints of the rows.

    It begins upright, all joints at zero, in a helper's hand. The hand opens once all servos have had torque for
    `hand_s` and its weight is above its feet. With `rests`, angles of a rest, it begins limp, without a hand. `seed`
    fixes all noise. The body places the inertial unit: the `mount` of `imu` is unused. `motors`: those that differ from
    `motor`, the first that fits. `mounted`: servos, by joint, with a mounting unlike their rows. `balls`: targets of
    its camera, by name.
    """

    model: Name
    seed: int = 1
    stand: Annotated[bool, Meta(description="hung up by its trunk: it cannot fall")] = False
    hand_s: Annotated[float, Meta(ge=0.0, le=60.0)] = 1.0
    rests: dict[str, Annotated[float, Meta(ge=-7.0, le=7.0, description="radians")]] = {}
    motor: Motor = Motor()
    motors: tuple[Motors, ...] = ()
    mounted: dict[str, Mounting] = {}
    balls: Annotated[dict[str, Ball], Meta(max_length=8)] = {}
    battery: Battery = Battery(
        open_circuit_v=12.0, internal_ohm=0.06, capacity_ah=1.0, idle_a=0.5, charged_v=12.6, charging_s=60.0
    )
    imu: Imu = Imu()
    compass: Compass = Compass()
    pose_hz: Annotated[float, Meta(ge=1.0, le=100.0)] = 20.0

    def motors_of(self, joints: Sequence[str]) -> list[Motor]:
        """Return the motor in the servo of each joint; raise InputError with a pattern that fits none."""
        patterns = [pattern for group in self.motors for pattern in group.joints]
        unused = [pattern for pattern in patterns if not any(fnmatchcase(joint, pattern) for joint in joints)]
        if unused:
            raise InputError(f"world setting `motors`: there is no joint '{unused[0]}'")
        return [self._motor_of(joint) for joint in joints]

    def _motor_of(self, joint: str) -> Motor:
        fitting = (group for group in self.motors if any(fnmatchcase(joint, pattern) for pattern in group.joints))
        return next(fitting, self.motor)
