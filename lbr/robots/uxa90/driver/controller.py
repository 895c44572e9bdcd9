"""The main board: PC control taken and kept, and its own motions started and ended. Lives in the loop's thread."""

from collections.abc import Callable, Mapping

from lbr.drivers.servos.bus_thread import STOP, WRITE, BusThread
from lbr.drivers.servos.gate import ServoGate, first
from lbr.messages.codes import ReasonCode
from lbr.messages.servos import ServoGoal, StoredPlay
from lbr.robots.uxa90.driver import Uxa90Settings, frames, packets, pc_control, stored_motions
from lbr.robots.uxa90.driver.bus import Bus
from lbr.robots.uxa90.driver.frames import CONTROL, TAKE_CONTROL, Frame
from lbr.robots.uxa90.driver.pc_control import PcControl
from lbr.robots.uxa90.driver.stored_motions import StoredMotions
from lbr.robots.uxa90.driver.targets import ServoTargets


class Controller:
    """The control of the main board; call `step` after each step of the gate. `passes`: servos can get packets."""

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
        """Return the remaining time of its motion."""
        return max(0.0, self.plays.until - self._clock())

    def hear(self, frame: Frame) -> None:
        """Process a frame."""
        if frame.type == CONTROL:
            self.mode = pc_control.answered_frame(self.mode, self._clock())

    def take(self, *, again: bool = False) -> None:
        """Take PC control, unless that is in progress, or done and not requested `again`."""
        if self.mode.name == "taking" or (self.mode.pc and not again):
            return
        self.mode = pc_control.taking(self._clock(), self._settings.settle_s)
        self._thread.submit(lambda bus: bus.say(TAKE_CONTROL), STOP, "control")

    def step(self, gate: ServoGate, asked: StoredPlay | None) -> None:
        """Continue, stop, or start the requested motion."""
        now = self._clock()
        before, self._gate = self._gate, gate
        if gate.stopped_since(before) or gate.estop:
            self.interrupt(gate.reason or "it was stopped", gate.goals, gate.code)
        self.mode = pc_control.tick(self.mode, now)
        self.plays = stored_motions.seen(self.plays, asked, self._settings.slots, follows=gate.follows)
        if self.plays.wanted:
            self._start(now)
        self.plays = stored_motions.ended(self.plays, now)
        if self.plays.phase == "ending":
            self._end()

    def interrupt(self, reason: str, goals: Mapping[int, ServoGoal], code: ReasonCode = "") -> None:
        """End its motion: take PC control, and hold the servos at their position as soon as that is read."""
        moved = self.plays.phase in {"playing", "ending"}
        self.plays = stored_motions.interrupted(self.plays, reason, code)
        if moved:
            self._targets.loose(goals)
            self.take(again=True)

    def lost(self) -> None:
        """Note that nothing answers: the board may have left PC control by itself."""
        self.mode = pc_control.normal(self._clock())
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
            self.mode = pc_control.normal(now)
        self._thread.submit(lambda bus: self._say_play(bus, play, data), WRITE, "play")

    def _say_play(self, bus: Bus, play: StoredPlay, data: bytes) -> None:
        """Start it, unless a stop came while this waited for the line; in the line's thread."""
        if self.plays.busy and self.plays.asked == play:
            bus.say(data)

    def _end(self) -> None:
        if not self.mode.pc:
            self.take()
            return
        self.plays = stored_motions.regained(self.plays)
        self._targets.played(limp=self.plays.asked is not None and self.plays.asked.limp)
