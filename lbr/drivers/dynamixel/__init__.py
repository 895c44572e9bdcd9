"""A bus of Dynamixel AX-12A servos, protocol 1.0: its kind and its settings.

The bus also works without a robot:

    from lbr.drivers.dynamixel import table
    from lbr.drivers.dynamixel.bus import open_bus

    with open_bus("/dev/ttyACM0") as bus:
        servos = bus.scan(range(1, 19))
        bus.find_adapter()                                   # a USB2AX reads all of them at once
        for servo, motion in zip(servos, bus.read_motions(servos)):
            print(servo, motion and (motion.position_rad, motion.speed_rps, motion.load_fraction))
        bus.put(1, table.LED, 1)
        bus.write_all(table.GOAL_POSITION.address, {servo: (512).to_bytes(2, "little") for servo in servos})

`packet` is the codec, `table` the control table. With `lbr.drivers.servos.bus_thread` several threads share a bus. See
docs/servo_lines.md.
"""

from typing import Annotated, Literal

from msgspec import Meta

from lbr.drivers.servos import RegisterServosSettings, servos_kind

AlarmName = Literal["voltage", "angle_limit", "overheat", "range", "checksum", "overload", "instruction"]
SupplyV = Annotated[float, Meta(ge=5.0, le=16.0, description="volts")]


class DynamixelSettings(RegisterServosSettings, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Settings of a row of kind `dynamixel`."""

    baud: Annotated[int, Meta(ge=7843, le=1_000_000)] = 1_000_000
    reply_margin_s: Annotated[
        float, Meta(ge=0.001, le=0.1, description="a later answer than wire and servo explain is lost")
    ] = 0.004
    sync_read: Annotated[bool, Meta(description="let a USB2AX read all servos at once")] = True
    write_eeprom: Annotated[bool, Meta(description="correct what servos keep without power")] = True
    return_delay_us: Annotated[int, Meta(ge=0, le=508)] = 0
    lowest_v: SupplyV = 6.0
    highest_v: SupplyV = 14.0
    alarms: Annotated[tuple[AlarmName, ...], Meta(description="what lights a servo's LED and takes its torque")] = (
        "overload",
        "overheat",
    )

    def __post_init__(self) -> None:
        """Refuse settings that would remove a servo's protection."""
        if not {"overload", "overheat"} <= set(self.alarms):
            raise ValueError("alarms must hold `overload` and `overheat`: they are what protects a servo")
        if self.lowest_v >= self.highest_v:
            raise ValueError(f"lowest_v {self.lowest_v:g} is not below highest_v {self.highest_v:g}")


KIND = servos_kind(
    "dynamixel",
    "a bus of Dynamixel AX-12A servos, protocol 1.0, plain or by a USB2AX",
    "lbr.drivers.dynamixel.capability:Dynamixel",
    DynamixelSettings,
    recognised="lbr.drivers.dynamixel.recognition:HANDSHAKE",
)
