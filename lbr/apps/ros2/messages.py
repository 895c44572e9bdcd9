"""Messages on `ros2/*`: the state of the connection to ROS."""

from msgspec import Struct

from lbr.messages.codes import ReasonCode


class Ros2State(Struct, frozen=True, kw_only=True):
    """The connection to ROS, the topics with subscribers there, and the node that drives the robot.

    `reason`, `code`: why nothing moves by it; `refused`: how often; `nodes`: those present.
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
