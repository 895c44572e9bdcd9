"""The speaker as a device: tried with a moment of silence before its first use, and again after each failure."""

from collections.abc import Callable
from pathlib import Path

from lbr.apps.sound import wav
from lbr.apps.sound.sinks import Playback, Sink
from lbr.apps.sound.wav import Wav
from lbr.errors import DeviceError

RETRY_FIRST_S = 1.0
RETRY_MOST_S = 30.0
_SILENCE = bytes([128]) * 400
_SILENCE_HZ = 8000


class Speaker:
    """Plays one sound at a time. `trouble` is why nothing can be played, or empty; `proven`: the trial was played."""

    def __init__(self, sink: Sink, scratch: Path, clock: Callable[[], float]) -> None:
        self.trouble = ""
        self.proven = sink.immediate
        self._sink = sink
        self._clock = clock
        self._silence = scratch / "silence.wav"
        self._trial: Playback | None = None
        self._playing: Playback | None = None
        self._retry_at = 0.0
        self._retry_s = RETRY_FIRST_S

    @property
    def playing(self) -> bool:
        """Return whether a sound is being played."""
        return self._playing is not None

    @property
    def immediate(self) -> bool:
        """Return whether a sound counts as played once it has begun."""
        return self._sink.immediate

    def start(self, sound: Wav) -> float:
        """Begin to play, and return when; raise DeviceError if that fails."""
        self.stop()
        try:
            self._playing = self._sink.start(sound)
        except DeviceError as err:
            self._fail(str(err))
            raise
        return self._playing.began

    def poll(self) -> str | None:
        """Return the end of the sound, once it has ended: empty after playing, else the reason."""
        if self._playing is None:
            self._try()
            return None
        result = self._playing.poll()
        if result is None:
            return None
        self._playing = None
        if result:
            self._fail(result)
        return result

    def stop(self) -> None:
        """End the current sound."""
        for playback in (self._playing, self._trial):
            if playback is not None:
                playback.stop()
        self._playing = self._trial = None

    def _try(self) -> None:
        """Try whether the speaker plays, with a moment of silence."""
        if self._trial is not None:
            result = self._trial.poll()
            if result is not None:
                self._trial = None
                self._fail(result) if result else self._prove()
        elif not self.proven and self._clock() >= self._retry_at:
            self._retry_at = self._clock() + self._retry_s
            try:
                if not self._silence.exists():
                    wav.write(self._silence, _SILENCE, _SILENCE_HZ)
                self._trial = self._sink.start(wav.read(self._silence))
            except OSError as err:  # includes DeviceError
                self._fail(str(err))

    def _prove(self) -> None:
        self.proven, self.trouble, self._retry_s = True, "", RETRY_FIRST_S

    def _fail(self, why: str) -> None:
        self.proven, self.trouble = False, why
        self._retry_at = self._clock() + self._retry_s
        self._retry_s = min(2 * self._retry_s, RETRY_MOST_S)
