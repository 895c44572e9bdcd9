"""The kind `dance`: its settings, ports and words."""

from typing import Annotated

from msgspec import Meta, Struct

from lbr.apps.dance.messages import DanceCommand, DanceState, DanceStep
from lbr.capability.kind import Command, Kind, Known, names
from lbr.capability.word import Word
from lbr.messages.drive import DriveCommand
from lbr.messages.leases import StopCommand
from lbr.messages.speech import HushCommand, PlayReply, SongCommand, SpeechState
from lbr.messages.units import Name


class DanceSettings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Settings of a row of kind `dance`: the choreography that is danced unless a command names another."""

    dance: Name = "to_and_fro"
    max_s: Annotated[float, Meta(gt=0.0, le=3600.0, description="the longest dance")] = 300.0
    delay_s: Annotated[float, Meta(ge=-2.0, le=2.0, description="from a song's start to its sound; moves wait")] = 0.0


CLICKS = "metronome"


def _songs(known: Known) -> set[str]:
    """Return the songs with beats, and the metronome."""
    return {CLICKS, *(path.stem for path in (known.home / "music").glob("*.json"))}


KIND = Kind(
    name="dance",
    summary="plays a song and dances to its beats",
    family="app",
    entry="lbr.apps.dance.capability:Dance",
    settings=DanceSettings,
    inputs={"speech": SpeechState},
    outputs={"state": DanceState},
    commands={
        "play": Command(DanceCommand, choices={"song": _songs, "dance": names(DanceStep, "dance")}),
        "stop": StopCommand,
    },
    replies={"sound": PlayReply},
    requests={"motion": DriveCommand, "halt": StopCommand, "sound": SongCommand, "hush": HushCommand},
    rows=(DanceStep,),
    words=(
        Word(
            "/d/{song}",
            "play",
            "Dance to a song: /d/metronome is always there; yours are NAME.wav and NAME.json in $LBR_HOME/music",
        ),
        Word("/d/{song}/{dance}", "play", "Dance to a song by a choreography, such as /d/metronome/to_and_fro"),
    ),
)
