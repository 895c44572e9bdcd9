"""Messages on `power/*` and `ups/*`: the source of power, and the shutdown before it is empty."""

from typing import Annotated, Literal

from msgspec import Meta, Struct
from msgspec.structs import force_setattr

from lbr.messages.codes import ReasonCode
from lbr.messages.plain import one_line
from lbr.messages.units import Fraction

Supply = Literal["external", "battery"]
Volts = Annotated[float, Meta(gt=0.0, le=100.0, description="volts")]
PowerPhase = Literal["disarmed", "watching", "warning", "countdown", "parking", "powering_off", "off", "failed"]


class UpsState(Struct, frozen=True, kw_only=True):
    """The readings of an uninterruptible power supply; null is not measured. `valid` false: it does not answer or
    hangs.

    `external_v`: what feeds the robot. `battery_v`: the supply's own battery. `output_v`: to the computer. `relay`: the
    motors have power. `emulated`: read from a socket, not from hardware; it never powers a computer off.
    """

    valid: bool
    reason: str = ""
    code: ReasonCode = ""
    source: Supply | None = None
    external_v: float | None = None
    battery_v: float | None = None
    output_v: float | None = None
    charge: Fraction | None = None
    charging: bool | None = None
    temperature_c: float | None = None
    relay: bool | None = None
    firmware: str = ""
    emulated: bool = False


class RelayCommand(Struct, frozen=True, kw_only=True):
    """Switch the motors' power."""

    on: bool


class ArmCommand(Struct, frozen=True, kw_only=True):
    """Watch the voltage and shut the computer down in time, or not; kept over restarts. Null: unchanged."""

    armed: bool
    warn_v: Volts | None = None
    shutdown_v: Volts | None = None


class CancelCommand(Struct, frozen=True, kw_only=True):
    """Cancel the countdown; it starts again only after a good voltage."""

    reason: Annotated[str, Meta(max_length=200)] = ""

    def __post_init__(self) -> None:
        """Turn the reason into one line, as a foreign client may have sent it."""
        force_setattr(self, "reason", one_line(self.reason))


class PowerState(Struct, frozen=True, kw_only=True):
    """The source of the power, and the state of the file-safe shutdown, with its `reason`.

    `remaining_s`: to the shutdown. `can_power_off`: the system's answer; empty: not asked yet.
    """

    phase: PowerPhase
    armed: bool
    warn_v: float
    shutdown_v: float
    reason: str = ""
    code: ReasonCode = ""
    remaining_s: float | None = None
    can_power_off: str = ""
    ups: UpsState | None = None
