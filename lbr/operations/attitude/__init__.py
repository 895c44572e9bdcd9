"""Attitude: from samples of an inertial unit to orientation and heading, and the compass's calibration."""

from lbr.capability.kind import Kind, Rows
from lbr.capability.word import Word
from lbr.messages.attitude import AttitudeState, CalibrateCommand, CalibrationProgress, ObserveCommand
from lbr.messages.calibration import CalibrationValue
from lbr.messages.drive import DriveCommand, DriveState
from lbr.messages.imu import ImuSample
from lbr.messages.leases import StopCommand
from lbr.operations.attitude.settings import AttitudeSettings

KIND = Kind(
    name="attitude",
    summary="orientation and heading from an inertial unit, and the calibration of its compass",
    family="operation",
    entry="lbr.operations.attitude.capability:Attitude",
    settings=AttitudeSettings,
    inputs={"samples": ImuSample, "drive": DriveState},
    optional=("drive",),
    outputs={"state": AttitudeState, "calibration": CalibrationProgress},
    commands={"calibrate": CalibrateCommand, "observe": ObserveCommand, "stop": StopCommand},
    requests={"motion": DriveCommand, "halt": StopCommand},
    rows=(Rows(CalibrationValue, where={"device": "device"}, learnt=True),),
    words=(
        Word(
            "/a/{angle_deg}",
            "observe",
            "Report when the robot has turned by an angle, -360 to 360 degrees, clockwise positive; moves nothing",
        ),
        Word("/m/{samples}", "calibrate", "Calibrate the compass while turning on the spot, such as /m/300; s ends it"),
        Word(
            "/m/{samples}/{source}",
            "calibrate",
            "The same: - turns, -c turns and draws the compass, a name is a file of samples in $LBR_HOME/calibration",
        ),
    ),
)
