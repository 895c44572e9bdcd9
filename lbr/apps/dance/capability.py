"""Dance as a capability: leases the base, starts the song, moves at each beat, and ends with either of them."""

from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from lbr.apps.dance import metronome, songs
from lbr.apps.dance.choreography import REST, Choreography, Move, beat_at, choose
from lbr.apps.dance.kind import DanceSettings
from lbr.apps.dance.messages import DanceCommand, DanceState, DanceStep
from lbr.apps.dance.music import Music
from lbr.apps.dance.songs import Song
from lbr.capability.base import Capability
from lbr.capability.context import Call, Context
from lbr.errors import InputError
from lbr.leases.client import LeaseTarget
from lbr.leases.holder import Holder
from lbr.messages.codes import Reason, ReasonCode
from lbr.messages.drive import DriveCommand
from lbr.messages.leases import CommandReply, StopCommand

DRIVE = LeaseTarget("motion", "halt", "drive", "the drive does not answer; the base has stopped by itself")
TAKING_POWER = 0.001
"""The power that gets a lease of the drive, as a command of zero gets none. It moves nothing; a stop ends the lease."""
DANCING_HZ, IDLE_HZ = 50.0, 5.0
STATE_EVERY_S = 1.0
RESTING = DanceState(phase="resting")
DANCED = Reason("done", "danced to the end")
ASKED_FOR = frozenset({"done", "stopped"})
"""The codes of an intended end."""


@dataclass(slots=True)
class _Dance:
    """The dance under way; `call` is its command, answered once the song has begun."""

    song: Song
    choreography: Choreography
    holder: Holder
    call: Call | None
    music: Music | None = None
    beat: int = 0
    moves: int = 0


class Dance(Capability[DanceSettings]):
    """Holds the base from before the song begins, so that a stop at any time ends the dance."""

    rate_hz = IDLE_HZ

    def __init__(self, ctx: Context[DanceSettings]) -> None:
        super().__init__(ctx)
        self._music = Path(ctx.home) / "music"
        self._dance: _Dance | None = None
        self._last = self._published = RESTING
        self._publish_at = 0.0

    def open(self) -> None:
        """Write the metronome's song, so that it can be played; without room on the disk, a dance reports it."""
        with suppress(OSError):
            metronome.ensure(self._music)
        self._publish_at = 0.0

    def step(self) -> None:
        """Continue the dance."""
        if self._dance is not None:
            self._go_on(self._dance)
        self.rate_hz = IDLE_HZ if self._dance is None else DANCING_HZ
        self._publish_state()

    def command(self, call: Call) -> None:
        """Answer `play` and `stop`."""
        if isinstance(call.message, DanceCommand):
            try:
                self._begin(call, call.message)
            except InputError as err:
                call.refuse(str(err), err.code)
        elif isinstance(call.message, StopCommand):
            said = f"stopped by {call.source}" + (f": {call.message.reason}" if call.message.reason else "")
            self._end(Reason("stopped", said))
            call.reply(CommandReply(accepted=True, reason="stopped"))
        else:
            super().command(call)
        self._publish_state()

    def close(self) -> None:
        """Stop moving, then the song."""
        self._end(Reason("shutting_down", "dance is shutting down"))

    def _begin(self, call: Call, command: DanceCommand) -> None:
        if self._dance is not None:
            raise InputError(f"'{self._dance.song.name}' is being danced to; stop it first", "busy")
        choreography = choose(self.ctx.rows(DanceStep), command.dance or self.ctx.settings.dance)
        try:
            metronome.ensure(self._music)
        except OSError as err:
            raise InputError(f"{self._music} takes no songs ({err.strerror or err}); check the disk", "failed") from err
        song = songs.load(self._music, command.song)
        self._dance = _Dance(song, choreography, Holder(self.ctx), call)
        self._dance.holder.begin(DRIVE, DriveCommand(power=TAKING_POWER, angle_deg=choreography.at(0).angle_deg))
        self._dance.holder.change(_command(REST))
        self.rate_hz = DANCING_HZ

    def _go_on(self, dance: _Dance) -> None:
        if ended := dance.holder.step():
            self._end(ended)
        elif dance.holder.holds:
            self._follow(dance)

    def _follow(self, dance: _Dance) -> None:
        """Move to the music, once it has begun."""
        if dance.music is None:
            dance.music = Music(self.ctx, dance.song.name, dance.song.duration_s)
        dance.music.step()
        if dance.music.began is None:
            return
        if dance.call is not None:
            self._answer(dance, dance.call)
        since_s = self.ctx.clock() - dance.music.began - self.ctx.settings.delay_s
        beats, beat = dance.song.beats, beat_at(dance.song.beats, since_s)
        if beat >= len(beats) - 1:
            self._end(DANCED)
        elif why := dance.music.cut():
            self._end(why)
        elif not since_s < self.ctx.settings.max_s:
            longest_s = self.ctx.settings.max_s
            self._end(Reason("limit", f"{longest_s:g} s are the longest dance (setting `max_s`)"))
        elif beat >= 0:
            command = _command(dance.choreography.at(beat))
            dance.moves += command != dance.holder.motion
            dance.holder.change(command)
            dance.beat = beat + 1

    def _answer(self, dance: _Dance, call: Call) -> None:
        dance.call = None
        silent = dance.music.silent if dance.music else ""
        without = f", without sound: {silent}" if silent else ""
        text = f"dances {dance.choreography.name} to {dance.song.name}{without}"
        self.ctx.event("dance_began", text, level="warning" if silent else "info", code="done", about=call.source)
        call.reply(CommandReply(accepted=True, reason=text))

    def _end(self, why: Reason) -> None:
        """End the dance."""
        dance, self._dance = self._dance, None
        if dance is None:
            return
        dance.holder.release("the dance is over")
        if dance.music is not None and why.code != "done":
            dance.music.stop()
        if dance.call is not None:
            dance.call.refuse(why)
        else:
            ended = f"the dance to {dance.song.name} ended at beat {dance.beat}: {why}"
            level = "info" if why.code in ASKED_FOR else "warning"
            self.ctx.event("dance_ended", why.text if why.code == "done" else ended, level=level, code=why.code)
        self._last = self._state(dance, "ended", why.text, why.code)
        self._publish_state()

    def _state(self, dance: _Dance, phase: str, reason: str = "", code: ReasonCode = "") -> DanceState:
        return DanceState(
            phase="ended" if phase == "ended" else "dancing",
            song=dance.song.name,
            dance=dance.choreography.name,
            beat=dance.beat,
            beats=len(dance.song.beats),
            moves=dance.moves,
            reason=reason,
            code=code,
        )

    def _publish_state(self) -> None:
        silent = self._dance.music.silent if self._dance and self._dance.music else ""
        state = self._state(self._dance, "dancing", silent) if self._dance else self._last
        now = self.ctx.clock()
        if state != self._published or now >= self._publish_at:
            self._published, self._publish_at = state, now + STATE_EVERY_S
            self.ctx.publish("state", state)


def _command(move: Move) -> DriveCommand:
    return DriveCommand(power=move.power, angle_deg=move.angle_deg)
