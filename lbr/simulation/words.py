"""Words of the console that every simulated world brings."""

from lbr.capability.word import Word

BALL_WORDS = (
    Word(
        "/ball/{x_m}/{y_m}/{z_m}",
        "ball",
        "Simulation: put the ball there, metres ahead, to the left and up of where the robot began",
    ),
    Word("/ball/{x_m}/{y_m}", "ball", "Simulation: put the ball there, as high as the world has it"),
    Word("/ball", "ball", "Simulation: have the ball be as it began"),
    Word("/ball/gone", "ball", "Simulation: take the ball out of the world", {"gone": True}),
)
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
