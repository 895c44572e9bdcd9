"""The voices of piper, if it is installed: neural, and local. Runs in the engine's process."""

import wave
from pathlib import Path
from typing import Any

from lbr.apps.speech.request import Request
from lbr.capability.border import border
from lbr.errors import LbrError, told

INSTALL = "`pip install piper-tts` brings it"
USUAL_WORDS_PER_MIN = 150


class Piper:
    """Loads each voice once, from `NAME.onnx` and `NAME.onnx.json` in the folder of voices."""

    def __init__(self) -> None:
        self._voices: dict[str, Any] = {}

    def write(self, request: Request) -> None:
        """Write the sound of a voice; raise LbrError without such a voice, or without piper."""
        try:
            from piper import PiperVoice, SynthesisConfig
        except ImportError as err:
            raise LbrError(f"there is no piper ({err}); {INSTALL}") from err
        model = Path(request.models) / f"{request.name}.onnx"
        if not model.is_file():
            raise LbrError(f"there is no voice {model}; download it and its .json there")
        with border(lambda err: LbrError(f"piper failed with {request.name} ({told(err)})")):
            if request.name not in self._voices:
                self._voices[request.name] = PiperVoice.load(model)
            slower = USUAL_WORDS_PER_MIN / request.words_per_min
            how = SynthesisConfig(length_scale=slower, volume=request.volume)
            with wave.open(request.path, "wb") as out:
                self._voices[request.name].synthesize_wav(request.text, out, syn_config=how)
