"""Recognition of a board of range sensors: by a line of its distances; the Arduino is asked to begin, and to stop
again."""

from lbr.capability.recognition import Seen, SerialHandshake
from lbr.drivers.ultrasonic import Board
from lbr.drivers.ultrasonic.protocol import FINISH, START, TICKS_PER_S, Frame, LineParser

LONGEST_CYCLE_S = 10.0


def seen(heard: bytes) -> Seen | None:
    """Return the board whose distances these are; which it is, the time of a cycle says, which each counts in its own
    ticks."""
    for frame in LineParser().feed(heard):
        if isinstance(frame, Frame):
            board: Board = "arduino" if frame.deltat < LONGEST_CYCLE_S * TICKS_PER_S["arduino"] else "parallax"
            return Seen(what=f"ring of ultrasonic sensors, board {board}", settings={"board": board})
    return None


HANDSHAKES = (
    SerialHandshake(baud=115_200, listen_s=0.25, seen=seen),
    SerialHandshake(baud=115_200, questions=(START,), listen_s=0.25, leave=FINISH, seen=seen),
)
