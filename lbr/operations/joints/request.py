"""The content of a motion command, apart from its sender and lease; in the end always key frames."""

from math import radians

from msgspec import Struct
from msgspec.structs import replace

from lbr.messages.joints import JointMove, JointsCommand, KeyFrame
from lbr.operations.joints.body import Body


class JointsRequest(Struct, frozen=True, kw_only=True):
    """The motion itself. Each appended part has a new `token`."""

    command: JointsCommand
    token: str = ""


def of_move(move: JointMove) -> JointsCommand:
    """Return the command for a move in people's units."""
    return JointsCommand(
        positions={move.joint: radians(move.angle_deg)},
        speed_rps=radians(move.speed_dps),
        lease=move.lease,
        ttl_s=move.ttl_s,
        take_over=move.take_over,
    )


def asked(command: JointsCommand, token: str) -> JointsRequest:
    """Return the content of a command; `token` makes each appended part unique."""
    bare = replace(command, lease="", ttl_s=None, take_over=False, asked_s=None)
    return JointsRequest(command=bare, token=token if command.append else "")


def empty(command: JointsCommand) -> bool:
    """Return whether a command has nothing to move; with a lease it renews that."""
    return not (command.positions or command.frames or command.stored)


def named(command: JointsCommand, body: Body) -> tuple[str, ...]:
    """Return the joints that it moves in ways of its own, in the order of the rows; all of them must be known."""
    meant = command.positions.keys() | {name for frame in command.frames for name in frame.positions}
    joints = {body.partner(name) for name in meant} if command.mirror else meant
    return tuple(name for name in body.joints if name in joints)


def strengths(command: JointsCommand, body: Body) -> dict[str, float]:
    """Return the requested strengths of joints; the others keep theirs."""
    partner = body.partner if command.mirror else str
    own = {partner(name): strength for name, strength in command.torques.items()}
    return own if command.torque is None else dict.fromkeys(named(command, body), command.torque) | own


def frames(command: JointsCommand, body: Body, positions_s: float) -> tuple[KeyFrame, ...]:
    """Return the requested key frames, mirrored on request; positions become one frame of `positions_s`."""
    asked_for = command.frames or (KeyFrame(positions=command.positions, duration_s=positions_s),)
    if not command.mirror:
        return asked_for
    return tuple(replace(frame, positions=body.mirrored(frame.positions)) for frame in asked_for)
