"""Recognition of a board of range sensors by a line of its distances; the Arduino gets a start byte, and then a stop
byte."""

from lbr.capability.recognition import Seen, SerialHandshake
from lbr.drivers.ultrasonic import Board
from lbr.drivers.ultrasonic.protocol import FINISH, START, TICKS_PER_S, Frame, LineParser

LONGEST_CYCLE_S = 10.0


def seen(stream: bytes) -> Seen | None:
    """Return the board of these distances; the cycle time, in the board's own ticks, distinguishes the two."""
    for frame in LineParser().feed(stream):
        if isinstance(frame, Frame):
            board: Board = "arduino" if frame.deltat < LONGEST_CYCLE_S * TICKS_PER_S["arduino"] else "parallax"
            return Seen(what=f"ring of ultrasonic sensors, board {board}", settings={"board": board})
    return None


HANDSHAKES = (
    SerialHandshake(baud=115_200, listen_s=0.25, seen=seen),
    SerialHandshake(baud=115_200, questions=(START,), listen_s=0.25, leave=FINISH, seen=seen),
)
