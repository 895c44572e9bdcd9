"""The queue of speech: in order, bounded, each first written to a file and then played. No I/O."""

from collections import deque
from dataclasses import dataclass
from pathlib import Path

from lbr.apps.sound.wav import Wav
from lbr.errors import InputError

WRITTEN_AHEAD = 2
"""The number of texts that are sound already while another is being played."""


@dataclass(eq=False, slots=True)
class Job:
    """A text to be said, or saved, or a recording or song to be played; `sound` is there once there is a file.

    `source` is a recording that has to be decoded first. `keep` is where a text is saved to instead of being said;
    `own` is what speech says of itself, which no sender waits for.
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
        """Return what to call it."""
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
        """Put a job at the end; raise InputError if there are too many."""
        if not job.own and sum(not other.own for other in self._waiting) >= self._most:
            raise InputError(f"{self._most} texts wait already; try again later, or interrupt")
        self._waiting.append(job)

    def to_write(self) -> Job | None:
        """Return the next job that needs a file: those to be saved first, then those to be spoken soon."""
        unwritten = [job for job in self._waiting if job.sound is None and job.source is None]
        kept = next((job for job in unwritten if job.keep is not None), None)
        if kept is not None or not unwritten:
            return kept
        written = sum(job.sound is not None for job in self._waiting)
        return unwritten[0] if written < WRITTEN_AHEAD else None

    def keeping(self, name: str) -> Job | None:
        """Return the job that is to be kept by that name; the newest of several."""
        return next((job for job in reversed(self._waiting) if job.keep is not None and job.keep.stem == name), None)

    def to_decode(self) -> Job | None:
        """Return the next recording that has to be decoded."""
        return next((job for job in self._waiting if job.source is not None and job.sound is None), None)

    def to_play(self) -> Job | None:
        """Take out and return the next job to be played, once it is a sound; nothing passes one before it."""
        first = next((job for job in self._waiting if job.keep is None), None)
        if first is None or first.sound is None:
            return None
        self._waiting.remove(first)
        return first

    def drop(self, job: Job) -> None:
        """Take a job out, if it is still there."""
        if job in self._waiting:
            self._waiting.remove(job)

    def clear(self) -> list[Job]:
        """Remove and return all jobs that wait to be spoken; those to be saved stay."""
        dropped = [job for job in self._waiting if job.keep is None]
        self._waiting = deque(job for job in self._waiting if job.keep is not None)
        return dropped

    def __contains__(self, job: Job) -> bool:
        """Return whether a job still waits."""
        return job in self._waiting
