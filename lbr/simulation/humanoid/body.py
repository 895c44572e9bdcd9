"""A humanoid's body: a MuJoCo description, a robot's or the user's own, with floor, helper's hand and sensors added."""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lbr.errors import InputError
from lbr.messages.joints import Joint
from lbr.messages.units import Vector
from lbr.robot import registry
from lbr.simulation.balls import BALL, Ball, first_place
from lbr.simulation.bindings import MjModel, MjsBody, MjSpec
from lbr.simulation.humanoid.settings import HumanoidWorldSettings
from lbr.simulation.physics import mujoco

STIFF_SHARE = 0.1
"""A joint with less than this share of its row's range has another unit: degrees are 57 times as many."""
TIMESTEP_S = 0.004
"""250 steps a second, as often as the inertial unit measures; 1 ms walks and holds alike, for three times the work."""

Mask = NDArray[np.bool_]
Indices = NDArray[np.intp]

HAND, FLOOR, IMU = "hand", "floor", "imu"


@dataclass(frozen=True, slots=True)
class Body:
    """A model that is ready to move: the bodies of its trunk and feet, and its geoms with collisions.

    `positions` and `speeds` are the indices of its joints, in the order of the rows. `cameras` are the names of its
    cameras.
    """

    model: MjModel
    trunk: int
    feet: dict[str, int]
    solid: Mask
    positions: Indices
    speeds: Indices
    cameras: tuple[str, ...]


def model_file(name: str, home: str) -> Path:
    """Return the file of a body, the user's own or a robot's; raise InputError with the known ones."""
    own = Path(home) / "models"
    if (own / f"{name}.xml").is_file():
        return own / f"{name}.xml"
    brought = registry.find(name)
    if brought is not None and brought.robot is not None and brought.robot.body is not None:
        return brought.robot.body
    known = sorted({*(path.stem for path in own.glob("*.xml")), *registry.bodies()})
    raise InputError(
        f"world setting `model`: there is no body '{name}': neither {own / name}.xml nor one that a robot brings; "
        f"there are: {', '.join(known) or 'none'}"
    )


def load(path: Path, joints: Iterable[Joint], settings: HumanoidWorldSettings) -> Body:
    """Return the body in a file; raise InputError with its fault."""
    rows = tuple(joints)
    spec = _parsed(path)
    trunk = _checked(path, spec, rows)
    _surround(spec, trunk, settings.compass.vector_ut)
    for name, ball in settings.balls.items():
        _add_ball(spec.worldbody, name, ball)
    hinges = [joint for joint in spec.joints if joint.type != mujoco.mjtJoint.mjJNT_FREE]
    for joint, motor in zip(hinges, settings.motors_of([joint.name for joint in hinges]), strict=True):
        joint.armature, joint.frictionloss = motor.armature_kgm2, motor.friction_nm
    try:
        model = spec.compile()
    except (ValueError, mujoco.FatalError) as err:
        raise InputError(f"body {path}: {' '.join(str(err).split())}") from err
    solid = (model.geom_contype != 0) & (model.geom_bodyid != 0)
    feet = {model.body(at).name: at for at in range(model.nbody) if model.body(at).name.endswith("foot")}
    cameras = tuple(model.camera(at).name for at in range(model.ncam))
    moved = [model.joint(row.name) for row in rows]
    if stiff := [said for row in rows if (said := _stiff(model, row))]:
        raise InputError(f"body {path}: {'; '.join(stiff)}")
    return Body(
        model=model,
        trunk=model.body(trunk.name).id,
        feet=feet,
        solid=solid,
        positions=np.array([joint.qposadr[0] for joint in moved], dtype=np.intp),
        speeds=np.array([joint.dofadr[0] for joint in moved], dtype=np.intp),
        cameras=cameras,
    )


def heading_rad(trunk_axes: NDArray[np.float64]) -> float:
    """Return the heading of a trunk, even if it lies: by the flatter one of its axes ahead and left."""
    ahead, left, _ = trunk_axes.reshape(3, 3).T
    if abs(ahead[2]) < abs(left[2]):
        return float(np.arctan2(ahead[1], ahead[0]))
    return float(np.arctan2(-left[0], left[1]))


def _parsed(path: Path) -> MjSpec:
    try:
        return mujoco.MjSpec.from_file(str(path))
    except (ValueError, mujoco.FatalError) as err:
        raise InputError(f"body {path}: {' '.join(str(err).split())}") from err


def _checked(path: Path, spec: MjSpec, rows: tuple[Joint, ...]) -> MjsBody:
    """Return the body to which all others are attached."""
    tops = list(spec.worldbody.bodies)
    free = [joint for joint in spec.joints if joint.type == mujoco.mjtJoint.mjJNT_FREE]
    if len(tops) != 1 or len(free) != 1 or free[0].parent.name != tops[0].name or not tops[0].name:
        raise InputError(f"body {path}: it needs one body at the top, named and with the only <freejoint/>")
    if not any(site.name == IMU for site in spec.sites):
        raise InputError(f'body {path}: it needs a <site name="{IMU}"/> where the inertial unit sits')
    hinges = {joint.name: joint for joint in spec.joints if joint is not free[0]}
    wanted = {row.name for row in rows}
    problems = [f"no joint '{name}', which the joint rows name" for name in sorted(wanted - set(hinges))]
    problems += [f"a joint '{name}' that no joint row names" for name in sorted(set(hinges) - wanted)]
    problems += [
        f"the joint '{name}' is not a hinge"
        for name, joint in sorted(hinges.items())
        if name in wanted and joint.type != mujoco.mjtJoint.mjJNT_HINGE
    ]
    if problems:
        raise InputError(f"body {path}: {'; '.join(problems)}")
    return tops[0]


def _stiff(model: MjModel, row: Joint) -> str:
    """Report a joint with hardly any range, against its row: then its angles have the other unit."""
    joint = model.joint(row.name)
    lowest, highest = map(float, joint.range)
    if not model.jnt_limited[joint.id] or highest - lowest >= STIFF_SHARE * (row.upper_rad - row.lower_rad):
        return ""
    return (
        f"the joint '{row.name}' turns from {lowest:.3f} to {highest:.3f} rad, and its row says {row.lower_rad:g} to "
        f'{row.upper_rad:g}: MJCF counts degrees unless it has <compiler angle="radian"/>'
    )


def _surround(spec: MjSpec, trunk: MjsBody, field_ut: Vector) -> None:
    """Add the parts of every body: a floor, a hand that can hold it by its trunk, and its inertial unit's sensors."""
    spec.option.timestep = TIMESTEP_S
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.magnetic = field_ut
    spec.visual.headlight.ambient, spec.visual.headlight.diffuse = [0.45] * 3, [0.5] * 3
    spec.visual.headlight.specular = [0.0] * 3
    spec.visual.quality.offsamples = spec.visual.quality.shadowsize = 0
    world = spec.worldbody
    world.add_geom(
        name=FLOOR,
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        size=[20, 20, 0.1],
        friction=[0.9, 0.005, 0.0001],
        rgba=[0.60, 0.63, 0.66, 1.0],
    )
    world.add_body(name=HAND, mocap=True, pos=trunk.pos)
    spec.add_equality(
        type=mujoco.mjtEq.mjEQ_WELD,
        objtype=mujoco.mjtObj.mjOBJ_BODY,
        name1=HAND,
        name2=trunk.name,
        data=[0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0],
    )
    kinds = mujoco.mjtSensor
    for kind in (kinds.mjSENS_GYRO, kinds.mjSENS_ACCELEROMETER, kinds.mjSENS_MAGNETOMETER):
        spec.add_sensor(type=kind, objtype=mujoco.mjtObj.mjOBJ_SITE, objname=IMU)


def _add_ball(world: MjsBody, name: str, ball: Ball) -> None:
    """Add a visible ball that moves by itself."""
    body = world.add_body(name=BALL.format(name), mocap=True, pos=first_place(ball))
    colour = [*(int(ball.colour[at : at + 2], 16) / 255 for at in (1, 3, 5)), 1.0]
    body.add_geom(
        type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[ball.radius_m, 0, 0], contype=0, conaffinity=0, mass=0, rgba=colour
    )
