"""What can be made to go wrong with an emulated device: its row's setting `faults`, and changed while it runs."""

from typing import Annotated, Any, Literal, TypeVar

import msgspec
from msgspec import Meta, Struct

from lbr.errors import InputError

Probability = Annotated[float, Meta(ge=0.0, le=1.0, description="how often it happens, 0 never, 1 always")]
Side = Literal["forward", "left", "right", "back"]
PinnedM = Annotated[float, Meta(ge=0.0, le=7.65, description="metres a sensor is made to see; null sees the world")]
SupplyV = Annotated[float, Meta(ge=0.0, le=99.99, description="volts")]
FaultValue = bool | float | str | tuple[str, ...] | None
ServoIds = tuple[Annotated[int, Meta(ge=0, le=253, description="a servo's number on its bus")], ...]

F = TypeVar("F", bound="Faults")


class Faults(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What can go wrong with any device: `unplug`, its cable is out."""

    unplug: bool = False


class LineFaults(Faults, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Faults of a device that is talked to in lines; `unplug`: the cable is out while the device goes on.

    `silent`: it obeys but says nothing. `drop`, `bit_flip`, `garbage`: a reply is lost, has a bit wrong, has noise
    before it. `refuse`: a command is answered `-` and not obeyed. `stop_reading`: bytes pile up in the port.
    `brown_out`: its supply is gone, and with it all that was not saved.
    """

    silent: bool = False
    drop: Probability = 0.0
    bit_flip: Probability = 0.0
    garbage: Probability = 0.0
    refuse: Probability = 0.0
    stop_reading: bool = False
    brown_out: bool = False


class RoboteqFaults(LineFaults, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Faults of the motor controller: those of a line, and more.

    `undervoltage`, `overheat`: the fault bit, with the power stage off.
    """

    undervoltage: bool = False
    overheat: bool = False


class RioxFaults(LineFaults, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Faults of a RIOX: those of a line, and more.

    `half`: an answer ends early, without its line end. `pieces`: answers come in pieces with pauses. `frozen`: the same
    numbers for ever. `jump`: an answer's turn rate is off by 4 rad/s.
    """

    half: Probability = 0.0
    pieces: bool = False
    frozen: bool = False
    jump: Probability = 0.0


class InfraredFaults(Faults, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Faults of an infrared receiver.

    `silent`: it sees nothing. `garbage`: a record has noise before it. `half`: a record ends early. `stray`: a code of
    somebody else's remote control comes in between. `stuck`: the left beam all the time.
    """

    silent: bool = False
    garbage: Probability = 0.0
    half: Probability = 0.0
    stray: Probability = 0.0
    stuck: bool = False


class CameraFaults(Faults, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Faults of a camera.

    `frozen`: the same picture for ever, always new. `stalled`: no picture comes. `slow`: two come each second.
    `black`: its cap is on. `garbage`: a picture is no JPEG.
    """

    frozen: bool = False
    stalled: bool = False
    slow: bool = False
    black: bool = False
    garbage: Probability = 0.0


class UltrasonicFaults(Faults, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Faults of a ring of ultrasonic sensors.

    `frozen`: the same numbers for ever. `garbage`, `half_lines`: a report has noise before it, or ends early without
    its line end. `noise_cm`: standard deviation added. `missing`: sensors that are not there. `over_range`, `error`:
    sensors that read 758 or 0. `range_*_m` pins a sensor to a distance. `unplug`: cable out, board without power.
    """

    silent: bool = False
    frozen: bool = False
    garbage: Probability = 0.0
    half_lines: Probability = 0.0
    noise_cm: Annotated[float, Meta(ge=0.0, le=200.0)] = 0.0
    missing: tuple[Side, ...] = ()
    over_range: tuple[Side, ...] = ()
    error: tuple[Side, ...] = ()
    range_forward_m: PinnedM | None = None
    range_left_m: PinnedM | None = None
    range_right_m: PinnedM | None = None
    range_back_m: PinnedM | None = None


class PhidgetSpatialFaults(Faults, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Faults of a PhidgetSpatial on its USB cable.

    `silent`: attached, but no sample comes. `frozen`: the same sample for ever. `jump`: the turn rate about x is off by
    400 degrees a second. `no_compass`: no field is measured.
    """

    silent: bool = False
    frozen: bool = False
    jump: bool = False
    no_compass: bool = False


class I2cFaults(Faults, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Faults of a device on an i2c bus; `unplug`: the bus is gone.

    `silent`: the bus hangs, nothing is answered. `nak`: a transaction is not acknowledged. `half`: an answer ends early.
    `all_ones`: whatever is read is 0xFF. `brown_out`: it is without supply.
    """

    silent: bool = False
    nak: Probability = 0.0
    half: Probability = 0.0
    all_ones: bool = False
    brown_out: bool = False


class Mpu9150Faults(I2cFaults, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Faults of an MPU-9150: those of its bus, and more.

    `frozen`: the same sample for ever, though ready. `jump`: a sample's turn rate is off by 4 rad/s. `noise`: times the
    usual noise, added. `no_compass`, `overflow`: the compass does not answer, or says that its field is too strong.
    After a `brown_out` it is asleep with nothing set.
    """

    frozen: bool = False
    jump: Probability = 0.0
    noise: Annotated[float, Meta(ge=0.0, le=1000.0)] = 0.0
    no_compass: bool = False
    overflow: bool = False


class PicoFaults(I2cFaults, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Faults of a UPS PIco: those of its bus, what feeds it, and more.

    `hung`: its processor stands still, and with it the running counter. `bad_bcd`: the external voltage is no number.
    `mode_bit_7`: the highest bit of the mode is set, which means nothing. `external_v`, `battery_v`, `source`: so it is,
    whatever the world says; null follows the world.
    """

    hung: bool = False
    bad_bcd: bool = False
    mode_bit_7: bool = False
    external_v: SupplyV | None = None
    battery_v: SupplyV | None = None
    source: Literal["external", "battery"] | None = None


class DynamixelFaults(Faults, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Faults of a servo bus; lists are of servos' ids. `unplug`: the adapter is out, the servos go on.

    `silent`: they obey but say nothing. `other_baud`: they hear nothing. `unpowered`: without supply, and as after
    switching on when that ends; `brown_out`: all of them. `overload`, `hot`: what they report, and switch off for.
    `wrong_model`: they are no AX-12A. `duplicate`: another servo answers to the same id. `babbling`: something on the
    line talks all the time. `echo`: the adapter hands back what it is given.
    Of answers, `drop`: none comes; `bit_flip`: a bit is wrong; `garbage`, `stray`: noise, or a packet nobody asked for,
    comes before; `half`: it ends early; `pieces`: with a pause in it; `late`: 12 ms later.
    """

    silent: ServoIds = ()
    other_baud: ServoIds = ()
    unpowered: ServoIds = ()
    overload: ServoIds = ()
    hot: ServoIds = ()
    wrong_model: ServoIds = ()
    duplicate: ServoIds = ()
    brown_out: bool = False
    babbling: bool = False
    echo: bool = False
    drop: Probability = 0.0
    bit_flip: Probability = 0.0
    garbage: Probability = 0.0
    stray: Probability = 0.0
    half: Probability = 0.0
    pieces: Probability = 0.0
    late: Probability = 0.0


class Uxa90Faults(Faults, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Faults of a UXA-90's serial line; lists are of servos' ids. `unplug`: the cable is out, the robot goes on.

    `silent`: all obey but nothing is said. `no_replies`: the main board answers, servos do not. `stop_reading`: bytes pile
    up in the port. `brown_out`: without supply, and as after switching on when that ends. `kills_pc`: PC control is lost
    half a second after it was taken. `babble`: something on the line talks all the time. `late_s`: answers come that much
    later. `dead`: servos that are not there; `stuck`: that turn no more, though driven; `frozen`: positions and loads are
    reported as they were. Of servos' answers, `missing`: none comes; `garbage`: other bytes come instead; `shifted`: a
    byte comes before. `bit_flip`: a bit of an answer is wrong.
    """

    silent: bool = False
    no_replies: bool = False
    stop_reading: bool = False
    brown_out: bool = False
    kills_pc: bool = False
    babble: bool = False
    frozen: bool = False
    late_s: Annotated[float, Meta(ge=0.0, le=10.0, description="seconds")] = 0.0
    dead: ServoIds = ()
    stuck: ServoIds = ()
    missing: Probability = 0.0
    garbage: Probability = 0.0
    shifted: Probability = 0.0
    bit_flip: Probability = 0.0


def changed(faults: F, name: str, value: FaultValue) -> F:
    """Return the faults with one of them set; `replug` undoes `unplug`; raise InputError saying what is allowed.

    A list may be one string with commas or a single number, a number may be a string too, true is 1 where a number is
    meant, and null puts a fault back to its default.
    """
    if name == "replug":
        name, value = "unplug", not (True if value is None else value)
    known = faults.__struct_fields__
    if name not in known:
        raise InputError(f"no fault '{name}'; allowed here: {', '.join((*known, 'replug'))}")
    fields: dict[str, Any] = msgspec.structs.asdict(faults)
    if isinstance(fields[name], tuple) and isinstance(value, bool):
        raise InputError(f"fault '{name}' strikes one or several: name them after it, with commas between")
    if value is None:
        del fields[name]
    elif isinstance(fields[name], tuple) and isinstance(value, str):
        fields[name] = [part.strip() for part in value.split(",") if part.strip()]
    elif isinstance(fields[name], tuple) and isinstance(value, float) and value.is_integer():
        fields[name] = [int(value)]
    elif isinstance(fields[name], float) and isinstance(value, bool):
        fields[name] = float(value)
    else:
        fields[name] = value
    try:
        return msgspec.convert(fields, type(faults), strict=not isinstance(value, str | tuple | list))
    except msgspec.ValidationError as err:
        raise InputError(f"fault '{name}': {err}") from err
