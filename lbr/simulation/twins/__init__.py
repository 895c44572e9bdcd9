"""Emulated devices in the world: each a pure device on a port, wired to what the engine moves and senses."""

from lbr.simulation.twins.base import Feeling, MotorDrive, PowerSwitch, ServoBus, Surroundings, Twin, WheelDrive, make

__all__ = ["Feeling", "MotorDrive", "PowerSwitch", "ServoBus", "Surroundings", "Twin", "WheelDrive", "make"]
