"""Messages on `power/*` and `ups/*`: the source of power, and shutting down before it is empty."""

from typing import Annotated, Literal

from msgspec import Meta, Struct
from msgspec.structs import force_setattr

from lbr.messages.plain import one_line
from lbr.messages.units import Fraction

Supply = Literal["external", "battery"]
Volts = Annotated[float, Meta(gt=0.0, le=100.0, description="volts")]
PowerPhase = Literal["disarmed", "watching", "warning", "countdown", "parking", "powering_off", "off", "failed"]


class UpsState(Struct, frozen=True, kw_only=True):
    """The readings of an uninterruptible power supply; null is not measured. `valid` false: it does not answer or
    hangs.

    `external_v` is what feeds the robot, `battery_v` the supply's own battery, `output_v` what it gives the computer.
    `relay` is whether the motors' power is switched on. `emulated`: it is read from a socket and is no hardware, so
    that nothing it says is a reason to power a computer off.
    """

    valid: bool
    reason: str = ""
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
    """Watch the voltage and shut the computer down in time, or do so no more; kept over restarts. Null: as it was."""

    armed: bool
    warn_v: Volts | None = None
    shutdown_v: Volts | None = None


class CancelCommand(Struct, frozen=True, kw_only=True):
    """Let the countdown that runs come to nothing; it starts over only after the voltage was good again."""

    reason: Annotated[str, Meta(max_length=200)] = ""

    def __post_init__(self) -> None:
        """Have the reason be one line, also from a foreign client."""
        force_setattr(self, "reason", one_line(self.reason))


class PowerState(Struct, frozen=True, kw_only=True):
    """Where the power comes from, and how the file-safe shutdown stands; `reason` says why, in words for people.

    `remaining_s` counts down to the shutdown. `can_power_off` is what the system said when asked; empty: not asked yet.
    """

    phase: PowerPhase
    armed: bool
    warn_v: float
    shutdown_v: float
    reason: str = ""
    remaining_s: float | None = None
    can_power_off: str = ""
    ups: UpsState | None = None
