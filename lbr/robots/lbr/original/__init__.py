"""The HTTP API that the robot lbr has always had: its clients, state machines and scripts find it as they know it.

`wishes` reads what is asked and `package` says what is known, both without a robot; `driving` moves it for one client
at a time, and stops it when that client falls silent.
"""

from lbr.apps.web.ports import FacePorts
from lbr.messages.camera import CameraState, JpegFrame, SelectCommand
from lbr.messages.dock import DockHeard
from lbr.messages.drive import DriveCommand, HeadingCommand, TurnCommand
from lbr.messages.speech import SayCommand
from lbr.messages.telemetry import Telemetry

PORTS = FacePorts(
    inputs={"telemetry": Telemetry, "cameras": CameraState, "frames": JpegFrame},
    requests={
        "drive_command": DriveCommand,
        "drive_turn": TurnCommand,
        "drive_heading": HeadingCommand,
        "say": SayCommand,
        "select_camera": SelectCommand,
        "dock_heard": DockHeard,
    },
)
