"""Measures whether a robot would recognise a spoken word, by synthetic voices, in noise; and its false recognitions.

`python -m benchmarks ears`; it needs the library `pocketsphinx` (`pip install pocketsphinx`, which lbr does not need)
and espeak-ng, and uses the voices of `flite` as well if that is installed. Without them it reports that and measures
nothing. Each voice speaks each word alone, in noise of several strengths; then sentences without any of the words, and
noise alone. The target is 99 % of words right, and fewer than 1 false one in 1,000 other words.
"""

import argparse
import json
import shutil
import subprocess
import tempfile
import wave
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks import Measured
from tests.support import programs

SMOKE = "--voices 1 --sentences 1 --noise-s 2 --snr 20"
RATE_HZ = 16_000
WORDS = ("stop", "hello", "status", "battery")
ESPEAK = ("en-us", "en-gb", "en-us+f3", "en-gb-scotland+m3", "en-us+m7", "en-gb+f4", "en-029", "en-gb-x-rp+f2")
FLITE = ("slt", "rms", "awb", "kal16")
THRESHOLDS = (1e-1, 1e-5, 1e-10, 1e-20)
"""The required certainty of a keyword, from strict to lenient."""
SENTENCES = (
    "The weather will be fine on Sunday afternoon.",
    "Please put the box on top of the table.",
    "She took two steps back and sat down.",
    "I bought it at the shop around the corner.",
    "The stock of paper in the office is low.",
    "He stepped over the cable and dropped his cup.",
    "We start at eight and eat at noon.",
    "The statue in the park is made of stone.",
    "A better battle plan would have won the day.",
    "Yellow leaves fall below the hill.",
    "Is the top drawer still locked?",
    "They strapped the suitcase to the roof.",
    "Nothing in this room has changed since last year.",
    "The soup is hot, so wait a moment.",
    "Open the window and let some air in.",
    "My father's stories are always the same.",
    "The car in front of us slowed down at the lights.",
    "Could you tell me what time it is?",
    "The robot turned left at the end of the corridor.",
    "Her sister swapped seats with the man behind.",
)
"""Sentences without any of the words, some of them very similar."""
LONGEST_S = 60.0

Sound = NDArray[np.float64]
Hear = Callable[[Sound], list[str]]


def options(parser: argparse.ArgumentParser) -> None:
    """Add the amount."""
    parser.add_argument("--voices", type=int, default=8, help="of those that are installed (default %(default)s)")
    parser.add_argument("--sentences", type=int, default=len(SENTENCES), help="of others (default %(default)s)")
    parser.add_argument("--noise-s", type=int, default=60, help="seconds of each noise alone (default %(default)s)")
    parser.add_argument("--snr", type=float, nargs="*", default=[20.0, 10.0], metavar="DB")
    parser.add_argument("--seed", type=int, default=1, help="of chance (default %(default)s)")


def measure(given: argparse.Namespace) -> Measured:
    """Give every sound to every recogniser."""
    try:
        import pocketsphinx
    except ImportError:
        return Measured(text="not measured: `pip install pocketsphinx` brings what is measured here")
    if shutil.which("espeak-ng") is None:
        return Measured(text="not measured: `sudo apt install espeak-ng` brings the voices")
    chance = np.random.default_rng(given.seed)
    flite = FLITE if shutil.which("flite") else ()
    installed = [*(("espeak-ng", name) for name in ESPEAK), *(("flite", name) for name in flite)]
    voices = installed[:: max(1, len(installed) // given.voices)][: given.voices]
    alone = {(word, *voice): spoken(voice, f"{word}.") for word in WORDS for voice in voices}
    others = [(text, spoken(voice, text)) for text in SENTENCES[: given.sentences] for voice in voices]
    figures = []
    for name, hear in recognisers(pocketsphinx):
        found: dict[str, Any] = {"recogniser": name}
        for snr in given.snr:
            for kind, noise in NOISES.items():
                right = sum(
                    hear(mixed(sound, noise(len(sound), chance), snr)) == [word] for (word, *_), sound in alone.items()
                )
                found[f"{kind} {snr:g} dB"] = f"{100.0 * right / len(alone):.1f} %"
        said = sum(len(text.split()) for text, _ in others)
        made_up = sum(len(hear(mixed(sound, motors(len(sound), chance), 20.0))) for _, sound in others)
        found["made up per 1,000 words"] = round(1000.0 * made_up / max(1, said), 2)
        in_noise = sum(len(hear(0.1 * noise(given.noise_s * RATE_HZ, chance))) for noise in NOISES.values())
        found["made up per hour of noise"] = round(3600.0 * in_noise / (given.noise_s * len(NOISES)), 1)
        print(json.dumps(found), flush=True)
        figures.append(found)
    told = {"words": list(WORDS), "voices": len(voices), "spoken": len(alone), "of others": len(others)}
    return Measured(figures={**told, "heard": figures})


def recognisers(library: Any) -> Iterator[tuple[str, Hear]]:
    """Return recognisers by name: for keywords, by a grammar of the words, and for all speech."""
    phones = {word: len(library.Decoder(lm=None, loglevel="FATAL").lookup_word(word).split()) for word in WORDS}
    for threshold in THRESHOLDS:
        with tempfile.NamedTemporaryFile("w", suffix=".txt") as listing:
            listing.writelines(f"{word} /{threshold ** (phones[word] / 6):.3e}/\n" for word in WORDS)
            listing.flush()
            yield f"keywords {threshold:.0e}", _by(library.Decoder(kws=listing.name, lm=None, loglevel="FATAL"))
    grammar = library.Decoder(lm=None, loglevel="FATAL")
    grammar.add_jsgf_string("words", f"#JSGF V1.0; grammar words; public <word> = {' | '.join(WORDS)};")
    grammar.activate_search("words")
    yield "grammar", _by(grammar)
    yield "dictation", _by(library.Decoder(loglevel="FATAL"))


def _by(decoder: Any) -> Hear:
    def hear(sound: Sound) -> list[str]:
        decoder.start_utt()
        decoder.process_raw(np.int16(np.clip(sound, -1.0, 1.0) * 32767).tobytes(), full_utt=True)
        decoder.end_utt()
        words = [part.word.partition("(")[0].strip() for part in (decoder.seg() or ())]
        return [word for word in words if word in WORDS]

    return hear


def spoken(voice: tuple[str, str], text: str) -> Sound:
    """Return a text in a voice, with half a second of silence around it, at a tenth of full loudness."""
    program, name = voice
    with tempfile.NamedTemporaryFile(suffix=".wav") as file:
        if program == "flite":
            argv = ["flite", "-voice", name, "-t", text, "-o", file.name]
        else:
            argv = ["espeak-ng", "-v", name, "-s", "150", "-w", file.name, "--", text]
        programs.run(argv, check=True, timeout=LONGEST_S, stdout=subprocess.DEVNULL)
        sound = resampled(Path(file.name))
    around = np.zeros(RATE_HZ // 2)
    level = np.sqrt(np.mean(sound**2)) or 1.0
    return np.concatenate([around, 0.1 * sound / level, around])


def resampled(path: Path) -> Sound:
    """Return a file's sound at the recognisers' rate; resampled by its spectrum, without aliasing."""
    with wave.open(str(path)) as file:
        rate, data = file.getframerate(), np.frombuffer(file.readframes(file.getnframes()), "<i2") / 32768.0
    wanted = int(len(data) * RATE_HZ / rate)
    spectrum = np.fft.rfft(data)[: wanted // 2 + 1]
    return np.asarray(np.fft.irfft(spectrum, wanted) * wanted / len(data))


def mixed(sound: Sound, noise: Sound, snr_db: float) -> Sound:
    """Return speech of loudness 0.1 with noise at this ratio."""
    return sound + 0.1 * noise * 10 ** (-snr_db / 20)


def hiss(count: int, chance: np.random.Generator) -> Sound:
    """Return pink noise of loudness 1: fans, streets, rooms."""
    spectrum = np.fft.rfft(chance.normal(size=count))
    return _one_loud(np.fft.irfft(spectrum / np.sqrt(np.arange(len(spectrum)) + 1.0), count))


def motors(count: int, chance: np.random.Generator) -> Sound:
    """Return the noise of geared motors, of loudness 1: a whine of varying pitch, its overtones, and rattle."""
    corners = np.arange(0, count + RATE_HZ, RATE_HZ // 2)
    turns = np.cumsum(np.interp(np.arange(count), corners, chance.uniform(90, 260, len(corners))))
    phase = 2 * np.pi * turns / RATE_HZ
    whine = sum((np.sin(n * phase) / n for n in (1, 2, 3, 5, 8, 13)), np.zeros(count))
    rattle = chance.normal(size=count) * (np.sin(7 * phase) > 0.7)
    return _one_loud(np.asarray(whine + 0.7 * rattle))


def _one_loud(sound: Sound) -> Sound:
    return np.asarray(sound / np.sqrt(np.mean(sound**2)), dtype=np.float64)


NOISES = {"hiss": hiss, "motors": motors}
