"""The requests by which components move a robot, with their messages and ports, and adopt a console line's motion."""

from collections.abc import Mapping
from typing import NamedTuple

from msgspec import Struct

from lbr.capability.context import Context
from lbr.capability.kind import Wire
from lbr.leases.client import LeaseTarget
from lbr.leases.holder import GONE, RESULT_S, Holder
from lbr.messages.beacon import SeekCommand
from lbr.messages.drive import DriveCommand, HeadingCommand, TurnCommand, TwistCommand
from lbr.messages.joints import JointsCommand, PlayCommand
from lbr.messages.leases import CommandReply, StopCommand
from lbr.messages.system import Hold

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
_COMMANDS = {
    "command": ("move", "halt", "drive"),
    "turn": ("turn", "halt", "drive"),
    "heading": ("heading", "halt", "drive"),
    "twist": ("twist", "halt", "drive"),
    "play": ("play", "play_halt", "motions"),
    "seek": ("seek", "seek_halt", "beacon"),
}
"""The requests that renew and halt a command's motion, and the kind of its mover."""


class MotionRequests(NamedTuple):
    """Some of these requests, in the form of a kind's declaration."""

    requests: dict[str, type[Struct]]
    wires: dict[str, Wire]


def motion_requests(*names: str) -> MotionRequests:
    """Return the requests of these names."""
    chosen = {name: _KNOWN[name] for name in names}
    return MotionRequests(
        requests={name: message for name, (message, _) in chosen.items()},
        wires={name: Wire(port) for name, (_, port) in chosen.items()},
    )


def target_of(ctx: Context[Struct], hold: Hold) -> LeaseTarget | None:
    """Return the target that renews a console line's motion; None if this capability is not wired to its mover."""
    capability, command = hold.key.split("/")[-2:]
    motion, halt, kind = _COMMANDS.get(command, ("", "", ""))
    if capability not in (ctx.targets(motion) if motion else ()):
        return None
    return LeaseTarget(motion, halt, kind, f"{kind}: {GONE}", result_s=RESULT_S)


def adopt(holder: Holder, target: LeaseTarget, hold: Hold) -> None:
    """Let a holder continue a console line's motion."""
    given = CommandReply(accepted=True, lease=hold.lease, ttl_s=hold.ttl_s, goal=hold.goal)
    payload = {name: value for name, value in hold.payload.items() if name != "lease"}
    holder.begin(target, payload, given=given)
