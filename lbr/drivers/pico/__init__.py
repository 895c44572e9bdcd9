"""UPS PIco HV3.0, an uninterruptible supply for the Raspberry Pi on i2c: its kind and its settings."""

from typing import Annotated, Literal

from msgspec import Meta, Struct

from lbr.capability.kind import Kind, OnDevice
from lbr.capability.word import Word
from lbr.messages.power import RelayCommand, UpsState
from lbr.messages.units import Name

Chemistry = Literal["auto", "lipo", "lifepo4"]
Sensor = Literal["to92", "ntc"]


class PicoSettings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Settings of a row of kind `pico`.

    `relay_on`: the relay's register while the motors have power, by the wiring. `still_alive_s`: the supply resets the
    computer when this driver has not fed it for so long; 0: never.
    """

    device: Name
    pace_s: Annotated[float, Meta(ge=0.01, le=1.0, description="between two registers; about a tenth of a sweep")] = 0.1
    retries: Annotated[int, Meta(ge=0, le=20, description="how often a failed register is read again")] = 3
    most_errors: Annotated[int, Meta(ge=1, le=100, description="failed exchanges in a row before it is reopened")] = 8
    chemistry: Annotated[Chemistry, Meta(description="of its own battery; auto: as it reports")] = "auto"
    temperature_sensor: Annotated[Sensor, Meta(description="on the board (ntc), or plugged in (to92)")] = "to92"
    relay_on: Literal[0, 1] = 1
    still_alive_s: Annotated[int, Meta(ge=0, le=254)] = 0

    def __post_init__(self) -> None:
        """Refuse a time too short to be kept up over a restart of the driver."""
        if 0 < self.still_alive_s < 20:
            raise ValueError("still_alive_s: 0 for off, or at least 20, so that a restart of the driver resets nothing")


KIND = Kind(
    name="pico",
    summary="UPS PIco uninterruptible power supply, on i2c",
    family="driver",
    entry="lbr.drivers.pico.capability:Pico",
    settings=PicoSettings,
    outputs={"state": UpsState},
    commands={"relay": RelayCommand},
    device=OnDevice("pico", emulated="socket", recognised="lbr.drivers.pico.recognition:HANDSHAKE"),
    words=(
        Word("/relay/on", "relay", "Switch the power of the motors on", {"on": True}, role="admin"),
        Word(
            "/relay/off",
            "relay",
            "Cut the power of the motors: a robot that stands falls unless it is held",
            {"on": False},
            role="admin",
        ),
    ),
)
