"""Emulated devices in the world: each a pure device on a port, wired to what the engine moves and senses."""

from collections.abc import Mapping

from lbr.simulation.twins.base import Factory, Feeling, PowerSwitch, ServoBus, Surroundings, Twin
from lbr.simulation.twins.camera import CameraTwin
from lbr.simulation.twins.dynamixel import DynamixelTwin
from lbr.simulation.twins.infrared import InfraredTwin
from lbr.simulation.twins.mpu9150 import Mpu9150Twin
from lbr.simulation.twins.phidget_spatial import PhidgetSpatialTwin
from lbr.simulation.twins.pico import PicoTwin
from lbr.simulation.twins.riox import RioxTwin
from lbr.simulation.twins.roboteq import RoboteqTwin
from lbr.simulation.twins.ultrasonic import UltrasonicTwin
from lbr.simulation.twins.uxa90 import Uxa90Twin

__all__ = ["TWINS", "WITHOUT_TWIN", "Feeling", "PowerSwitch", "RoboteqTwin", "ServoBus", "Surroundings", "Twin"]

TWINS: Mapping[str, Factory] = {
    "roboteq": RoboteqTwin,
    "ultrasonic_ring": UltrasonicTwin,
    "mpu9150": Mpu9150Twin,
    "phidget_spatial": PhidgetSpatialTwin,
    "riox": RioxTwin,
    "pico": PicoTwin,
    "infrared": InfraredTwin,
    "camera": CameraTwin,
    "dynamixel": DynamixelTwin,
    "uxa90": Uxa90Twin,
}
"""The twin of each type of device."""

WITHOUT_TWIN = frozenset({"speaker"})
"""Types whose place is enough: a folder into which things go."""
