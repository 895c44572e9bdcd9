"""The requests to the engine's process, and its answers: JSON lines. No I/O."""

from msgspec import Struct


class Cloud(Struct, frozen=True, kw_only=True):
    """The cloud's address and time limit; `cache` is the folder of its earlier sounds."""

    region: str = ""
    endpoint: str = ""
    timeout_s: float = 3.0
    cache: str = ""


class Request(Struct, frozen=True, kw_only=True):
    """A text to synthesise to a file; `volume` from 0 to 1, `voice` an engine and its voice, or empty."""

    text: str
    language: str
    words_per_min: int
    volume: float
    path: str
    voice: str = ""
    pitch: int = 50
    models: str = ""
    cloud: Cloud = Cloud()

    @property
    def engine(self) -> str:
        """Return the engine, or an empty string."""
        return self.voice.partition("/")[0]

    @property
    def name(self) -> str:
        """Return the engine's name of the voice."""
        return self.voice.partition("/")[2]


class Answer(Struct, frozen=True, kw_only=True, omit_defaults=True):
    """The result of a request, or at first of the engine itself; an empty reason is success.

    `note` is why another voice than the row's has spoken.
    """

    reason: str = ""
    note: str = ""
