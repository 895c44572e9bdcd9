"""Attitude: from samples of an inertial unit to orientation and heading, and the compass's calibration."""

from lbr.capability.kind import Kind, Rows
from lbr.messages.attitude import AttitudeState, CalibrateCommand, CalibrationProgress, ObserveCommand
from lbr.messages.calibration import CalibrationValue
from lbr.messages.drive import DriveCommand
from lbr.messages.imu import ImuSample
from lbr.messages.leases import CommandReply, StopCommand
from lbr.operations.attitude.settings import AttitudeSettings

KIND = Kind(
    name="attitude",
    summary="orientation and heading from an inertial unit, and the calibration of its compass",
    family="operation",
    entry="lbr.operations.attitude.capability:Attitude",
    settings=AttitudeSettings,
    inputs={"samples": ImuSample},
    outputs={"state": AttitudeState, "calibration": CalibrationProgress},
    commands={"calibrate": CalibrateCommand, "observe": ObserveCommand, "stop": StopCommand},
    replies={
        "calibrate": CommandReply,
        "observe": CommandReply,
        "stop": CommandReply,
        "motion": CommandReply,
        "halt": CommandReply,
    },
    requests={"motion": DriveCommand, "halt": StopCommand},
    rows=(Rows(CalibrationValue, where={"device": "device"}),),
    learns=(CalibrationValue,),
)
