"""What borrowing motion has in common, whatever moves: leases, the answer to a command, a stop, how a goal ended."""

from typing import Annotated

from msgspec import Meta, Struct

LeaseId = Annotated[
    str, Meta(max_length=64, description="the lease this command renews or changes; empty asks for one")
]

DEAD_LEASE = "lease is dead: "
"""How the refusal of a command begins whose lease is not the live one; what follows is how that one ended."""


STOPPED_SINCE = "stopped since this was written: "
"""How the refusal of a command begins that waited at its sender, and before which another stopped what it would move."""


class StopCommand(Struct, frozen=True, kw_only=True):
    """Stop, whoever holds the robot; ends every goal, observer and timer.

    `lost`: whoever wanted the motion is gone. Said by who holds the robot for them, it ends as if its lease had lapsed.
    `whole`: the robot is to stand still, not only what the sender moves itself; what waits at others is not to move it.
    """

    reason: Annotated[str, Meta(max_length=200)] = ""
    lost: bool = False
    whole: bool = False


class CommandReply(Struct, frozen=True, kw_only=True, omit_defaults=True):
    """What became of a command: accepted, with the lease it lives by; or refused, with the reason."""

    accepted: bool
    reason: str = ""
    lease: str = ""
    ttl_s: float | None = None
    goal: str = ""
