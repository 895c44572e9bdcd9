"""Messages on `speech/*`: what the robot says."""

from typing import Annotated

from msgspec import Meta, Struct

from lbr.messages.codes import ReasonCode
from lbr.messages.rows import Row
from lbr.messages.shapes import LANGUAGE
from lbr.messages.units import Name

Language = Annotated[str, Meta(max_length=20, description="a language tag such as en; empty: the robot's own")]


class Phrase(Row, frozen=True, kw_only=True):
    """The phrases of the robots, by name and language."""

    TABLE = "phrase"
    KEY = ("name", "language")
    SHARED = True

    name: Annotated[Name, "by which programs know it"]
    language: Annotated[
        str,
        Meta(pattern="^[a-z]{2}[a-z0-9-]{0,18}$(?!\\n)", extra={"shape": LANGUAGE}),
        "a language tag in small letters: en, de, pt-br",
    ]
    text: Annotated[str, Meta(min_length=1, max_length=1000), "what is said"]


class SayCommand(Struct, frozen=True, kw_only=True):
    """Say a text, or a phrase by its name; one waits for the other unless it interrupts.

    A text that begins with `<` names a recording below `$LBR_HOME/sounds`. With `save` it is written there, not said.
    """

    text: str = ""
    phrase: Annotated[str, Meta(max_length=40)] = ""
    language: Language = ""
    save: Annotated[str, Meta(max_length=80)] = ""
    interrupt: bool = False


class HushCommand(Struct, frozen=True, kw_only=True):
    """Say no more: ends what is being said and what waits. With a `song`, ends that song alone, if it is being
    played."""

    song: Annotated[str, Meta(max_length=80)] = ""


class SongCommand(Struct, frozen=True, kw_only=True):
    """Play a song, `<song>.wav` below `$LBR_HOME/music`, now: what is being said is cut, what waits is said after
    it."""

    song: Annotated[str, Meta(min_length=1, max_length=80)]


class PlayReply(Struct, frozen=True, kw_only=True, omit_defaults=True):
    """The song that is played: since when, by the monotonic clock of the robot's computer, and how long it is."""

    accepted: bool
    reason: str = ""
    code: ReasonCode = ""
    began_s: float | None = None
    duration_s: float | None = None


class SpeechState(Struct, frozen=True, kw_only=True):
    """The sentence under way, how many wait, and where it is heard; `playing` is the song under way."""

    speaking: bool
    text: str
    queued: int
    spoken: int
    failed: int
    sink: str
    reason: str = ""
    playing: str = ""
