"""Handshakes, by which drivers recognise their devices: questions that change and move nothing.

A kind names one handshake or a tuple of them, which are imported only by a search for devices:
`OnDevice("my_lamp", recognised="my_lamp.recognition:HANDSHAKES")`. `python -m lbr devices` uses them; see
docs/devices.md.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from lbr import plugins
from lbr.capability.border import border
from lbr.capability.kind import Kind, KindError
from lbr.errors import told

Read = Callable[[int, int], bytes]
"""Reads bytes from a register on: `read(register, count)`; raises OSError if no device answers."""
MOST_QUESTIONS = 64


@dataclass(frozen=True, kw_only=True, slots=True)
class Seen:
    """The answering device: its description, its serial number if it reports one, and the settings of its capability
    row.

    `needs` are further rows of its driver, by table, to be added if they are missing; each has a `name`.
    """

    what: str
    serial: str = ""
    settings: Mapping[str, Any] = field(default_factory=dict)
    needs: tuple[tuple[str, Mapping[str, Any]], ...] = ()


@dataclass(frozen=True, kw_only=True, slots=True)
class SerialHandshake:
    """A device on a serial line. `questions` must be harmless, even for devices of other makes; without questions, the
    device sends by itself. `seen` gets all bytes received since the first question, and returns the device; None while
    it is unknown. It waits `gap_s` after each question, and `listen_s` after the last one. `whole`: all questions are
    asked, whatever the answers. `leave` is written once the device is recognised, to restore its state."""

    baud: int
    seen: Callable[[bytes], Seen | None]
    questions: tuple[bytes, ...] = ()
    gap_s: float = 0.0
    listen_s: float = 0.1
    whole: bool = False
    leave: bytes = b""


@dataclass(frozen=True, kw_only=True, slots=True)
class I2cHandshake:
    """A device on an i2c bus, at one of several addresses; `seen` gets a function that only reads its registers."""

    addresses: tuple[int, ...]
    seen: Callable[[Read], Seen | None]


@dataclass(frozen=True, kw_only=True, slots=True)
class NameHandshake:
    """A device with a name in the kernel: a camera (`video`), receiver (`lirc`) or `gamepad`. `seen` gets that name."""

    place: Literal["video", "lirc", "gamepad"]
    seen: Callable[[str], Seen | None]


Handshake = SerialHandshake | I2cHandshake | NameHandshake


def handshakes(kind: Kind) -> tuple[Handshake, ...]:
    """Return a kind's handshakes, empty if it has none; raise KindError if they are unusable."""
    if kind.device is None or not kind.device.recognised:
        return ()
    named = kind.device.recognised
    with border(lambda err: KindError(f"kind '{kind.name}': {named} does not load: {told(err)}")):
        loaded = plugins.load(named)
    handshakes = loaded if isinstance(loaded, tuple) else (loaded,)
    for handshake in handshakes:
        if not isinstance(handshake, Handshake):
            raise KindError(f"kind '{kind.name}': {named} is no handshake, but a {type(handshake).__name__}")
        if fault := _fault(handshake):
            raise KindError(f"kind '{kind.name}': {named}: {fault}")
    return handshakes


def _fault(shake: Handshake) -> str:
    """Return the fault in a handshake, whose author may not check types; empty if it has none."""
    seen: object = shake.seen
    if not callable(seen):
        return f"'seen' is {seen!r}, and is to be a function"
    if not isinstance(shake, SerialHandshake):
        return ""
    if type(shake.baud) is not int or shake.baud <= 0:
        return f"'baud' is {shake.baud!r}, and is to be a whole number above 0"
    if not isinstance(shake.questions, tuple) or not all(isinstance(question, bytes) for question in shake.questions):
        return f"'questions' is {shake.questions!r}, and is to be a tuple of bytes, such as (b'?',)"
    return f"it asks more than {MOST_QUESTIONS} questions" if len(shake.questions) > MOST_QUESTIONS else ""
