"""Power: watches the supply, and shuts the computer down file-safe before it fails."""

from typing import Annotated

from msgspec import Meta, Struct

from lbr.capability.kind import Command, Kind, Rows
from lbr.capability.word import Word
from lbr.messages.calibration import CalibrationValue
from lbr.messages.drive import GoalResult
from lbr.messages.joints import PlayCommand, TorqueCommand
from lbr.messages.leases import StopCommand
from lbr.messages.power import ArmCommand, CancelCommand, PowerState, UpsState, Volts
from lbr.messages.speech import SayCommand
from lbr.messages.units import Name

Seconds = Annotated[float, Meta(ge=0.0, le=3600.0, description="seconds")]
Deadline = Annotated[float, Meta(gt=0.0, le=600.0, description="seconds")]


class PowerSettings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Settings of a row of kind `power`; the defaults are a lithium-polymer battery of three cells.

    `device`: the supply whose row stores whether it is armed, and its thresholds; `armed`, `warn_v` and `shutdown_v`
    apply until then. Low: below for `hold_s` and `hold_samples` readings; good again: `hysteresis_v` more. Below
    `absent_v` the external supply counts as disconnected, if the supply's own battery backs it (`battery_backs`); then
    `battery_warn_v` and `battery_shutdown_v` apply.

    Before the shutdown it plays `park_motion` (empty: none) for at most `park_s` and releases the joints within
    `let_go_s`, in any case. `bus`: the D-Bus of logind; empty: the system's.
    """

    device: Name
    armed: bool = False
    warn_v: Volts = 10.5
    shutdown_v: Volts = 9.9
    hysteresis_v: Annotated[float, Meta(ge=0.0, le=5.0)] = 0.3
    hold_s: Seconds = 2.0
    hold_samples: Annotated[int, Meta(ge=1, le=1000)] = 3
    countdown_s: Seconds = 10.0
    stale_s: Annotated[Deadline, Meta(description="a supply without readings is silent")] = 5.0
    battery_backs: bool = True
    absent_v: Annotated[float, Meta(ge=0.0, le=50.0)] = 2.0
    battery_warn_v: Volts = 3.7
    battery_shutdown_v: Volts = 3.55
    battery_hysteresis_v: Annotated[float, Meta(ge=0.0, le=5.0)] = 0.1
    park_motion: str = "sit"
    park_s: Deadline = 15.0
    let_go_s: Deadline = 2.0
    answer_s: Annotated[Deadline, Meta(description="for which logind is waited")] = 10.0
    off_s: Annotated[Deadline, Meta(description="until the computer is off, once logind agreed")] = 120.0
    retry_s: Annotated[Deadline, Meta(description="from one refused shutdown to the next try")] = 30.0
    repeat_s: Annotated[Seconds, Meta(description="between two warnings of one kind")] = 60.0
    bus: str = ""

    def __post_init__(self) -> None:
        """Refuse thresholds in the wrong order."""
        if not self.shutdown_v <= self.warn_v:
            raise ValueError("shutdown_v: must not be above warn_v")
        if not self.battery_shutdown_v <= self.battery_warn_v:
            raise ValueError("battery_shutdown_v: must not be above battery_warn_v")
        if not self.absent_v < self.shutdown_v:
            raise ValueError("absent_v: must be below shutdown_v, or a low supply would be none")


KIND = Kind(
    name="power",
    summary="power state, and a shutdown of the computer in time",
    family="operation",
    entry="lbr.operations.power.capability:Power",
    settings=PowerSettings,
    inputs={"ups": UpsState, "parked": GoalResult},
    outputs={"state": PowerState},
    commands={
        "arm": Command(ArmCommand, role="admin"),
        "cancel": CancelCommand,
    },
    requests={"park": PlayCommand, "halt": StopCommand, "let_go": TorqueCommand, "say": SayCommand},
    rows=(Rows(CalibrationValue, where={"device": "device"}, learnt=True),),
    words=(
        Word(
            "arm",
            "arm",
            "Watch the voltage from now on, and shut the computer down in time; kept over restarts",
            {"armed": True},
        ),
        Word(
            "/arm/{warn_v}/{shutdown_v}",
            "arm",
            "As arm, with a warning below the first and a shutdown below the second, in volts",
            {"armed": True},
        ),
        Word("disarm", "arm", "Only report the voltage, and shut nothing down", {"armed": False}),
        Word("cancel", "cancel", "Cancel the countdown to the shutdown, until the voltage is low again"),
    ),
)
