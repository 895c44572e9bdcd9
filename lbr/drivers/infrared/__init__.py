"""An infrared receiver of the kernel that receives a dock's beams: its kind and its settings."""

from functools import reduce
from operator import or_
from typing import Annotated, Literal

from msgspec import Meta, Struct

from lbr.capability.kind import Kind, OnDevice, Wire
from lbr.messages.dock import DockHeard, DockSignal
from lbr.messages.drive import DriveState
from lbr.messages.units import Name

Beam = Literal["left", "right", "power"]
BEAMS: tuple[Beam, ...] = ("left", "right", "power")
SONY_BITS = {6: 0x1F007F, 7: 0xFF007F, 8: 0x1FFF7F}
"""The bits of a scancode that Sony-12, -15 and -20 use, by protocol number, as the kernel's decoder assembles them."""
Code = (
    Annotated[int, Meta(ge=1, lt=2**32)]
    | Annotated[
        str, Meta(pattern="^0[xX][0-9a-fA-F]{1,8}$(?!\\n)", description="the same in hexadecimal, such as 0x400021")
    ]
)


class Codes(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The scancode of each beam, as a number or in hexadecimal; null: no such beam.

    The defaults only show the form of Sony-15: the kernel puts the device into bits 16 to 23, the command into 0 to 6.
    `ir-keytable -t` shows your dock's.
    """

    left: Code | None = "0x400021"
    right: Code | None = "0x400022"
    power: Code | None = "0x400024"


class InfraredSettings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Settings of a row of kind `infrared`.

    `protocols`: the kernel's numbers (`enum rc_proto`) that are accepted; empty: any. `records`: `scancodes` as from
    /dev/lirc0, `events` as from /dev/input/event0; `auto`: by the address.
    """

    device: Name
    codes: Codes = Codes()
    protocols: Annotated[tuple[Annotated[int, Meta(ge=0, le=63)], ...], Meta(max_length=64)] = ()
    records: Literal["auto", "scancodes", "events"] = "auto"
    ttl_s: Annotated[float, Meta(ge=0.2, le=10.0, description="how long a seen beam counts")] = 1.5

    def __post_init__(self) -> None:
        """Refuse codes that two beams share or that no remote sends."""
        numbers = [*self._numbers().values()]
        if len(set(numbers)) < len(numbers):
            raise ValueError("codes: two beams have the same code; give each its own")
        if 0 in numbers:
            raise ValueError("codes: 0 is no code of a beam")
        if self.protocols and set(self.protocols) <= set(SONY_BITS):
            bits = reduce(or_, (SONY_BITS[number] for number in self.protocols))
            if wrong := [f"{number:#x} (as {number & bits:#x})" for number in numbers if number & ~bits]:
                text = "no code of a Sony remote comes like that: its device is in bits 16 to 23, its command in 0 to 6"
                raise ValueError(f"codes: {', '.join(wrong)}: {text}; `ir-keytable -t` shows them")

    @property
    def beams(self) -> dict[int, Beam]:
        """Return the beam of each scancode."""
        return {code: beam for beam, code in self._numbers().items()}

    def _numbers(self) -> dict[Beam, int]:
        given: dict[Beam, Code | None] = {beam: getattr(self.codes, beam) for beam in BEAMS}
        return {beam: _number(code) for beam, code in given.items() if code is not None}


def _number(code: Code) -> int:
    return int(code, 16) if isinstance(code, str) else code


KIND = Kind(
    name="infrared",
    summary="the infrared beams of a charging dock, by the kernel's remote control input",
    family="driver",
    entry="lbr.drivers.infrared.capability:Infrared",
    settings=InfraredSettings,
    inputs={"drive": DriveState},
    optional=("drive",),
    wires={"drive": Wire("drive.state")},
    outputs={"signal": DockSignal},
    commands={"heard": DockHeard},
    device=OnDevice("infrared", recognised="lbr.drivers.infrared.recognition:HANDSHAKE"),
)
