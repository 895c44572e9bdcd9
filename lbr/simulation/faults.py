"""Faults of an emulated device: in its row's setting `faults`, and changed while it runs."""

from typing import Annotated, Any, TypeVar

import msgspec
from msgspec import Meta, Struct

from lbr.capability.choices import with_choices
from lbr.errors import InputError

Probability = Annotated[float, Meta(ge=0.0, le=1.0, description="how often it happens, 0 never, 1 always")]
FaultValue = bool | float | str | tuple[str, ...] | None
ServoIds = tuple[Annotated[int, Meta(ge=0, le=253, description="a servo's number on its bus")], ...]

F = TypeVar("F", bound="Faults")


class Faults(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Faults of any device: `unplug`, its cable is out."""

    unplug: bool = False


class LineFaults(Faults, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Faults of a device on a line. `drop`: a reply is lost. `refuse`: a command is answered `-` and ignored. After a
    `brown_out`, unsaved state is gone."""

    silent: bool = False
    drop: Probability = 0.0
    bit_flip: Probability = 0.0
    garbage: Probability = 0.0
    refuse: Probability = 0.0
    stop_reading: bool = False
    brown_out: bool = False


class I2cFaults(Faults, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Faults of a device on an i2c bus. `unplug`: the bus is gone; `silent`: it hangs. `nak`: a transaction is not
    acknowledged. `all_ones`: every read is 0xFF.
    """

    silent: bool = False
    nak: Probability = 0.0
    half: Probability = 0.0
    all_ones: bool = False
    brown_out: bool = False


class ServoBusFaults(Faults, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Faults of any servo bus; lists are of servos' ids. `unplug`: the adapter is out, the servos go on.

    `other_baud`: they understand nothing. `unpowered`: no supply, then a restart; `brown_out`: all of them. `overload`,
    `hot`: they report it and switch off. `wrong_model`: another make. `duplicate`: two servos with that id. `babbling`:
    bytes all the time. `echo`: the adapter repeats its input. `drop`: no answer; `late`: by 12 ms.
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
    half: Probability = 0.0
    late: Probability = 0.0


def changed(faults: F, name: str, value: FaultValue) -> F:
    """Return the faults with one of them set; `replug` undoes `unplug`; raise InputError with the permitted values.

    A list may be one string with commas or a single number, and a number may be a string. True is 1 for a number, and
    null resets a fault to its default.
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
        kinds = {field.name: field.type for field in msgspec.structs.fields(type(faults))}
        raise InputError(f"fault '{name}': {with_choices(str(err), kinds[name])}") from err
