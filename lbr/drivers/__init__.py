"""Drivers: each owns one device, speaks its protocol and has the last decision about its motion."""

from lbr.component import Component

COMPONENT = Component(
    kinds={
        "camera": "lbr.drivers.camera:KIND",
        "dynamixel": "lbr.drivers.dynamixel:KIND",
        "gamepad": "lbr.drivers.gamepad:KIND",
        "infrared": "lbr.drivers.infrared:KIND",
        "ld06": "lbr.drivers.ld06:KIND",
        "mpu9150": "lbr.drivers.mpu9150:KIND",
        "phidget_spatial": "lbr.drivers.phidget_spatial:KIND",
        "pico": "lbr.drivers.pico:KIND",
        "riox": "lbr.drivers.riox:KIND",
        "roboteq": "lbr.drivers.roboteq:KIND",
        "ultrasonic_ring": "lbr.drivers.ultrasonic:KIND",
    },
)
