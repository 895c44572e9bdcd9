"""Reads and writes motion files of the UXA-90's maker (`.rbm`): one line of fields between colons. Pure.

A header comes first, then each servo's gains and zero, then scenes. A scene leads every servo from one position to
another in its transition time. The player writes that in as many steps as it has frames. Positions count as on a robot
with nominal zeros. Derived from the files themselves.
"""

import re
from typing import NamedTuple

from lbr.errors import InputError

MOST_SERVOS = 64
MOST_SCENES = 5000
MOST_FRAMES = 100_000
LONGEST_MS = 3_600_000
MOST_COUNTS = 255
GAINS = (30, 10, 0)
"""P, D and I, from the maker's own files, for joints with little load."""
_WHOLE = re.compile(r"\s*(\d{1,9})\s*", re.ASCII)


class ServoMove(NamedTuple):
    """The part of a scene for one servo, in nominal counts."""

    id: int
    start: int
    end: int
    torque: int


class Scene(NamedTuple):
    """One stretch of a motion."""

    name: str
    frames: int
    transition_s: float
    moves: tuple[ServoMove, ...]


class RbmFile(NamedTuple):
    """A whole file; `zeros` are the zeros of the servos for which it was written."""

    name: str
    author: str
    serial: str
    zeros: dict[int, int]
    scenes: tuple[Scene, ...]


def parse(content: bytes) -> RbmFile:
    """Return the content of a file; raise InputError naming an invalid field."""
    fields = _Fields(content.decode("latin-1").strip("\0\r\n\t "))
    fields.whole("format", 0, 999)
    serial = fields.text(fields.whole("length of the serial number", 0, 99), "serial number")
    author = fields.until_colon("author")
    fields.until_colon("e-mail")
    name = fields.text(fields.whole("length of the name", 0, 200), "name")
    fields.until_colon("flag")
    fields.until_colon("platform")
    scenes = fields.whole("number of scenes", 1, MOST_SCENES)
    fields.whole("torque", 0, 255)
    servos = fields.whole("number of servos", 1, MOST_SERVOS)
    fields.until_colon("last number of the header")
    zeros = dict(_zero(fields, index) for index in range(1, servos + 1))
    if len(zeros) != servos:
        raise InputError("two servos have the same number")
    found = tuple(_scene(fields, index, servos) for index in range(1, scenes + 1))
    fields.end()
    return RbmFile(name=name.strip(), author=author.strip(), serial=serial, zeros=zeros, scenes=found)


def write(file: RbmFile) -> bytes:
    """Return the content of a file, with gains of 30, 10 and 0 for every servo, and without colons in names."""
    header = [
        1,
        len(file.serial),
        file.serial,
        _without_colons(file.author),
        "",
        len(_without_colons(file.name)),
        _without_colons(file.name),
        1,
        4,
    ]
    header += [len(file.scenes), 2, len(file.zeros), 0]
    servos = [part for servo, zero in file.zeros.items() for part in (servo, *GAINS, 0, zero)]
    scenes = [
        part
        for number, scene in enumerate(file.scenes)
        for part in (
            number,
            len(_without_colons(scene.name)),
            _without_colons(scene.name),
            scene.frames,
            round(scene.transition_s * 1000),
            *(each for move in scene.moves for each in (0, move.id, move.start, move.end, move.torque, 0)),
        )
    ]
    return (":".join(map(str, (*header, *servos, *scenes))) + ":").encode("latin-1", "replace")


def _without_colons(text: str) -> str:
    return text.replace(":", "").strip()


def _zero(fields: "_Fields", index: int) -> tuple[int, int]:
    fields.where = f"servo {index}"
    number = fields.whole("number", 0, 254)
    for what in ("P gain", "D gain", "I gain", "field before the zero"):
        fields.until_colon(what)
    return number, fields.whole("zero", 0, MOST_COUNTS)


def _scene(fields: "_Fields", index: int, servos: int) -> Scene:
    fields.where = f"scene {index}"
    fields.until_colon("number")
    name = fields.text(fields.whole("length of the name", 0, 200), "name")
    frames = fields.whole("number of frames", 0, MOST_FRAMES)
    transition_ms = fields.whole("transition time in milliseconds", 0, LONGEST_MS)
    moves = []
    for servo in range(1, servos + 1):
        fields.where = f"scene {index}, servo {servo}"
        fields.until_colon("first field")
        move = ServoMove(
            id=fields.whole("number", 0, 254),
            start=fields.whole("start position", 0, MOST_COUNTS),
            end=fields.whole("end position", 0, MOST_COUNTS),
            torque=fields.whole("torque", 0, 255),
        )
        fields.until_colon("last field")
        moves.append(move)
    if len({move.id for move in moves}) != servos:
        raise InputError(f"scene {index} has a servo twice")
    return Scene(name=name.strip(), frames=frames, transition_s=transition_ms / 1000, moves=tuple(moves))


class _Fields:
    """Takes one field after the other, and knows its number for an error; `where` is its part of the file."""

    def __init__(self, text: str) -> None:
        self.where = "header"
        self._text = text
        self._at = 0
        self._number = 0

    def until_colon(self, what: str) -> str:
        """Return the next field."""
        if self._at > len(self._text):
            raise InputError(f"the file ends after field {self._number}, where {self.where} should have its {what}")
        end = self._text.find(":", self._at)
        end = len(self._text) if end < 0 else end
        field = self._text[self._at : end]
        self._at = end + 1
        self._number += 1
        return field

    def text(self, length: int, field_name: str) -> str:
        """Return a field of this many characters, which may contain colons; with another length it ends at a colon."""
        end = self._at + length
        if self._text[end : end + 1] not in {":", ""}:
            return self.until_colon(field_name)
        field = self._text[self._at : end]
        if len(field) < length:
            raise InputError(f"the file ends within field {self._number + 1} ({self.where}, {field_name})")
        self._at = end + 1
        self._number += 1
        return field

    def whole(self, field_name: str, least: int, most: int) -> int:
        """Return a whole number within bounds."""
        text = self.until_colon(field_name)
        digits = _WHOLE.fullmatch(text)
        if digits is None or not least <= int(digits[1]) <= most:
            shown_text = "".join(c if c.isascii() and c.isprintable() else "?" for c in text[:20])
            raise InputError(
                f"field {self._number} ({self.where}, {field_name}): "
                f"'{shown_text}' is not a whole number from {least} to {most}"
            )
        return int(digits[1])

    def end(self) -> None:
        """Raise InputError if there is more input."""
        rest = self._text[self._at :].replace(":", "").strip()
        if rest:
            raise InputError(f"field {self._number + 1}: there is more after the last scene")
