"""Messages on `attitude/*`: the orientation of the robot's body, and the calibration of its compass."""

from typing import Annotated, Literal

from msgspec import Meta, Struct

from lbr.messages.codes import ReasonCode
from lbr.messages.units import Quaternion, TurnDeg, Vector


class AttitudeState(Struct, frozen=True, kw_only=True):
    """The orientation of the robot's body (REP 103: x ahead, y left, z up; yaw anticlockwise from east).

    `heading_deg`: clockwise from true north; null for `heading_reason`, whose code is `code`. Then `yaw_rad` is null,
    and yaw in `orientation` (w, x, y, z, body to world) continues by gyro. `turned_deg`: the turn since `epoch`
    began, clockwise, past 360, without jumps; another `epoch` starts over. `gyro_bias_rps`: along the body's axes.
    `magnetic`: the magnetometer is used now. `calibrated`: it was ever calibrated. `still`: the body does not turn.
    `rests`: it, or its base, also stands; published twice a second. `measured_s`: monotonic time of its sample.
    """

    valid: bool
    epoch: str
    measured_s: float
    reason: str = ""
    code: ReasonCode = ""
    orientation: Quaternion | None = None
    roll_rad: float | None = None
    pitch_rad: float | None = None
    yaw_rad: float | None = None
    heading_deg: float | None = None
    heading_reason: str = ""
    turned_deg: float | None = None
    turn_rate_dps: float | None = None
    gyro_bias_rps: Vector | None = None
    still: bool = False
    magnetic: bool = False
    calibrated: bool = False
    rests: bool = False


class ObserveCommand(Struct, frozen=True, kw_only=True):
    """Publish an event when the body has turned this far; moves and stops nothing."""

    angle_deg: TurnDeg


class CalibrateCommand(Struct, frozen=True, kw_only=True):
    """Calibrate the magnetometer from `samples` measurements.

    `source`: `-` turns on the spot meanwhile; `-c` only draws the picture, as corrected now; else a file of samples
    below `$LBR_HOME/calibration`.
    """

    samples: Annotated[int, Meta(ge=1, le=2000, description="measurements of the magnetometer")]
    source: Annotated[str, Meta(max_length=200)] = "-"


class CalibrationProgress(Struct, frozen=True, kw_only=True):
    """Progress of a calibration: `coverage`: the part of a full turn seen. `picture`: an SVG file."""

    phase: Literal["collecting", "fitting", "done", "refused"]
    collected: int
    wanted: int
    coverage: float
    text: str = ""
    picture: str = ""
    residual: float | None = None
