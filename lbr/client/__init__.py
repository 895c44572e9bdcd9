"""A program's connection to a robot: to look, to send lines, to borrow motion. A program that hangs moves nothing.

    from lbr import client                    # in the distribution lbr-client: import lbr_client as client

    with client.connect() as robot:           # the one that runs here; connect(at="tls/192.168.1.7:7447") elsewhere
        robot.do.t(90)                        # each word of the robot, as robot.say("/t/90"): returns when it is over
        with robot.drive(0.2):                # kept for us meanwhile, for 5 s at most, and released
            time.sleep(2)
        with robot.borrow("drive/command", power=0.2, angle_deg=0) as motion:
            while robot.latest("ranges/readings")["forward_m"] > 1.0:
                motion.keep()                 # ten times a second; what is not kept stops within the life of its lease
                time.sleep(0.05)

`aio` has the same for a program with an event loop, `notebook` draws in Jupyter; both are imported by their names. The
lease of a program that is killed or frozen expires, and the robot stops by itself.
"""

from lbr.client.finding import Found, find
from lbr.client.motion import KeptMotion, Message, Motion, RefusalError
from lbr.client.robot import LineResult, Picture, Robot, connect
from lbr.client.words import Word, Words
from lbr.errors import BusError, InputError, LbrError

__all__ = [
    "BusError",
    "Found",
    "InputError",
    "KeptMotion",
    "LbrError",
    "LineResult",
    "Message",
    "Motion",
    "Picture",
    "RefusalError",
    "Robot",
    "Word",
    "Words",
    "connect",
    "find",
]
