"""The robot's cameras as a face: a page, a stream, the newest picture; for clients with a token or signed in."""

from lbr.apps.web.ports import FacePorts
from lbr.messages.camera import CameraState, JpegFrame

PORTS = FacePorts(inputs={"cameras": CameraState, "frames": JpegFrame})
