"""Words of the console that every simulated world brings."""

from lbr.capability.word import Word

FAULT_WORDS = (
    Word(
        "/fault/{device}/{name}",
        "fault",
        "Simulation: let an emulated device fail, such as /fault/imu/unplug",
        {"value": True},
    ),
    Word("/fault/{device}/{name}/off", "fault", "Simulation: end a fault of an emulated device", {"value": None}),
    Word(
        "/fault/{device}/{name}/{value}",
        "fault",
        "Simulation: a fault with a number or names, such as /fault/imu/noise/5",
    ),
)
