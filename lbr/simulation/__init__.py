"""The simulated world: physics, emulated devices that exchange the real bytes, and a view from above."""

from lbr.component import CliCommand, Component

COMPONENT = Component(
    kinds={
        "world": "lbr.simulation.kind:KIND",
        "humanoid_world": "lbr.simulation.humanoid:KIND",
    },
    commands={
        "view": CliCommand(
            entry="lbr.simulation.commands.view:command",
            help="Watch a simulated robot: its room from above, or its joints.",
            group="look",
        ),
    },
    twins={
        "camera": "lbr.simulation.devices.camera:TWIN",
        "dynamixel": "lbr.simulation.devices.dynamixel:TWIN",
        "gamepad": "lbr.simulation.devices.gamepad:TWIN",
        "infrared": "lbr.simulation.devices.infrared:TWIN",
        "ld06": "lbr.simulation.devices.ld06:TWIN",
        "mpu9150": "lbr.simulation.devices.mpu9150:TWIN",
        "phidget_spatial": "lbr.simulation.devices.phidget_spatial:TWIN",
        "pico": "lbr.simulation.devices.pico:TWIN",
        "riox": "lbr.simulation.devices.riox:TWIN",
        "roboteq": "lbr.simulation.devices.roboteq:TWIN",
        "ultrasonic_ring": "lbr.simulation.devices.ultrasonic_ring:TWIN",
    },
    public=(
        "lbr.simulation.faults",
        "lbr.simulation.humanoid",
        "lbr.simulation.i2c",
        "lbr.simulation.measured",
        "lbr.simulation.port",
        "lbr.simulation.socket_port",
        "lbr.simulation.trace",
        "lbr.simulation.trials",
        "lbr.simulation.turning",
        "lbr.simulation.twins",
        "lbr.simulation.wire",
    ),
    messages=("lbr.simulation.messages",),
)
