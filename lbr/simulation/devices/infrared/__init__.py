"""The emulated infrared receiver: the settings of its device rows, its faults, and its twin."""

from typing import Annotated

from msgspec import Meta, Struct

from lbr.capability.twins import DeviceTwin
from lbr.simulation.faults import Faults, Probability
from lbr.simulation.measured import Beam

Scancode = (
    Annotated[int, Meta(ge=1, lt=2**32)]
    | Annotated[
        str, Meta(pattern="^0[xX][0-9a-fA-F]{1,8}$(?!\\n)", description="the same in hexadecimal, such as 0x400021")
    ]
)


class InfraredFaults(Faults, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Faults of an infrared receiver. `stray`: another remote's code in between. `stuck`: always the left beam."""

    silent: bool = False
    garbage: Probability = 0.0
    half: Probability = 0.0
    stray: Probability = 0.0
    stuck: bool = False


class BeamCodes(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The scancode of each beam of the dock, as a number or in hexadecimal; null: there is no such beam."""

    left: Scancode | None = "0x400021"
    right: Scancode | None = "0x400022"
    power: Scancode | None = "0x400024"

    def numbers(self) -> dict[Beam, int]:
        """Return the codes as numbers."""
        given: dict[Beam, Scancode | None] = {"left": self.left, "right": self.right, "power": self.power}
        return {beam: int(code, 16) if isinstance(code, str) else code for beam, code in given.items() if code}


class InfraredRow(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The beams at an `infrared` device row's receiver; `protocol` is the kernel's number, 7 for Sony-15."""

    faults: InfraredFaults = InfraredFaults()
    codes: BeamCodes = BeamCodes()
    protocol: Annotated[int, Meta(ge=0, le=63)] = 7


TWIN = DeviceTwin(device="infrared", row=InfraredRow, entry="lbr.simulation.devices.infrared.twin:InfraredTwin")
