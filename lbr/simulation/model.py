"""The MuJoCo description of the robot and its room."""

from math import pi
from xml.sax.saxutils import quoteattr

from lbr.simulation.settings import Body, BoxSettings, WorldSettings

TIMESTEP_S = 0.004
"""The physics step: 250 Hz."""

MAX_TORQUE_NM = 5.0
"""What one geared wiper motor gives at its wheel before the controller limits its current."""

ROLLING_NM = 0.25
"""Gear and rolling friction of one wheel."""

_STIFFNESS_NMS = 4.0
_CLEARANCE_M = 0.04
_DECK_M = 0.20
_WHEEL_WIDTH_M = 0.04
_CASTER_M = 0.03
_CASTER_GAP_M = 0.002


def model_xml(settings: WorldSettings) -> str:
    """Return the model: group 0 the floor, group 1 what stands on it, group 2 the robot."""
    walls = "".join(_wall(box) for box in settings.walls)
    return f"""
<mujoco model="world">
  <compiler angle="radian"/>
  <option timestep="{TIMESTEP_S}" integrator="implicitfast"/>
  <worldbody>
    <geom name="floor" type="plane" size="50 50 0.1" group="0" friction="0.9 0.005 0.0001"/>{walls}{_robot(settings)}
  </worldbody>
  <actuator>{_motor("left")}{_motor("right")}
  </actuator>
</mujoco>"""


def wheel_track_m(body: Body) -> float:
    """Return the distance between the wheels' middles."""
    return body.width_m - _WHEEL_WIDTH_M


def _wall(box: BoxSettings) -> str:
    size = f"{box.length_m / 2} {box.width_m / 2} {box.height_m / 2}"
    return f"""
    <geom name={quoteattr(box.name)} type="box" group="1" size="{size}" friction="0.3 0.005 0.0001"
          pos="{box.x_m} {box.y_m} {box.height_m / 2}" euler="0 0 {box.yaw_rad}"/>"""


def _robot(settings: WorldSettings) -> str:
    body, start = settings.body, settings.start
    radius = body.wheel_diameter_m / 2
    half_length, half_width = body.length_m / 2, body.width_m / 2 - _WHEEL_WIDTH_M
    deck_z, mast = _CLEARANCE_M + _DECK_M / 2 - radius, (body.height_m - _CLEARANCE_M - _DECK_M) / 2
    caster_x, caster_z = half_length - _CASTER_M, _CASTER_M + _CASTER_GAP_M - radius
    return f"""
    <body name="base" pos="{start.x_m} {start.y_m} {radius}" euler="0 0 {start.yaw_rad}">
      <freejoint name="base"/>
      <geom name="deck" type="box" group="2" size="{half_length} {half_width} {_DECK_M / 2}" pos="0 0 {deck_z}"
            mass="{body.mass_kg * 0.82}" friction="0.3 0.005 0.0001"/>
      <geom name="mast" type="box" group="2" size="0.03 0.03 {mast}" pos="0 0 {deck_z + _DECK_M / 2 + mast}"
            mass="{body.mass_kg * 0.08}"/>
      <geom name="front_caster" type="sphere" group="2" size="{_CASTER_M}" pos="{caster_x} 0 {caster_z}" mass="0.05"
            friction="0.001 0.0001 0.0001" priority="1" condim="1"/>
      <geom name="rear_caster" type="sphere" group="2" size="{_CASTER_M}" pos="{-caster_x} 0 {caster_z}" mass="0.05"
            friction="0.001 0.0001 0.0001" priority="1" condim="1"/>{_wheel("left", body, 1)}{_wheel("right", body, -1)}
    </body>"""


def _wheel(name: str, body: Body, side: int) -> str:
    radius = body.wheel_diameter_m / 2
    return f"""
      <body name="{name}_wheel" pos="0 {side * wheel_track_m(body) / 2} 0">
        <joint name="{name}" type="hinge" axis="0 1 0" frictionloss="{ROLLING_NM}" armature="0.02"/>
        <geom name="{name}_wheel" type="cylinder" group="2" size="{radius} {_WHEEL_WIDTH_M / 2}"
              euler="{pi / 2} 0 0" mass="{body.mass_kg * 0.05}" friction="1.0 0.005 0.0001" condim="4"/>
      </body>"""


def _motor(name: str) -> str:
    return f"""
    <velocity name="{name}" joint="{name}" kv="{_STIFFNESS_NMS}" forcerange="{-MAX_TORQUE_NM} {MAX_TORQUE_NM}"/>"""
