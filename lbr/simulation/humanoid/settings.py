"""What a `humanoid_world` row may set; the defaults are AX-12A servos on three lithium cells."""

from typing import Annotated

from msgspec import Meta, Struct

from lbr.messages.units import Name
from lbr.simulation.settings import Battery, Compass, Imu


class Motor(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What is in each servo: torque when it stalls and speed without load at `rated_v`, its gear, its current.

    `friction_nm` and `armature_kgm2`, the inertia of its rotor, are as they show at the horn.
    """

    stall_nm: Annotated[float, Meta(gt=0.0, le=100.0)] = 1.5
    no_load_rps: Annotated[float, Meta(gt=0.0, le=100.0)] = 6.2
    rated_v: Annotated[float, Meta(gt=0.0, le=60.0)] = 12.0
    friction_nm: Annotated[float, Meta(ge=0.0, le=10.0)] = 0.06
    armature_kgm2: Annotated[float, Meta(gt=0.0, le=1.0)] = 0.005
    stall_a: Annotated[float, Meta(ge=0.0, le=50.0)] = 1.5


class HumanoidWorldSettings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The simulated humanoid: `model` is a body, shipped or in `$LBR_HOME/models`, whose joints bear the rows' names.

    It begins upright, every joint at zero, in a helper's hand. The hand lets go once all servos have had torque for
    `hand_s` and its weight is above its feet; until then it keeps them on the floor. `seed` fixes all noise. Where the
    inertial unit sits, the body says: the `mount` of `imu` counts for nothing.
    """

    model: Name
    seed: int = 1
    stand: Annotated[bool, Meta(description="hung up by its trunk for good, feet off the floor: it cannot fall")] = (
        False
    )
    hand_s: Annotated[float, Meta(ge=0.0, le=60.0)] = 1.0
    motor: Motor = Motor()
    battery: Battery = Battery(
        open_circuit_v=12.0, internal_ohm=0.06, capacity_ah=1.0, idle_a=0.5, charged_v=12.6, charging_s=60.0
    )
    imu: Imu = Imu()
    compass: Compass = Compass()
    pose_hz: Annotated[float, Meta(ge=1.0, le=100.0)] = 20.0
