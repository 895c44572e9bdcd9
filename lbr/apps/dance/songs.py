"""Songs below `$LBR_HOME/music`: `NAME.wav`, and its beats in `NAME.json`: {"BEATS": [seconds from the beginning,
…]}."""

from pathlib import Path
from typing import Annotated

import msgspec
from msgspec import Meta, Struct, field

from lbr.apps.sound import names, wav
from lbr.errors import InputError
from lbr.messages.unreadable import UNREADABLE

MOST_BYTES = 1_000_000
MOST_BEATS = 10_000
LATEST_S = wav.LONGEST_S
AFTER_THE_END_S = 1.0
KEY = "BEATS"
Beat = Annotated[float, Meta(ge=0.0, le=LATEST_S)]


class Song(Struct, frozen=True):
    """A song to dance to: at least two beats, in order, none after its end."""

    name: str
    beats: tuple[float, ...]
    duration_s: float


class _Beats(Struct, frozen=True):
    times: Annotated[tuple[Beat, ...], Meta(min_length=2, max_length=MOST_BEATS)] = field(name=KEY)


def load(music: Path, name: str) -> Song:
    """Load a song; raise InputError with the file, and the faulty beat."""
    names.checked(name, "song")
    sound, beats = music / f"{name}.wav", music / f"{name}.json"
    if not sound.is_file():
        raise names.unknown(music, name, "song", ".wav")
    if not beats.is_file():
        raise InputError(f'{beats} is missing: {{"BEATS": [0.5, 1.0]}} lists the times of the beats, in seconds')
    duration_s = wav.read(sound).duration_s
    times = parse(_read(beats), str(beats))
    if times[-1] > duration_s + AFTER_THE_END_S:
        why = f"{times[-1]:g} s is after the end of the song, {duration_s:.1f} s"
        raise InputError(f"{beats}: {KEY}[{len(times) - 1}] {why}")
    return Song(name, times, duration_s)


def parse(data: bytes, where: str) -> tuple[float, ...]:
    """Parse a file of beats; raise InputError with `where` and the faulty beat."""
    try:
        beats = msgspec.json.decode(data, type=_Beats).times
    except UNREADABLE as err:
        raise InputError(f"{where}: {err}") from err
    for index in range(1, len(beats)):
        if not beats[index - 1] < beats[index]:
            raise InputError(f"{where}: {KEY}[{index}] {beats[index]:g} s is not after the beat before it")
    return beats


def _read(path: Path) -> bytes:
    try:
        with path.open("rb") as file:
            data = file.read(MOST_BYTES + 1)
    except OSError as err:
        raise InputError(f"{path} cannot be read ({err.strerror or err})") from err
    if len(data) > MOST_BYTES:
        raise InputError(f"{path} is larger than {MOST_BYTES} bytes")
    return data
