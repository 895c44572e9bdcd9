"""Answers and states as a mover gives them, for fakes of one."""

from typing import Any

from lbr.messages.codes import Code, Reason
from lbr.messages.drive import DriveState
from lbr.messages.leases import CommandReply, refused


def dead(how: str, cause: Code) -> CommandReply:
    """Return the refusal of a lease that ended so."""
    return refused(Reason("dead_lease", f"lease is dead: {how}", cause=cause, note=how))


def refusal(reason: str | Reason, code: Code = "refused") -> CommandReply:
    """Return what a call that is refused answers."""
    return refused(reason if isinstance(reason, Reason) else Reason(code, reason))


def drive_state(**given: Any) -> DriveState:
    """Return the state of a base that stands, but for what is given."""
    stands = {"moving": False, "power": 0.0, "angle_deg": 0.0, "left": 0.0, "right": 0.0, "holder": None, "goal": None}
    return DriveState(**{**stands, "limited_by": "", "reason": "", "estop": False, "loop": None, **given})
