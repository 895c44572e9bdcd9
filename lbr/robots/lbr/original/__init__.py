"""The HTTP API of the robot lbr's first program, unchanged for its clients, state machines and scripts.

`wishes` parses requests and `package` makes the telemetry, both without a robot. `driving` moves the base for one
client at a time, and stops it when that client falls silent.
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
