"""Answers as a mover gives them, for fakes of one."""

from lbr.messages.codes import Code, Reason
from lbr.messages.leases import CommandReply, refused


def dead(how: str, cause: Code) -> CommandReply:
    """Return the refusal of a lease that ended so."""
    return refused(Reason("dead_lease", f"lease is dead: {how}", cause=cause, note=how))


def refusal(reason: str | Reason, code: Code = "refused") -> CommandReply:
    """Return what a call that is refused answers."""
    return refused(reason if isinstance(reason, Reason) else Reason(code, reason))
