"""A robot around speech, for tests: a folder as the speaker, a small program as the engine, and what was said, kept."""

import sys
import textwrap
import wave
from pathlib import Path
from typing import Any

from lbr.apps.speech.kind import KIND
from lbr.capability.context import Device
from lbr.messages.speech import Phrase, SayCommand, SpeechState
from lbr.testing import FakeCall
from lbr.testing.driver import RealTimeContext
from tests.support.waiting import until

ENGINE = textwrap.dedent("""
    import json, os, sys, time, wave
    def tell(**answer): os.write(1, json.dumps(answer).encode() + b"\\n")
    if "none" in sys.argv: tell(reason="there is no speech engine"); sys.exit()
    if "mute" in sys.argv: time.sleep(60)
    tell()
    for line in sys.stdin:
        request = json.loads(line)
        if "die" in request["text"]: os.kill(os.getpid(), 9)
        if "hang" in request["text"]: time.sleep(60)
        if "refuse" in request["text"]: tell(reason="no voice for this"); continue
        if "babble" in request["text"]: os.write(1, b"\\xff{\\n"); continue
        seconds = 30 if "long" in request["text"] else 0.02
        if "lie" not in request["text"]:
            with wave.open(request["path"], "wb") as out:
                out.setparams((1, 1, 8000, 0, "NONE", ""))
                out.writeframes(bytes([100]) * int(8000 * seconds))
        tell(note="the cloud is away") if "elsewhere" in request["text"] else tell()
""")
PHRASES = (
    Phrase(name="hello", language="en", text="Good day."),
    Phrase(name="hello", language="de", text="Guten Tag."),
    Phrase(name="goodbye", language="en", text="Good bye."),
    Phrase(name="left_turn", language="en", text="Turning."),
)


def engine(tmp_path: Path, *options: str) -> list[str]:
    """Return the command line of the stand-in for the engine."""
    script = tmp_path / "engine.py"
    script.write_text(ENGINE)
    return [sys.executable, "-I", "-S", str(script), *options]


def wav_file(path: Path, seconds: float, *, width: int = 1, value: int = 100) -> Path:
    """Write sound, one byte over and over."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with wave.open(str(path), "wb") as out:
        out.setparams((1, width, 8000, 0, "NONE", ""))
        out.writeframes(bytes([value]) * int(8000 * seconds) * width)
    return path


class SpeechContext(RealTimeContext):
    """The context of speech on real time, with a folder as its speaker."""

    def __init__(self, home: Path, address: str, **settings: Any) -> None:
        home.mkdir(mode=0o700, exist_ok=True)
        chosen = KIND.settings(device="speaker", **{"greets": False, **settings})
        speaker = Device("speaker", "speaker", address, {})
        super().__init__(KIND, chosen, robot="lbr", name="speech", home=str(home), device=speaker, given=PHRASES)


class Bench:
    """A speech capability that is stepped while a test waits."""

    def __init__(self, ctx: SpeechContext) -> None:
        self.ctx = ctx
        self.home = Path(ctx.home)
        self.speech = KIND.load()(ctx)

    def until(self, look: Any) -> Any:
        return until(lambda: (self.speech.step(), look())[1])

    def ask(self, message: Any) -> Any:
        call = FakeCall("say", message, source="tester")
        self.speech.command(call)
        return call.answer

    def say(self, text: str = "", **more: Any) -> Any:
        return self.ask(SayCommand(text=text, **more))

    @property
    def state(self) -> SpeechState:
        return self.ctx.published[-1][1]

    @property
    def heard(self) -> list[Path]:
        return sorted(Path(self.ctx.device.address).glob("*.wav"))
