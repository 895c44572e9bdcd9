"""Drive operations broken on purpose: a stream that went on through an emergency stop moves the robot after the reset."""

import dataclasses

from lbr.leases import rules
from lbr.operations import drive
from lbr.operations.drive.capability import Drive


class ForgetfulDrive(Drive):
    def open(self) -> None:
        rules.persists = lambda _ask: ""
        super().open()


KIND = dataclasses.replace(drive.KIND, name="forgetful_drive", entry=ForgetfulDrive)
