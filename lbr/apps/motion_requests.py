"""The requests by which components move a robot: the message of each, and the port that it goes to."""

from collections.abc import Mapping
from typing import NamedTuple

from msgspec import Struct

from lbr.capability.kind import Wire
from lbr.messages.beacon import SeekCommand
from lbr.messages.drive import DriveCommand, HeadingCommand, TurnCommand, TwistCommand
from lbr.messages.joints import JointsCommand, PlayCommand
from lbr.messages.leases import CommandReply, StopCommand

_KNOWN: Mapping[str, tuple[type[Struct], str]] = {
    "twist": (TwistCommand, "drive.twist"),
    "move": (DriveCommand, "drive.command"),
    "turn": (TurnCommand, "drive.turn"),
    "heading": (HeadingCommand, "drive.heading"),
    "halt": (StopCommand, "drive.stop"),
    "joints_move": (JointsCommand, "joints.command"),
    "joints_halt": (StopCommand, "joints.stop"),
    "play": (PlayCommand, "motions.play"),
    "play_halt": (StopCommand, "motions.stop"),
    "seek": (SeekCommand, "beacon.seek"),
    "seek_halt": (StopCommand, "beacon.stop"),
    "stop_all": (StopCommand, "stop"),
}


class MotionRequests(NamedTuple):
    """Some of these requests, as a kind declares them."""

    requests: dict[str, type[Struct]]
    replies: dict[str, type[Struct]]
    wires: dict[str, Wire]


def motion_requests(*names: str) -> MotionRequests:
    """Return the requests of these names."""
    chosen = {name: _KNOWN[name] for name in names}
    return MotionRequests(
        requests={name: message for name, (message, _) in chosen.items()},
        replies=dict.fromkeys(names, CommandReply),
        wires={name: Wire(port) for name, (_, port) in chosen.items()},
    )
