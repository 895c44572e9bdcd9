"""The built-in song: clicks, so that the first dance needs no music of one's own."""

import json
import math
from pathlib import Path

from lbr.apps.dance.kind import CLICKS
from lbr.apps.dance.songs import KEY
from lbr.apps.sound import wav

NAME = CLICKS
RATE_HZ = 8000
BEAT_S = 0.75
BEATS = 17
FIRST_S = 0.75
CLICK_S = 0.06
PITCHES_HZ = (1320.0, 880.0, 880.0, 880.0)
"""The pitches of a bar's beats."""


def ensure(music: Path) -> None:
    """Write the song unless it exists; raises OSError if that fails."""
    if all((music / f"{NAME}{suffix}").exists() for suffix in (".wav", ".json")):
        return
    music.mkdir(mode=0o700, exist_ok=True)
    beats = [FIRST_S + index * BEAT_S for index in range(BEATS)]
    samples = bytearray([128]) * int((beats[-1] + BEAT_S) * RATE_HZ)
    for index, at_s in enumerate(beats):
        click = _click(PITCHES_HZ[index % len(PITCHES_HZ)])
        start = int(at_s * RATE_HZ)
        samples[start : start + len(click)] = click
    wav.write(music / f"{NAME}.wav", bytes(samples), RATE_HZ)
    (music / f"{NAME}.json").write_text(json.dumps({KEY: beats}) + "\n", encoding="utf-8")


def _click(pitch_hz: float) -> bytes:
    count = int(CLICK_S * RATE_HZ)
    wave = (math.sin(math.tau * pitch_hz * i / RATE_HZ) * math.exp(-5.0 * i / count) for i in range(count))
    return bytes(128 + round(100 * value) for value in wave)
