"""Messages of all borrowed motion: leases, the answer to a command, a stop, the end of a goal."""

from typing import Annotated

from msgspec import Meta, Struct
from msgspec.structs import force_setattr

from lbr.messages.codes import Reason, ReasonCode, heard
from lbr.messages.plain import one_line

LeaseId = Annotated[
    str, Meta(max_length=64, description="the lease this command renews or changes; empty asks for one")
]


STOPPED_SINCE = "stopped since this was written: "
"""The beginning of a refusal of a command that waited at its sender until another stopped its target.
"""


class StopCommand(Struct, frozen=True, kw_only=True):
    """Stop, whichever sender holds the robot; ends every goal, observer and timer.

    `lost`: the one who wanted the motion is gone. From the holder, it ends the motion as if its lease had lapsed.
    `whole`: the robot is to stand still, not only what the sender moves itself; what waits at others is not to move it.
    `by` is who said so, where a capability passes it on: what comes by several ways is one stop. `own`: the sender
    gives up what it asked for itself, granted or not; to others that is not a stop. `at_once`: joints hold where they
    are, and do not step to their feet first.
    """

    reason: Annotated[str, Meta(max_length=200)] = ""
    lost: bool = False
    whole: bool = False
    by: Annotated[str, Meta(max_length=200)] = ""
    own: bool = False
    at_once: bool = False

    def __post_init__(self) -> None:
        """Have the reason be one line, also from a foreign client: it is told to the stopped sender."""
        force_setattr(self, "reason", one_line(self.reason))
        force_setattr(self, "by", one_line(self.by))


class CommandReply(Struct, frozen=True, kw_only=True, omit_defaults=True):
    """The answer to a command: accepted, with the lease it lives by; or refused, with the reason.

    `code` says why it was refused, `cause` of a dead lease how that one ended; both are from the list of codes. `note`
    is the sentence of the cause by itself, `holder` who has what is held.
    """

    accepted: bool
    reason: str = ""
    code: ReasonCode = ""
    cause: ReasonCode = ""
    note: str = ""
    holder: str = ""
    lease: str = ""
    ttl_s: float | None = None
    goal: str = ""

    @property
    def why(self) -> Reason:
        """Return why it was refused; of a dead lease, how that one ended."""
        text = self.note or self.reason or "it was refused without a reason"
        return heard(self.cause or self.code, text, holder=self.holder)


def refused(reason: Reason) -> CommandReply:
    """Return the reply that refuses a command."""
    return CommandReply(
        accepted=False,
        reason=reason.text,
        code=reason.code,
        cause=reason.cause,
        note=reason.note,
        holder=reason.holder,
    )
