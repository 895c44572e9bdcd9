"""Emulated Dynamixel AX-12A servos, a USB2AX and the line between them: bytes in, bytes out, no I/O."""

from lbr.simulation.bus_timing import BusTiming
from lbr.simulation.dynamixel.bus import DynamixelBus
from lbr.simulation.dynamixel.dongle import Usb2Ax
from lbr.simulation.dynamixel.servo import AxServo

__all__ = ["AxServo", "BusTiming", "DynamixelBus", "Usb2Ax"]
