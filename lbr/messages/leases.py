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
"""The beginning of a refusal of a command that waited at its sender until somebody else stopped its target."""


class StopCommand(Struct, frozen=True, kw_only=True):
    """Stop, whichever sender holds the robot; ends every goal, observer and timer.

    `lost`: the sender of the motion is gone; from the holder, like a lapsed lease. `whole`: the robot stands still, and
    waiting commands everywhere are dropped. `by`: the original sender; stops by several ways count as one. `own`: the
    sender gives up its own request; it does not stop others. `at_once`: joints hold where they are, without a step to
    their feet.
    """

    reason: Annotated[str, Meta(max_length=200)] = ""
    lost: bool = False
    whole: bool = False
    by: Annotated[str, Meta(max_length=200)] = ""
    own: bool = False
    at_once: bool = False

    def __post_init__(self) -> None:
        """Turn the reason into one line, as a foreign client may have sent it: the stopped sender reads it."""
        force_setattr(self, "reason", one_line(self.reason))
        force_setattr(self, "by", one_line(self.by))


class CommandReply(Struct, frozen=True, kw_only=True, omit_defaults=True):
    """The answer to a command: accepted, with its lease; or refused, with the reason.

    `cause`: how a dead lease ended. `note`: its sentence. `holder`: the holder of the requested part.
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
        """Return why it was refused; for a dead lease, how that one ended."""
        text = self.note or self.reason or "it was refused without a reason"
        return heard(self.cause or self.code, text, holder=self.holder)


def refused(reason: Reason) -> CommandReply:
    """Return the reply that refuses a command."""
    return CommandReply(
        accepted=False, reason=reason.text, code=reason.code, cause=reason.cause, note=reason.note, holder=reason.holder
    )
