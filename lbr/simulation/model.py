"""The MuJoCo description of the robot and its room."""

from collections.abc import Sequence
from math import cos, pi, radians, sin
from xml.sax.saxutils import quoteattr

from lbr.messages.kinematics import Wheel
from lbr.simulation.ahrs import from_angles
from lbr.simulation.balls import BALL, Ball, first_place
from lbr.simulation.room import BoxSettings
from lbr.simulation.settings import Body, Dock, Mount, WorldSettings

TIMESTEP_S = 0.004
"""The physics step: 250 Hz."""

MAX_TORQUE_NM = 5.0
"""The torque of one geared wiper motor at its wheel before the controller limits its current."""

ROLLING_NM = 0.25
"""Gear and rolling friction of one wheel."""

FLOOR, STANDING, ROBOT = 0, 1, 2
"""Groups of geoms: the floor and visible-only things, standing things, the robot."""

PLACEABLE = tuple(f"placed {number}" for number in range(4))
"""Bodies that wait below the floor until they are placed."""

PARKED_M = -10.0
DOCK = "dock"
IMU = "imu"

_STIFFNESS_NMS = 4.0
_CLEARANCE_M = 0.04
_DECK_M = 0.20
_WHEEL_WIDTH_M = 0.04
_WHEELS_SHARE = 0.1
"""The share of the robot's mass in its wheels."""
_CASTER_M = 0.03
_CASTER_GAP_M = 0.002
_SMOOTH = 'friction="0.3 0.005 0.0001"'


def model_xml(settings: WorldSettings, wheels: Sequence[Wheel] = (), *, rollers: bool = False) -> str:
    """Return the model, with a camera for each of the robot's; `FLOOR`, `STANDING` and `ROBOT` are its groups.

    Without rows of wheels the robot has two. Each wheel, its joint and its motor have the name of its row. Wheels with
    `rollers` slide on the floor: `rollers.Rollers` drives such a base.
    """
    wheels = wheels or two_wheels(settings.body)
    return f"""
<mujoco model="world">
  <compiler angle="radian"/>
  <option timestep="{TIMESTEP_S}" integrator="implicitfast" magnetic="{_numbers(*settings.compass.vector_ut)}"/>
  <visual>
    <headlight ambient="0.45 0.45 0.45" diffuse="0.5 0.5 0.5" specular="0 0 0"/>
    <quality offsamples="0" shadowsize="0"/>
  </visual>
  <worldbody>
    <geom name="floor" type="plane" size="50 50 0.1" group="{FLOOR}" friction="0.9 0.005 0.0001"
          rgba="0.74 0.68 0.6 1"/>
{"".join(_geom(box) for box in settings.walls)}{_dock(settings.dock)}{"".join(map(_placeable, PLACEABLE))}
{_robot(settings, wheels, rollers=rollers)}{"".join(_ball(*one) for one in settings.balls.items())}
  </worldbody>
  <actuator>{"".join(_motor(wheel.name) for wheel in wheels)}</actuator>
  <sensor><gyro site="{IMU}"/><accelerometer site="{IMU}"/><magnetometer site="{IMU}"/></sensor>
</mujoco>"""


def wheel_track_m(body: Body) -> float:
    """Return the distance between the wheels' middles."""
    return body.width_m - _WHEEL_WIDTH_M


def two_wheels(body: Body) -> tuple[Wheel, ...]:
    """Return the wheels of a robot without rows of them."""
    half = wheel_track_m(body) / 2
    return tuple(
        Wheel(name=name, motor=name, y_m=side * half, diameter_m=body.wheel_diameter_m)
        for name, side in (("left", 1), ("right", -1))
    )


def axle_m(wheels: Sequence[Wheel]) -> float:
    """Return the height of the middle of the base above the floor, which is that of its largest wheel's axle."""
    return max(wheel.diameter_m for wheel in wheels) / 2


def _geom(box: BoxSettings) -> str:
    half = (box.length_m / 2, box.width_m / 2, box.height_m / 2)
    size = half if box.kind == "box" else (half[0], half[2])
    group = f'group="{STANDING}"' if box.solid else f'group="{FLOOR}" contype="0" conaffinity="0"'
    return f"""
    <geom name={quoteattr(box.name)} type="{box.kind}" {group} size="{_numbers(*size)}" {_SMOOTH}
          rgba="{_rgba(box.colour)}" euler="0 0 {box.yaw_rad}"
          pos="{_numbers(box.x_m, box.y_m, box.bottom_m + half[2])}"/>"""


def _dock(dock: Dock | None) -> str:
    if dock is None:
        return ""
    depth, width, height = dock.depth_m / 2, dock.width_m / 2, dock.height_m / 2
    x, y = dock.x_m - depth * cos(dock.yaw_rad), dock.y_m - depth * sin(dock.yaw_rad)
    return f"""
    <geom name="{DOCK}" type="box" group="{STANDING}" size="{_numbers(depth, width, height)}" {_SMOOTH}
          rgba="0.15 0.15 0.18 1" pos="{_numbers(x, y, height)}" euler="0 0 {dock.yaw_rad}"/>"""


def _placeable(name: str) -> str:
    return f"""
    <body name="{name}" mocap="true" pos="0 0 {PARKED_M}">
      <geom name="{name}" type="box" group="{STANDING}" size="0.1 0.1 0.1" {_SMOOTH} rgba="0.8 0.25 0.2 1"/>
    </body>"""


def _ball(name: str, ball: Ball) -> str:
    return f"""
    <body name={quoteattr(BALL.format(name))} mocap="true" pos="{_numbers(*first_place(ball))}">
      <geom type="sphere" group="{FLOOR}" contype="0" conaffinity="0" mass="0" size="{ball.radius_m}"
            rgba="{_rgba(ball.colour)}"/>
    </body>"""


def _robot(settings: WorldSettings, wheels: Sequence[Wheel], *, rollers: bool) -> str:
    body, start = settings.body, settings.start
    radius = axle_m(wheels)
    half_length, half_width = body.length_m / 2, body.width_m / 2 - _WHEEL_WIDTH_M
    deck_z, mast = _CLEARANCE_M + _DECK_M / 2 - radius, (body.height_m - _CLEARANCE_M - _DECK_M) / 2
    caster_x, caster_z = half_length - _CASTER_M, _CASTER_M + _CASTER_GAP_M - radius
    return f"""
    <body name="base" pos="{start.x_m} {start.y_m} {radius}" euler="0 0 {start.yaw_rad}">
      <freejoint name="base"/>
      <geom name="deck" type="box" group="{ROBOT}" size="{half_length} {half_width} {_DECK_M / 2}" pos="0 0 {deck_z}"
            mass="{body.mass_kg * 0.82}" {_SMOOTH}/>
      <geom name="mast" type="box" group="{ROBOT}" size="0.03 0.03 {mast}" pos="0 0 {deck_z + _DECK_M / 2 + mast}"
            mass="{body.mass_kg * 0.08}"/>
      {"" if _stands(wheels) else _caster("front", caster_x, caster_z) + _caster("rear", -caster_x, caster_z)}
      {"".join(_wheel(wheel, radius, body.mass_kg * _WHEELS_SHARE / len(wheels), rollers=rollers) for wheel in wheels)}
      <site name="{IMU}" {_place(settings.imu.mount, radius)} {_turned(settings.imu.mount)}/>
      {"".join(_camera(name, mount, settings, radius) for name, mount in settings.cameras.items())}
    </body>"""


def _caster(name: str, x: float, z: float) -> str:
    return f"""
      <geom name="{name}_caster" type="sphere" group="{ROBOT}" size="{_CASTER_M}" pos="{x} 0 {z}" mass="0.05"
            friction="0.001 0.0001 0.0001" priority="1" condim="1"/>"""


def _stands(wheels: Sequence[Wheel]) -> bool:
    """Return whether the wheels alone keep the base from tipping over, ahead and back."""
    return min(wheel.x_m for wheel in wheels) < 0.0 < max(wheel.x_m for wheel in wheels)


def _wheel(wheel: Wheel, base_m: float, mass_kg: float, *, rollers: bool) -> str:
    name, radius = wheel.name, wheel.diameter_m / 2
    grip = (
        'friction="0.001 0.0001 0.0001" priority="1" condim="1"'
        if rollers
        else 'friction="1.0 0.005 0.0001" condim="4"'
    )
    return f"""
      <body name="{name}_wheel" pos="{wheel.x_m} {wheel.y_m} {radius - base_m}" euler="0 0 {wheel.yaw_rad}">
        <joint name="{name}" type="hinge" axis="0 1 0" frictionloss="{ROLLING_NM}" armature="0.02"/>
        <geom name="{name}_wheel" type="cylinder" group="{ROBOT}" size="{radius} {_WHEEL_WIDTH_M / 2}"
              euler="{pi / 2} 0 0" mass="{mass_kg}" {grip}/>
      </body>"""


def _camera(name: str, mount: Mount, settings: WorldSettings, base_m: float) -> str:
    """MuJoCo's cameras look along -z with x to the right: turned so, they look along their mount's x."""
    pitch, yaw = radians(mount.pitch_deg), radians(mount.yaw_deg)
    right = (sin(yaw), -cos(yaw), 0.0)
    up = (cos(yaw) * sin(pitch), sin(yaw) * sin(pitch), cos(pitch))
    return f"""
      <camera name={quoteattr(name)} {_place(mount, base_m)}
              xyaxes="{_numbers(*right, *up)}" fovy="{settings.camera_fov_deg}"/>"""


def _place(mount: Mount, wheel_radius_m: float) -> str:
    return f'pos="{_numbers(mount.x_m, mount.y_m, mount.z_m - wheel_radius_m)}"'


def _turned(mount: Mount) -> str:
    """Return yaw, then pitch, then roll, each about its own axis as turned by the previous ones."""
    turn = from_angles(radians(mount.roll_deg), radians(mount.pitch_deg), radians(mount.yaw_deg))
    return f'quat="{_numbers(*turn)}"'


def _motor(name: str) -> str:
    return f"""
    <velocity name="{name}" joint="{name}" kv="{_STIFFNESS_NMS}" forcerange="{-MAX_TORQUE_NM} {MAX_TORQUE_NM}"/>"""


def _rgba(colour: str) -> str:
    return _numbers(*(int(colour[at : at + 2], 16) / 255 for at in (1, 3, 5)), 1.0)


def _numbers(*values: float) -> str:
    return " ".join(f"{value:.9g}" for value in values)
