"""The queue of speech: in order, bounded, each text first synthesised and then played. No I/O."""

from collections import deque
from dataclasses import dataclass
from pathlib import Path

from lbr.apps.sound.wav import Wav
from lbr.errors import InputError

WRITTEN_AHEAD = 2
"""The number of texts to synthesise ahead of the one being played."""


@dataclass(eq=False, slots=True)
class Job:
    """A text to speak or save, or a recording or song to play; `sound` is set once there is a file.

    - `source`: a recording to decode first.
    - `keep`: the file to save a text to, instead of speaking it.
    - `own`: a greeting or farewell, which has no sender.
    """

    text: str = ""
    language: str = ""
    sound: Wav | None = None
    source: Path | None = None
    keep: Path | None = None
    song: str = ""
    own: bool = False

    @property
    def title(self) -> str:
        """Return its name in messages."""
        return self.song or (f"'{self.text[:40]}{'…' if len(self.text) > 40 else ''}'")


class Jobs:
    """The queue."""

    def __init__(self, most: int) -> None:
        self._most = most
        self._waiting: deque[Job] = deque()

    def __len__(self) -> int:
        """Return the number of waiting texts of other senders."""
        return sum(not job.own and job.keep is None for job in self._waiting)

    def add(self, job: Job) -> None:
        """Add a job; raise InputError if there are too many."""
        if not job.own and sum(not other.own for other in self._waiting) >= self._most:
            raise InputError(f"{self._most} texts wait already; try again later, or interrupt")
        self._waiting.append(job)

    def to_write(self) -> Job | None:
        """Return the next job to synthesise: those to save first, then those to speak soon."""
        unwritten = [job for job in self._waiting if job.sound is None and job.source is None]
        kept = next((job for job in unwritten if job.keep is not None), None)
        if kept is not None or not unwritten:
            return kept
        written = sum(job.sound is not None for job in self._waiting)
        return unwritten[0] if written < WRITTEN_AHEAD else None

    def keeping(self, name: str) -> Job | None:
        """Return the newest job that will be saved under that name, or None."""
        return next((job for job in reversed(self._waiting) if job.keep is not None and job.keep.stem == name), None)

    def to_decode(self) -> Job | None:
        """Return the next recording to decode."""
        return next((job for job in self._waiting if job.source is not None and job.sound is None), None)

    def to_play(self) -> Job | None:
        """Remove and return the first job to play, once it has a sound; the order stays."""
        first = next((job for job in self._waiting if job.keep is None), None)
        if first is None or first.sound is None:
            return None
        self._waiting.remove(first)
        return first

    def drop(self, job: Job) -> None:
        """Remove a job, if it still waits."""
        if job in self._waiting:
            self._waiting.remove(job)

    def clear(self) -> list[Job]:
        """Remove and return all jobs to speak; those to save stay."""
        dropped = [job for job in self._waiting if job.keep is None]
        self._waiting = deque(job for job in self._waiting if job.keep is not None)
        return dropped

    def __contains__(self, job: Job) -> bool:
        """Return whether a job still waits."""
        return job in self._waiting
