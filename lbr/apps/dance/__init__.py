"""Dance: plays a song and moves the base to its beats, as anybody else would: by commands with a lease."""

from msgspec import Struct

from lbr.capability.kind import Kind
from lbr.messages.dance import DanceCommand, DanceState
from lbr.messages.drive import CommandReply, DriveCommand, StopCommand


class DanceSettings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What a row of kind `dance` may set."""


KIND = Kind(
    name="dance",
    summary="plays a song and dances to its beats",
    family="app",
    entry="lbr.apps.dance.capability:Dance",
    settings=DanceSettings,
    outputs={"state": DanceState},
    commands={"play": DanceCommand, "stop": StopCommand},
    replies={"play": CommandReply, "stop": CommandReply, "motion": CommandReply, "halt": CommandReply},
    requests={"motion": DriveCommand, "halt": StopCommand},
    rows=("choreography",),
)
