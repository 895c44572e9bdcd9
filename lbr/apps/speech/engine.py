"""The speech engine's own process: `python -m lbr.apps.speech.engine`, texts as JSON lines in, WAV files out.

Its first line reports whether there is an engine. Then each request is answered by one line. The output of pyttsx3 is
discarded, and it only writes files: its own playback reports success without a sound card. If a voice of the cloud or
of piper fails, espeak-ng speaks the text, and the answer's note is the reason.
"""

import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import BinaryIO

import msgspec

from lbr.apps.sound import wav
from lbr.apps.speech.piper import Piper
from lbr.apps.speech.polly import Polly
from lbr.apps.speech.request import Answer, Request
from lbr.capability.border import border
from lbr.errors import LbrError, told

INSTALL = "`sudo apt install espeak-ng` brings one"
ESPEAK = "espeak"


class Engine:
    """pyttsx3, with errors that it does not report by itself."""

    def __init__(self) -> None:
        import pyttsx3

        self._errors: list[str] = []
        self._engine = pyttsx3.init()  # type: ignore[no-untyped-call]
        self._engine.connect("error", self._note)

    def write(self, request: Request) -> None:
        """Write the sound; raise LbrError without any."""
        if not self._sounds(request) and not self._sounds(request):
            raise LbrError("the speech engine has no sound for this text")
        wav.read(Path(request.path))

    def _sounds(self, request: Request) -> bool:
        """Write the sound of a text; return whether there is any sound in it.

        Rarely, the library writes silence after a voice that it does not have, and nothing while its last text ends.
        """
        path = Path(request.path)
        named = (request.name,) if request.engine == ESPEAK else ()
        for voice in dict.fromkeys((*named, request.language, request.language.partition("-")[0])):
            self._errors.clear()
            path.unlink(missing_ok=True)
            self._engine.setProperty("voice", voice)
            self._engine.setProperty("rate", request.words_per_min)
            self._engine.setProperty("pitch", request.pitch)
            self._engine.setProperty("volume", request.volume)
            self._engine.save_to_file(request.text, request.path)
            self._engine.runAndWait()
            if not self._errors:
                break
        if any("voice" in error.lower() for error in self._errors):
            raise LbrError(f"the speech engine has no voice for '{request.language}'")
        if self._errors:
            raise LbrError(f"the speech engine failed: {self._errors[0][:200]}")
        return path.exists() and (request.volume == 0.0 or wav.peak(path) >= wav.SILENT_PEAK)

    def _note(self, name: object, exception: object) -> None:
        del name
        self._errors.append(str(exception))


class Voices:
    """All engines behind one call: the voice's own, or else espeak-ng, which is always on the robot."""

    def __init__(self, local: Engine) -> None:
        self._local = local
        self._others: dict[str, Polly | Piper] = {"polly": Polly(), "piper": Piper()}

    def write(self, request: Request) -> str:
        """Write the sound; return the reason if another voice speaks instead. Raise LbrError if none can."""
        voice = self._others.get(request.engine)
        if voice is None:
            self._local.write(request)
            return ""
        try:
            voice.write(request)
            wav.read(Path(request.path))
        except LbrError as err:
            self._local.write(request)
            return f"{err}; espeak-ng speaks instead of {request.voice}"
        return ""


def serve(requests: BinaryIO, answer: Callable[[Answer], None]) -> None:
    """Report whether there is an engine, then answer requests until they end."""
    faults: list[Exception] = []
    with border(faults.append):
        voices = Voices(Engine())
    if faults:
        return answer(Answer(reason=_lacking(faults[0])))
    answer(Answer())
    for line in requests:
        with border(lambda err: answer(Answer(reason=_failed(err)))):  # the next text may succeed
            answer(Answer(note=voices.write(msgspec.json.decode(line, type=Request))))
    return None


def _lacking(err: Exception) -> str:
    """Return why there is no engine."""
    if isinstance(err, ImportError):
        return f"there is no pyttsx3 ({err}); `pip install pyttsx3` brings it"
    reason = (str(err).strip().splitlines() or [type(err).__name__])[0]
    return f"there is no speech engine ({reason[:120]}); {INSTALL}"


def _failed(err: Exception) -> str:
    return str(err) if isinstance(err, LbrError) else f"the speech engine failed: {told(err)}"


def main() -> None:
    """Serve the process that started this one."""
    output = os.dup(1)
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)

    def answer(message: object) -> None:
        os.write(output, msgspec.json.encode(message) + b"\n")

    serve(sys.stdin.buffer, answer)


if __name__ == "__main__":
    main()
