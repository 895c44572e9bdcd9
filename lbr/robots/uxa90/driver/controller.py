"""The main board: PC control taken and kept, and its own motions started and ended. Lives in the loop's thread."""

from collections.abc import Callable, Mapping

from lbr.drivers.servos.bus_thread import STOP, WRITE, BusThread
from lbr.drivers.servos.gate import ServoGate, first
from lbr.messages.servos import ServoGoal, StoredPlay
from lbr.robots.uxa90.driver import Uxa90Settings, frames, packets, pc_control, stored_motions
from lbr.robots.uxa90.driver.bus import Bus
from lbr.robots.uxa90.driver.frames import CONTROL, TAKE_CONTROL, Frame
from lbr.robots.uxa90.driver.pc_control import PcControl
from lbr.robots.uxa90.driver.stored_motions import StoredMotions
from lbr.robots.uxa90.driver.targets import ServoTargets


class Controller:
    """`step` it after each look at the gate. `passes`: servos may be told and asked."""

    def __init__(
        self,
        thread: BusThread[Bus],
        targets: ServoTargets,
        settings: Uxa90Settings,
        clock: Callable[[], float],
        known: StoredMotions,
    ) -> None:
        self.mode = PcControl()
        self.plays = stored_motions.reopened(known, "the line was reopened")
        self._thread = thread
        self._targets = targets
        self._settings = settings
        self._clock = clock
        self._gate = first(clock())

    @property
    def passes(self) -> bool:
        """Return whether the main board passes packets on, and moves nothing itself."""
        return self.mode.pc and not self.occupied

    @property
    def occupied(self) -> bool:
        """Return whether it plays, or is about to."""
        return self.plays.phase in {"waiting", "playing", "ending"}

    @property
    def left_s(self) -> float:
        """Return how long what it plays takes still."""
        return max(0.0, self.plays.until - self._clock())

    def hear(self, frame: Frame) -> None:
        """Take in what it said."""
        if frame.type == CONTROL:
            self.mode = pc_control.heard(self.mode, self._clock())

    def take(self, *, again: bool = False) -> None:
        """Take PC control, unless that is under way, or done and not asked for `again`."""
        if self.mode.name == "taking" or (self.mode.pc and not again):
            return
        self.mode = pc_control.taking(self._clock(), self._settings.settle_s)
        self._thread.submit(lambda bus: bus.say(TAKE_CONTROL), STOP, "control")

    def step(self, gate: ServoGate, asked: StoredPlay | None) -> None:
        """Go on, stop, or start what is asked for."""
        now = self._clock()
        before, self._gate = self._gate, gate
        if gate.stopped_since(before) or gate.estop:
            self.interrupt(gate.reason or "it was stopped", gate.goals)
        self.mode = pc_control.tick(self.mode, now)
        self.plays = stored_motions.seen(self.plays, asked, self._settings.slots, follows=gate.follows)
        if self.plays.wanted:
            self._start(now)
        self.plays = stored_motions.ended(self.plays, now)
        if self.plays.phase == "ending":
            self._end()

    def interrupt(self, reason: str, goals: Mapping[int, ServoGoal]) -> None:
        """End what it plays: PC control is taken, and the servos are held where they are as soon as that is read."""
        moved = self.plays.phase in {"playing", "ending"}
        self.plays = stored_motions.interrupted(self.plays, reason)
        if moved:
            self._targets.loose(goals)
            self.take(again=True)

    def lost(self) -> None:
        """Take note that nothing answers: the board may have left PC control by itself."""
        self.mode = pc_control.left(self._clock())
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
        self._targets.open = False
        self._targets.played(limp=False)
        self.plays = stored_motions.started(self.plays, now)
        if remote:
            self.mode = pc_control.left(now)
        self._thread.submit(lambda bus: self._say_play(bus, play, data), WRITE, "play")

    def _say_play(self, bus: Bus, play: StoredPlay, data: bytes) -> None:
        """Begin it, unless a stop came while this waited for the line; in the line's thread."""
        if self.plays.busy and self.plays.asked == play:
            bus.say(data)

    def _end(self) -> None:
        if not self.mode.pc:
            self.take()
            return
        self.plays = stored_motions.regained(self.plays)
        self._targets.played(limp=self.plays.asked is not None and self.plays.asked.limp)
