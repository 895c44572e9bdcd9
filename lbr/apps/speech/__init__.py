"""Speech: text to sound in a process of its own, then to a sink that says whether it was heard."""

from msgspec import Struct

from lbr.capability.kind import Kind
from lbr.messages.drive import CommandReply
from lbr.messages.speech import HushCommand, SayCommand, SpeechState
from lbr.messages.units import Name


class SpeechSettings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What a row of kind `speech` may set."""

    device: Name


KIND = Kind(
    name="speech",
    summary="says texts and phrases aloud",
    family="app",
    entry="lbr.apps.speech.capability:Speech",
    settings=SpeechSettings,
    outputs={"state": SpeechState},
    commands={"say": SayCommand, "hush": HushCommand},
    replies={"say": CommandReply, "hush": CommandReply},
    device="speaker",
    emulated="folder",
    rows=("phrase",),
)
