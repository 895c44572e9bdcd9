"""Synthesises the texts of the queue, one after the other, by the engine's process."""

from pathlib import Path

from lbr.apps.sound import wav
from lbr.apps.speech.jobs import Job, Jobs
from lbr.apps.speech.kind import SpeechSettings
from lbr.apps.speech.request import Cloud, Request
from lbr.apps.speech.text import voice_of
from lbr.apps.speech.worker import Worker
from lbr.errors import InputError

SECONDS_PER_CHARACTER = 0.02


class Writer:
    """Sends texts to the engine, and checks the files that it writes.

    `note` is why another voice than the row's spoke last, or empty.
    """

    def __init__(self, worker: Worker, jobs: Jobs, scratch: Path, home: Path, settings: SpeechSettings) -> None:
        self.note = ""
        self._worker = worker
        self._jobs = jobs
        self._scratch = scratch
        self._settings = settings
        self._models = home / "voices"
        self._cloud = Cloud(
            region=settings.cloud_region,
            endpoint=settings.cloud_endpoint,
            timeout_s=settings.cloud_timeout_s,
            cache=str(self._models / "cloud"),
        )
        self._job: Job | None = None
        self._count = 0

    def poll(self) -> list[tuple[Job, str]]:
        """Return the job that ended and its error, or an empty string; a text hushed meanwhile is dropped."""
        answer = self._worker.poll()
        if answer is None:
            return []
        if not answer.reason:
            self.note = answer.note
        job, self._job = self._job, None
        path = self._path()
        why = "it was hushed"
        if job is not None and job in self._jobs:
            why = answer.reason or self._take(job, path)
        if why:
            path.unlink(missing_ok=True)
        if job is None or job not in self._jobs:
            return []
        if why or job.keep is not None:
            self._jobs.drop(job)
        return [(job, why)]

    def go_on(self) -> None:
        """Send the next text to the engine, if there is one."""
        job = self._jobs.to_write() if self._worker.idle else None
        if job is None:
            return
        self._job, self._count = job, self._count + 1
        settings = self._settings
        request = Request(
            text=job.text,
            language=job.language,
            words_per_min=settings.words_per_min,
            volume=settings.volume,
            path=str(self._path()),
            voice=voice_of(job.language, settings.voices),
            pitch=settings.pitch,
            models=str(self._models),
            cloud=self._cloud,
        )
        limit_s = settings.engine_timeout_s + settings.cloud_timeout_s
        self._worker.write(request, limit_s + SECONDS_PER_CHARACTER * len(job.text))

    def close(self) -> None:
        """End the engine."""
        self._worker.close()
        self._job = None

    def _path(self) -> Path:
        return self._scratch / f"{self._count}.wav"

    def _take(self, job: Job, path: Path) -> str:
        """Give a job its sound, or save the recording; return the error, or an empty string."""
        try:
            sound = wav.read(path)
            if job.keep is None:
                job.sound = sound
            else:
                job.keep.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
                path.replace(job.keep)
        except (InputError, OSError) as err:
            return str(err)
        return ""
