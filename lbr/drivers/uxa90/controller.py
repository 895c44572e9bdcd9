"""The main board: PC control taken and kept, and its own motions started and ended. Lives in the loop's thread."""

from collections.abc import Callable, Mapping

from lbr.drivers.mover import Mover
from lbr.drivers.owner import STOP, WRITE, Owner
from lbr.drivers.uxa90 import Uxa90Settings, frames, mode, packets, plays
from lbr.drivers.uxa90.bus import Bus
from lbr.drivers.uxa90.frames import CONTROL, TAKE_CONTROL, Frame
from lbr.drivers.uxa90.mode import Mode
from lbr.drivers.uxa90.outputs import Outputs
from lbr.drivers.uxa90.plays import Plays
from lbr.messages.servos import ServoGoal, StoredPlay


class Controller:
    """`step` it after each look at the mover. `passes`: servos may be told and asked."""

    def __init__(
        self, owner: Owner[Bus], outputs: Outputs, settings: Uxa90Settings, clock: Callable[[], float], known: Plays
    ) -> None:
        self.mode = Mode()
        self.plays = plays.reopened(known, "the line was opened anew")
        self._owner = owner
        self._outputs = outputs
        self._settings = settings
        self._clock = clock
        self._halts = 0
        self._followed = False

    @property
    def passes(self) -> bool:
        """Whether the main board passes packets on, and moves nothing itself."""
        return self.mode.pc and not self.occupied

    @property
    def occupied(self) -> bool:
        """Whether it plays, or is about to."""
        return self.plays.phase in {"waiting", "playing", "ending"}

    @property
    def left_s(self) -> float:
        """How long what it plays takes still."""
        return max(0.0, self.plays.until - self._clock())

    def hear(self, frame: Frame) -> None:
        """Take in what it said."""
        if frame.type == CONTROL:
            self.mode = mode.heard(self.mode, self._clock())

    def take(self, *, again: bool = False) -> None:
        """Take PC control, unless that is under way, or done and not asked for `again`."""
        if self.mode.name == "taking" or (self.mode.pc and not again):
            return
        self.mode = mode.taking(self._clock(), self._settings.settle_s)
        self._owner.submit(lambda bus: bus.say(TAKE_CONTROL), STOP, "control")

    def step(self, mover: Mover, asked: StoredPlay | None) -> None:
        """Go on, stop, or start what is asked for."""
        now = self._clock()
        stopped = mover.halts != self._halts or (self._followed and not mover.follows) or mover.estop
        self._halts, self._followed = mover.halts, mover.follows
        if stopped:
            self.interrupt(mover.reason or "it was stopped", mover.goals)
        self.mode = mode.tick(self.mode, now)
        self.plays = plays.seen(self.plays, asked, self._settings.slots, follows=mover.follows)
        if self.plays.wanted:
            self._start(now)
        self.plays = plays.ended(self.plays, now)
        if self.plays.phase == "ending":
            self._end()

    def interrupt(self, reason: str, goals: Mapping[int, ServoGoal]) -> None:
        """End what it plays: PC control is taken, and the servos are held where they are as soon as that is read."""
        moved = self.plays.phase in {"playing", "ending"}
        self.plays = plays.interrupted(self.plays, reason)
        if moved:
            self._outputs.loose(goals)
            self.take(again=True)

    def lost(self) -> None:
        """Nobody answers any more: it may have left PC control by itself."""
        self.mode = mode.left(self._clock())
        self.take()

    def _start(self, now: float) -> None:
        remote = self._settings.stored_by == "remote"
        if self.mode.name == "taking":
            return
        if not remote and not self.mode.pc:
            self.take()
            return
        play = self.plays.asked
        assert play is not None
        data = frames.remote(play.slot) if remote else packets.stored(play.slot)
        self._outputs.open = False
        self._outputs.played(limp=False)
        self.plays = plays.started(self.plays, now)
        if remote:
            self.mode = mode.left(now)
        self._owner.submit(lambda bus: self._say_play(bus, play, data), WRITE, "play")

    def _say_play(self, bus: Bus, play: StoredPlay, data: bytes) -> None:
        """Begin it, unless a stop came while this waited for the line; in the line's thread."""
        if self.plays.busy and self.plays.asked == play:
            bus.say(data)

    def _end(self) -> None:
        if not self.mode.pc:
            self.take()
            return
        self.plays = plays.regained(self.plays)
        self._outputs.played(limp=self.plays.asked is not None and self.plays.asked.limp)
