"""Speech as a capability: queues texts, has them synthesised, plays them one after the other, and reports failures."""

import shutil
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from lbr.apps.sound import wav
from lbr.apps.sound.sinks import sink_at
from lbr.apps.speech import files
from lbr.apps.speech.decoder import Decoder
from lbr.apps.speech.jobs import Job, Jobs
from lbr.apps.speech.kind import SpeechSettings
from lbr.apps.speech.speaker import Speaker
from lbr.apps.speech.text import phrase, to_say
from lbr.apps.speech.worker import Worker
from lbr.apps.speech.writer import Writer
from lbr.capability.base import Capability
from lbr.capability.context import Call, Context
from lbr.errors import DeviceError, InputError
from lbr.messages.leases import CommandReply
from lbr.messages.speech import HushCommand, Phrase, PlayReply, SayCommand, SongCommand, SpeechState

RECORDING = "<"
BUSY_HZ, IDLE_HZ = 20.0, 2.0
STATE_EVERY_S = 0.95
FAREWELL_S = 0.5
TEXT_TOLD = 200


class Speech(Capability[SpeechSettings]):
    """Speaks one text after the other; without engine or speaker it refuses a text, with the reason."""

    rate_hz = BUSY_HZ

    def __init__(self, ctx: Context[SpeechSettings]) -> None:
        super().__init__(ctx)
        self._speaker: Speaker | None = None
        self._jobs = Jobs(ctx.settings.queue)
        self._current: Job | None = None
        self._farewell: Path | None = None
        self._spoken = self._failed = 0
        self._greeted = False
        self._published: SpeechState | None = None
        self._publish_at = 0.0
        self._home = Path(ctx.home)
        self._scratch = self._home / "run" / f"{ctx.robot}-{ctx.name}"
        self._worker = Worker(ctx.clock)
        self._writer = Writer(self._worker, self._jobs, self._scratch, self._home, ctx.settings)
        self._decoder = Decoder(self._jobs, self._scratch, ctx.clock)

    def open(self) -> None:
        """Open the sink and start the engine; both are tried during the steps."""
        sink = sink_at(self.device_row.address, self.ctx.clock)
        try:
            shutil.rmtree(self._scratch, ignore_errors=True)
            self._scratch.parent.mkdir(mode=0o700, exist_ok=True)
            self._scratch.mkdir(mode=0o700)
        except OSError as err:
            raise DeviceError(f"{self._scratch} cannot be made ({err.strerror}); check the disk") from err
        self._speaker = Speaker(sink, self._scratch, self.ctx.clock)
        self._writer.poll()

    def step(self) -> None:
        """Continue to synthesise and play."""
        speaker = self._opened()
        for job, why in (*self._writer.poll(), *self._decoder.poll(), *self._decoder.go_on()):
            self._written(job, why)
        result = speaker.poll()
        if result is not None:
            self._finish(result)
        self._greet()
        self._drop_what_cannot_be()
        self._writer.go_on()
        self._play_next(speaker)
        idle = self._greeted and speaker.proven and self._current is None and not len(self._jobs)
        self.rate_hz = IDLE_HZ if idle else BUSY_HZ
        self._publish_state()

    def command(self, call: Call) -> None:
        """Answer `say`, `hush` and `play`."""
        try:
            match call.message:
                case SayCommand():
                    call.reply(CommandReply(accepted=True, reason=self._queue(call.message)))
                case SongCommand():
                    call.reply(self._play(call.message))
                case HushCommand():
                    call.reply(CommandReply(accepted=True, reason=self._hush(call.message)))
                case _:
                    super().command(call)
        except (InputError, DeviceError) as err:
            call.refuse(str(err), err.code)
        self._publish_state()

    def degraded(self, reason: str) -> None:
        """Report that nothing is played."""
        self.ctx.publish("state", self._state(reason))

    def close(self) -> None:
        """Play the farewell within `FAREWELL_S`, then close engine and speaker."""
        speaker, self._speaker = self._speaker, None
        if speaker is not None:
            self._play_farewell(speaker)
            speaker.stop()
        self._writer.close()
        self._decoder.close()
        self._jobs.clear()
        self._current = None
        shutil.rmtree(self._scratch, ignore_errors=True)

    def _opened(self) -> Speaker:
        if self._speaker is None:
            raise RuntimeError("speech is not open")
        return self._speaker

    def _queue(self, command: SayCommand) -> str:
        if command.text.startswith(RECORDING) and not command.save:
            job = self._recorded(command.text)
        else:
            text, language = to_say(command, self.ctx.rows(Phrase), self.ctx.settings.language)
            keep = files.place_for(self._home, command.save) if command.save else None
            job = Job(text=text, language=language, keep=keep)
        if why := self._why_not(job):
            raise DeviceError(why)
        cut = self._silence() if command.interrupt and job.keep is None else ""
        ahead = len(self._jobs) + (self._current is not None)
        self._jobs.add(job)
        if job.keep is not None:
            return f"will be sounds/{job.keep.name}"
        after = f" after {ahead} other{'s' if ahead > 1 else ''}" if ahead else ""
        return f"says {job.title}{after}" + (f"; {cut}" if cut else "")

    def _recorded(self, text: str) -> Job:
        """Return the job of a recording; while that is still being synthesised, its text is spoken in its place."""
        name = text[1:].strip()
        if (kept := self._jobs.keeping(name.lower())) is not None:
            return Job(text=kept.text, language=kept.language)
        found = files.recording(self._home, name)
        return Job(text=text, source=found) if isinstance(found, Path) else Job(text, sound=found)

    def _play(self, command: SongCommand) -> PlayReply:
        """Play a song at once, and return when it began, for the dance that moves to it."""
        sound, speaker = files.song(self._home, command.song), self._opened()
        if why := speaker.trouble or ("" if speaker.proven else "the speaker is still being tried; ask again"):
            raise DeviceError(why)
        self._stop_current()
        began = speaker.start(sound)
        self._current = Job(song=command.song, sound=sound)
        return PlayReply(accepted=True, began_s=began, duration_s=round(sound.duration_s, 3))

    def _hush(self, command: HushCommand) -> str:
        if not command.song:
            return self._silence() or "nothing was being spoken"
        if self._current is None or self._current.song != command.song:
            return f"'{command.song[:80]}' was not being played"
        self._stop_current()
        return ""

    def _silence(self) -> str:
        """End the current job and all that wait; return their titles."""
        ended = self._jobs.clear()
        if self._current is not None:
            ended.insert(0, self._current)
        self._stop_current()
        self._forget(ended)
        more = f" and {len(ended) - 1} more" if len(ended) > 1 else ""
        return f"ended {ended[0].title}{more}" if ended else ""

    def _stop_current(self) -> None:
        self._opened().stop()
        saying, self._current = self._current, None
        self._forget([saying] if saying else [])

    def _why_not(self, job: Job) -> str:
        speaker = self._opened()
        if job.sound is None and job.source is None and self._worker.trouble:
            return self._worker.trouble
        return speaker.trouble if job.keep is None else ""

    def _written(self, job: Job, why: str) -> None:
        if why:
            self._fail(job, why)
        elif job.own and job.keep is not None:
            self._farewell = job.keep
        elif job.keep is not None:
            self.ctx.event("saved", f"{job.title} is sounds/{job.keep.name}")

    def _play_next(self, speaker: Speaker) -> None:
        if self._current is not None or not speaker.proven:
            return
        job = self._jobs.to_play()
        if job is None or job.sound is None:
            return
        try:
            speaker.start(job.sound)
        except DeviceError as err:
            self._fail(job, str(err))
        else:
            self._current = job

    def _finish(self, result: str) -> None:
        job, self._current = self._current, None
        if job is None:
            return
        self._forget([job])
        if result:
            self._fail(job, result)
        else:
            self._spoken += 1

    def _drop_what_cannot_be(self) -> None:
        """Drop jobs that wait for a missing engine or speaker."""
        speaker = self._opened()
        if speaker.trouble:
            self._forget(dropped := self._jobs.clear())
            for job in dropped:
                self._fail(job, speaker.trouble)
        while self._worker.trouble and (unwritten := self._jobs.to_write()) is not None:
            self._jobs.drop(unwritten)
            self._fail(unwritten, self._worker.trouble)

    def _fail(self, job: Job, why: str) -> None:
        self._failed += 1
        self.ctx.event(
            "speech_failed", f"{job.title} was not {'saved' if job.keep else 'heard'}: {why}", level="warning"
        )

    def _forget(self, jobs: list[Job]) -> None:
        """Remove the files of sounds to be played once."""
        for job in jobs:
            if job.sound is not None and job.sound.path.parent == self._scratch:
                job.sound.path.unlink(missing_ok=True)

    def _greet(self) -> None:
        """Once engine and speaker work: speak the greeting, and synthesise the farewell in advance."""
        if self._greeted or not self._worker.idle or not self._opened().proven:
            return
        self._greeted = True
        if self.ctx.settings.greets:
            self._queue_phrase("hello", None)
            self._queue_phrase("goodbye", self._scratch / "goodbye.wav")

    def _queue_phrase(self, name: str, keep: Path | None) -> None:
        with suppress(InputError):  # the robot may have no such phrase
            found = phrase(self.ctx.rows(Phrase), name, self.ctx.settings.language)
            self._jobs.add(Job(text=found.text, language=found.language, keep=keep, own=True))

    def _play_farewell(self, speaker: Speaker) -> None:
        farewell, self._farewell = self._farewell, None
        if farewell is None or not speaker.proven:
            return
        with suppress(OSError, InputError):
            speaker.start(wav.read(farewell))
            end = time.monotonic() + FAREWELL_S
            while not speaker.immediate and speaker.poll() is None and time.monotonic() < end:
                time.sleep(0.01)

    def _publish_state(self) -> None:
        reason = "; ".join(self._what_is_missing())
        self.ctx.warn(reason, "not_possible") if reason else self.ctx.ready()
        state = self._state(reason)
        now = self.ctx.clock()
        if state != self._published or now >= self._publish_at:
            self._published, self._publish_at = state, now + STATE_EVERY_S
            self.ctx.publish("state", state)

    def _what_is_missing(self) -> Iterator[str]:
        speaker, worker = self._opened(), self._worker
        if not speaker.proven:
            yield speaker.trouble or "the speaker is being tried"
        if worker.trouble or not worker.started:
            yield worker.trouble or "the speech engine is starting"
        elif self._writer.note:
            yield self._writer.note

    def _state(self, reason: str) -> SpeechState:
        saying, device = self._current, self.ctx.device
        return SpeechState(
            speaking=saying is not None and not saying.song,
            text=saying.text[:TEXT_TOLD] if saying else "",
            queued=len(self._jobs),
            spoken=self._spoken,
            failed=self._failed,
            sink=device.address if device else "",
            reason=reason,
            playing=saying.song if saying else "",
        )
