"""Emulated devices in the world: each a pure device on a port, connected to the engine's motion and measurements."""

from lbr.simulation.twins.base import Feeling, MotorDrive, PowerSwitch, ServoBus, Surroundings, Twin, WheelDrive, make

__all__ = ["Feeling", "MotorDrive", "PowerSwitch", "ServoBus", "Surroundings", "Twin", "WheelDrive", "make"]
