"""Songs below `$LBR_HOME/music`: `NAME.wav`, and its beats in `NAME.json`: {"BEATS": [seconds from the beginning,
…]}."""

import json
import math
from pathlib import Path

from msgspec import Struct

from lbr.apps.sound import names, wav
from lbr.errors import InputError
from lbr.names import did_you_mean

MOST_BYTES = 1_000_000
MOST_BEATS = 10_000
LATEST_S = wav.LONGEST_S
AFTER_THE_END_S = 1.0
KEY = "BEATS"


class Song(Struct, frozen=True):
    """A song that can be danced to: two beats at least, in order, none after its end."""

    name: str
    beats: tuple[float, ...]
    duration_s: float


def load(music: Path, name: str) -> Song:
    """Return a song; InputError names the file, and the line or beat at fault."""
    names.checked(name, "song")
    sound, beats = music / f"{name}.wav", music / f"{name}.json"
    if not sound.is_file():
        raise InputError(
            f"there is no song '{name}' in {music}; {did_you_mean(name, names.stems(music, '.wav'))}",
            "unknown_name",
        )
    if not beats.is_file():
        raise InputError(f'{beats} is missing: {{"BEATS": [0.5, 1.0]}} says when the beats are, in seconds')
    duration_s = wav.read(sound).duration_s
    times = parse(_text(beats), str(beats))
    if times[-1] > duration_s + AFTER_THE_END_S:
        why = f"{times[-1]:g} s is after the end of the song, {duration_s:.1f} s"
        raise InputError(f"{beats}: {KEY}[{len(times) - 1}] {why}")
    return Song(name, times, duration_s)


def parse(text: str, where: str) -> tuple[float, ...]:
    """Return the beats that a text lists; raise InputError naming `where` and the line or beat."""
    try:
        document = json.loads(text)
    except json.JSONDecodeError as err:
        raise InputError(f"{where}, line {err.lineno}, column {err.colno}: {err.msg}") from err
    except (ValueError, RecursionError) as err:
        raise InputError(f"{where} is not JSON that can be read ({str(err)[:80]})") from err
    beats = document.get(KEY) if isinstance(document, dict) else None
    if not isinstance(beats, list):
        raise InputError(f'{where}: it must be {{"{KEY}": [seconds, …]}}')
    if not 2 <= len(beats) <= MOST_BEATS:
        raise InputError(f"{where}: {KEY} has {len(beats)} beats; 2 to {MOST_BEATS} can be danced to")
    return _in_order([_beat(value, f"{where}: {KEY}[{index}]") for index, value in enumerate(beats)], where)


def _beat(value: object, where: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InputError(f"{where} is not a number of seconds")
    if not (0 <= value <= LATEST_S and math.isfinite(value)):
        raise InputError(f"{where} is outside 0 to {LATEST_S:g} s")
    return float(value)


def _in_order(beats: list[float], where: str) -> tuple[float, ...]:
    for index in range(1, len(beats)):
        if not beats[index - 1] < beats[index]:
            raise InputError(f"{where}: {KEY}[{index}] {beats[index]:g} s is not after the beat before it")
    return tuple(beats)


def _text(path: Path) -> str:
    try:
        with path.open("rb") as file:
            data = file.read(MOST_BYTES + 1)
        if len(data) > MOST_BYTES:
            raise InputError(f"{path} is larger than {MOST_BYTES} bytes")
        return data.decode()
    except OSError as err:
        raise InputError(f"{path} cannot be read ({err.strerror or err})") from err
    except UnicodeDecodeError as err:
        raise InputError(f"{path} is not UTF-8 (byte {err.start})") from err
