"""Messages on `speech/*`: the robot's speech and songs."""

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

    name: Annotated[Name, "its name in programs"]
    language: Annotated[
        str,
        Meta(pattern="^[a-z]{2}[a-z0-9-]{0,18}$(?!\\n)", extra={"shape": LANGUAGE}),
        "a language tag in small letters: en, de, pt-br",
    ]
    text: Annotated[str, Meta(min_length=1, max_length=1000), "the spoken text"]


class SayCommand(Struct, frozen=True, kw_only=True):
    """Speak a text, or a phrase by its name, after the present sentence, unless it interrupts.

    A text that begins with `<` names a recording below `$LBR_HOME/sounds`; `save` writes it there instead.
    """

    text: str = ""
    phrase: Annotated[str, Meta(max_length=40)] = ""
    language: Language = ""
    save: Annotated[str, Meta(max_length=80)] = ""
    interrupt: bool = False


class HushCommand(Struct, frozen=True, kw_only=True):
    """End the speech, and drop waiting texts. With a `song`, end that song alone."""

    song: Annotated[str, Meta(max_length=80)] = ""


class SongCommand(Struct, frozen=True, kw_only=True):
    """Play `<song>.wav` below `$LBR_HOME/music` now, in place of speech; waiting texts follow."""

    song: Annotated[str, Meta(min_length=1, max_length=80)]


class PlayReply(Struct, frozen=True, kw_only=True, omit_defaults=True):
    """The song: its start, by the robot's monotonic clock, and its length."""

    accepted: bool
    reason: str = ""
    code: ReasonCode = ""
    began_s: float | None = None
    duration_s: float | None = None


class SpeechState(Struct, frozen=True, kw_only=True):
    """The present sentence, the number of waiting ones, and the loudspeaker. `playing`: the song."""

    speaking: bool
    text: str
    queued: int
    spoken: int
    failed: int
    sink: str
    reason: str = ""
    playing: str = ""
