"""Recordings of other formats, decoded one after the other, each by a process with a time limit."""

import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import IO

from lbr.apps.sound import wav
from lbr.apps.speech.jobs import Job, Jobs
from lbr.capability.die_with_parent import dying_with_parent
from lbr.errors import InputError

PROGRAM = (sys.executable, "-P", "-m", "lbr.apps.sound.decode")
LIMIT_S = 30.0
"""Half an hour of MP3 takes about 5 s on one core of a desktop, and several times that on a Raspberry Pi."""
_WORDS_BYTES = 2000


class Decoder:
    """Decodes the queue's recordings that are not PCM WAV; nothing here blocks."""

    def __init__(self, jobs: Jobs, scratch: Path, clock: Callable[[], float], program: Sequence[str] = PROGRAM) -> None:
        self._jobs = jobs
        self._scratch = scratch
        self._clock = clock
        self._program = tuple(program)
        self._job: Job | None = None
        self._popen: subprocess.Popen[bytes] | None = None
        self._words: IO[bytes] | None = None
        self._until = 0.0
        self._count = 0

    def poll(self) -> list[tuple[Job, str]]:
        """Return the job that ended and its error, or an empty string; a job hushed meanwhile is dropped."""
        if self._popen is None or self._job is None:
            return []
        job, code = self._job, self._popen.poll()
        hushed = job not in self._jobs
        if code is None and self._clock() < self._until and not hushed:
            return []
        path, why = self._path(), ""
        if code is None:
            why = f"{job.source} was not decoded within {LIMIT_S:.0f} s"
        elif code != 0:
            why = self._last_line() or f"the decoder died ({code})"
        self.close()
        if not why and not hushed:
            try:
                job.sound = wav.read(path)
            except InputError as err:
                why = str(err)
        if why or hushed:
            path.unlink(missing_ok=True)
        if hushed:
            return []
        if why:
            self._jobs.drop(job)
        return [(job, why)]

    def go_on(self) -> list[tuple[Job, str]]:
        """Start the next recording, if there is one; return a job that cannot be started, and why."""
        job = self._jobs.to_decode() if self._popen is None else None
        if job is None:
            return []
        self._job, self._count = job, self._count + 1
        self._words = tempfile.TemporaryFile()  # noqa: SIM115 - closed by `_end`
        try:
            self._popen = subprocess.Popen(
                dying_with_parent((*self._program, str(job.source), str(self._path()))),
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=self._words,
                start_new_session=True,  # a scheduling group of its own, like the engine's
            )
        except OSError as err:
            self.close()
            self._jobs.drop(job)
            return [(job, f"the decoder cannot be started: {err.strerror}")]
        self._until = self._clock() + LIMIT_S
        return []

    def close(self) -> None:
        """End the current process."""
        popen, words = self._popen, self._words
        self._popen = self._job = self._words = None
        if popen is not None:
            popen.kill()
            popen.wait()
        if words is not None:
            words.close()

    def _last_line(self) -> str:
        assert self._words is not None
        self._words.seek(0)
        lines = self._words.read(_WORDS_BYTES).decode("utf-8", "replace").splitlines()
        line_of_decoder = next((line.strip() for line in reversed(lines) if line.strip()), "")
        return "".join(char if char.isprintable() else "?" for char in line_of_decoder[:400])

    def _path(self) -> Path:
        return self._scratch / f"decoded{self._count}.wav"
