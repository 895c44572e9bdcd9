"""The kind `speech`: its settings, ports and words."""

from typing import Annotated

from msgspec import Meta, Struct

from lbr.capability.kind import Command, Kind, OnDevice, names
from lbr.capability.word import Word
from lbr.messages.speech import HushCommand, Phrase, PlayReply, SayCommand, SongCommand, SpeechState
from lbr.messages.units import Fraction, Name, basic

Voice = Annotated[
    str,
    Meta(
        pattern="^(espeak|piper|polly)/[A-Za-z0-9][A-Za-z0-9_+-]{0,63}$(?!\\n)",
        description="an engine and its voice, such as espeak/en-us+f3, piper/en_US-lessac-medium or polly/Kevin",
    ),
]
LanguageTag = Annotated[str, Meta(pattern="^[a-z][a-z]+(-[a-z0-9]+)*$(?!\\n)", max_length=20)]


class SpeechSettings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Settings of a row of kind `speech`.

    `language`: of texts, and the first to look for phrases in; `greets`: speaks `hello` and `goodbye`. `voices`: by
    language; others get espeak-ng's own. `cloud_endpoint`: of the cloud's voices, if not the region's.
    """

    device: Name
    language: Annotated[LanguageTag, basic("voice", "Language")] = "en"
    words_per_min: Annotated[int, basic("voice", "Words a minute", ge=80, le=450)] = 150
    pitch: Annotated[int, Meta(ge=0, le=99, description="of espeak-ng's voices; 50 is the voice's own")] = 50
    volume: Annotated[Fraction, basic("voice", "Volume")] = 1.0
    voices: dict[LanguageTag, Voice] = {}
    greets: Annotated[bool, basic("voice", "Says hello and goodbye")] = True
    queue: Annotated[int, Meta(ge=1, le=64, description="how many texts may wait")] = 16
    engine_timeout_s: Annotated[float, Meta(ge=0.1, le=60.0, description="for the engine, of a text")] = 10.0
    cloud_region: Annotated[str, Meta(pattern="^[a-z]{2}(-[a-z0-9]+)+$(?!\\n)", max_length=40)] = "us-west-2"
    cloud_endpoint: Annotated[
        str, Meta(pattern=r"^(https://[^ /@]+|http://(127\.0\.0\.1|localhost)(:[0-9]+)?)?$(?!\n)", max_length=200)
    ] = ""
    cloud_timeout_s: Annotated[
        float, Meta(ge=0.2, le=20.0, description="for the cloud; then the robot's own voice")
    ] = 3.0


KIND = Kind(
    name="speech",
    summary="says texts and phrases aloud, and plays songs",
    family="app",
    entry="lbr.apps.speech.capability:Speech",
    settings=SpeechSettings,
    outputs={"state": SpeechState},
    commands={"say": Command(SayCommand, choices={"phrase": names(Phrase)}), "hush": HushCommand, "play": SongCommand},
    replies={"play": PlayReply},
    device=OnDevice("speaker", emulated="folder"),
    rows=(Phrase,),
    words=(
        Word("/s/{text...}", "say", "Say a text, 5000 characters at most; one that is <name plays a recording"),
        Word("/say/{phrase}", "say", "Say a phrase by its name, such as /say/hello"),
        Word("/save/{save}/{text...}", "say", "Save a text as a recording instead of saying it; /s/<name plays it"),
        Word("hush", "hush", "Say no more: ends speech and song, and drops what waits"),
    ),
)
