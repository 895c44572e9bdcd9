"""Messages on `attitude/*`: how the robot lies and where it looks, and the calibration of its compass."""

from typing import Annotated, Literal

from msgspec import Meta, Struct

from lbr.messages.units import Quaternion, TurnDeg, Vector


class AttitudeState(Struct, frozen=True, kw_only=True):
    """Where the robot's body points (REP 103: x ahead, y left, z up; yaw anticlockwise from east).

    `heading_deg` is the compass's: 0 to 360, clockwise from true north; null while it is not known, and
    `heading_reason` says why. Then `yaw_rad` is null too, and the yaw within `orientation` (w, x, y, z, body to world)
    goes on by gyro from wherever it was. `turned_deg` counts how far the body has turned since `epoch` began, clockwise
    positive; it goes on past 360 and never jumps with the compass. Another `epoch` means that it started over.
    `gyro_bias_rps` is along the body's axes. `magnetic` says that the magnetometer is used now, `calibrated` that it
    was ever calibrated, `still` that the body does not turn. `measured_s` is when the newest sample in it was measured,
    by the monotonic clock.
    """

    valid: bool
    epoch: str
    measured_s: float
    reason: str = ""
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


class ObserveCommand(Struct, frozen=True, kw_only=True):
    """Tell, by an event, when the body has turned this far from now on; moves and stops nothing."""

    angle_deg: TurnDeg


class CalibrateCommand(Struct, frozen=True, kw_only=True):
    """Calibrate the magnetometer from `samples` measurements.

    `source` is `-`: turn on the spot meanwhile; `-c`: the same, corrected as it is now, and only draw the picture; or
    the name of a file of samples below `$LBR_HOME/calibration`.
    """

    samples: Annotated[int, Meta(ge=1, le=2000, description="measurements of the magnetometer")]
    source: Annotated[str, Meta(max_length=200)] = "-"


class CalibrationProgress(Struct, frozen=True, kw_only=True):
    """Progress of a calibration: `coverage` is the part of a full turn that was seen. `picture` is an SVG file."""

    phase: Literal["collecting", "fitting", "done", "refused"]
    collected: int
    wanted: int
    coverage: float
    text: str = ""
    picture: str = ""
    residual: float | None = None
