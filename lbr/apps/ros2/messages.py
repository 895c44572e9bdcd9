"""Messages on `ros2/*`: how it stands with ROS."""

from msgspec import Struct

from lbr.messages.codes import ReasonCode


class Ros2State(Struct, frozen=True, kw_only=True):
    """The connection to ROS, the topics with subscribers there, and the node that drives the robot.

    `reason` and `code` are why nothing moves by it, `refused` counts what was not done, `nodes` those that are there.
    """

    connected: bool
    endpoint: str
    nodes: int = 0
    subscribed: tuple[str, ...] = ()
    driver: str = ""
    connections: int = 0
    refused: int = 0
    reason: str = ""
    code: ReasonCode = ""
