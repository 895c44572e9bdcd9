"""The words of a row for use from outside: each a stop or a goal that ends by itself. Pure."""

from math import isfinite
from typing import Annotated

import msgspec
from msgspec import Meta, Struct

from lbr.errors import InputError
from lbr.messages.behaviour import RunBehaviour
from lbr.messages.drive import DriveCommand, HeadingCommand, TurnCommand
from lbr.messages.joints import PlayCommand
from lbr.messages.leases import StopCommand
from lbr.messages.plain import one_line
from lbr.messages.speech import SayCommand
from lbr.messages.system import RANKS, Role
from lbr.messages.units import HeadingDeg, Name, Power, TurnDeg

LONGEST_TEXT = 250
LEAST_CM = 1.0
"""The shortest distance; a shorter one is refused, as 0 would mean no bound at all."""


class StopWord(Struct, frozen=True, kw_only=True, tag_field="do", tag="stop", forbid_unknown_fields=True):
    """Stop whatever moves; allowed for everybody."""


class RunWord(Struct, frozen=True, kw_only=True, tag_field="do", tag="run", forbid_unknown_fields=True):
    """Run a table of the behaviours, from its start."""

    table: Name


class SayWord(Struct, frozen=True, kw_only=True, tag_field="do", tag="say", forbid_unknown_fields=True):
    """Speak a phrase or a text; without either, the text in the request."""

    text: Annotated[str, Meta(max_length=LONGEST_TEXT)] = ""
    phrase: Annotated[str, Meta(max_length=40)] = ""


class TurnWord(Struct, frozen=True, kw_only=True, tag_field="do", tag="turn", forbid_unknown_fields=True):
    """Turn by an angle, clockwise; without one, by the request's, at most `most_deg` either way."""

    angle_deg: TurnDeg | None = None
    most_deg: Annotated[float, Meta(gt=0.0, le=360.0)] = 180.0


class HeadingWord(Struct, frozen=True, kw_only=True, tag_field="do", tag="heading", forbid_unknown_fields=True):
    """Turn to a compass heading; without one, to the request's."""

    heading_deg: HeadingDeg | None = None


class GoWord(Struct, frozen=True, kw_only=True, tag_field="do", tag="go", forbid_unknown_fields=True):
    """Drive so far, negative is back; without a distance, the request's, at most `most_cm`."""

    distance_cm: Annotated[float, Meta(ge=-1000.0, le=1000.0)] | None = None
    most_cm: Annotated[float, Meta(ge=LEAST_CM, le=1000.0)] = 100.0
    power: Power = 0.2


class PlayWord(Struct, frozen=True, kw_only=True, tag_field="do", tag="play", forbid_unknown_fields=True):
    """Play a motion of the rows."""

    motion: Name
    times: Annotated[int, Meta(ge=1, le=20)] = 1


Word = StopWord | RunWord | SayWord | TurnWord | HeadingWord | GoWord | PlayWord
Motion = DriveCommand | TurnCommand | HeadingCommand | PlayCommand
Order = Motion | StopCommand | RunBehaviour | SayCommand


class Ask(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A request: the word, its value, and the sender's id for it."""

    word: Annotated[str, Meta(max_length=40)]
    value: float | str | None = None
    id: Annotated[str, Meta(max_length=80)] | Annotated[int, Meta(ge=-(2**53), le=2**53)] = ""


class Bounds(Struct, frozen=True, kw_only=True):
    """The value of a word: a text, or a number within bounds."""

    text: bool = False
    least: float = 0.0
    most: float = 0.0
    unit: str = ""


def bounds(word: Word) -> Bounds | None:
    """Return the bounds of a word's value; None if it has no value."""
    match word:
        case SayWord(text="", phrase=""):
            return Bounds(text=True)
        case TurnWord(angle_deg=None, most_deg=most):
            return Bounds(least=-most, most=most, unit="°")
        case HeadingWord(heading_deg=None):
            return Bounds(least=0.0, most=360.0, unit="°")
        case GoWord(distance_cm=None, most_cm=most):
            return Bounds(least=-most, most=most, unit="cm")
        case _:
            return None


def read(raw: object) -> Ask:
    """Return the request in a decoded JSON value; raise InputError for a bad one."""
    try:
        return msgspec.convert(raw, Ask)
    except msgspec.ValidationError as err:
        raise InputError(
            f'this asks for nothing: {err}; write {{"word": …, "value": …, "id": …}}', "malformed"
        ) from err
    except (RecursionError, ValueError) as err:
        raise InputError(f"this asks for nothing ({type(err).__name__})", "malformed") from err


def order(ask: Ask, allowed: dict[str, Word], held: Role | None) -> Order:
    """Return the order of a word; raise InputError with a code if its sender, of the role `held`, may not give it."""
    word = allowed.get(ask.word)
    if word is None:
        there = ", ".join(sorted(allowed)) or "none"
        raise InputError(f"the word '{one_line(ask.word)}' is not among those of this row: {there}", "denied")
    needed: Role = "view" if isinstance(word, StopWord) else "operate"
    if needed != "view" and held is None:
        raise InputError(f"'{ask.word}' needs a token: the setting 'token' of the row names none that counts", "token")
    if held is not None and RANKS[held] < RANKS[needed]:
        raise InputError(f"'{ask.word}' needs the role {needed}, and the row's token has {held}", "role")
    return _ordered(ask, word)


def _ordered(ask: Ask, word: Word) -> Order:
    wanted = bounds(word)
    if wanted is None and ask.value is not None:
        raise InputError(f"nothing comes with '{ask.word}', but '{one_line(str(ask.value)[:40])}' does", "bad_value")
    text, number = _given(ask, wanted)
    made: Order
    match word:
        case StopWord():
            made = StopCommand(reason=f"asked for by '{ask.word}'", whole=True)
        case RunWord(table=table):
            made = RunBehaviour(name=table)
        case SayWord(text=said, phrase=phrase):
            made = SayCommand(text=said or text, phrase=phrase)
        case TurnWord(angle_deg=angle):
            made = TurnCommand(angle_deg=number if angle is None else angle)
        case HeadingWord(heading_deg=heading):
            made = HeadingCommand(heading_deg=number if heading is None else heading)
        case GoWord(distance_cm=distance, power=power):
            made = _way(ask, number if distance is None else distance, power)
        case PlayWord(motion=motion, times=times):
            made = PlayCommand(motion=motion, times=times)
    return made


def _given(ask: Ask, wanted: Bounds | None) -> tuple[str, float]:
    """Return the text or number of a request."""
    if wanted is None:
        return "", 0.0
    if wanted.text:
        text = one_line(ask.value).strip() if isinstance(ask.value, str) else ""
        if not 0 < len(text) <= LONGEST_TEXT:
            raise InputError(f"a text of 1 to {LONGEST_TEXT} characters comes with '{ask.word}'", "bad_value")
        return text, 0.0
    if isinstance(ask.value, str) or ask.value is None or not isfinite(ask.value):
        raise InputError(f"a number comes with '{ask.word}'", "bad_value")
    if not wanted.least <= ask.value <= wanted.most:
        said = f"{ask.value:g} is not from {wanted.least:g} to {wanted.most:g} {wanted.unit}"
        raise InputError(f"'{ask.word}': {said}", "bad_value")
    return "", ask.value


def _way(ask: Ask, distance_cm: float, power: float) -> DriveCommand:
    if not abs(distance_cm) >= LEAST_CM:  # this way round, NaN is refused
        raise InputError(f"'{ask.word}': {distance_cm:g} cm is no way to go; {LEAST_CM:g} is the least", "bad_value")
    return DriveCommand(power=power, angle_deg=0.0 if distance_cm > 0.0 else 180.0, distance_cm=abs(distance_cm))
