"""Teleop as a capability: reads the gamepad, leases the drive while its hand drives, and sends stops."""

from math import inf

from lbr.apps.teleop.hand import REST, Hand, Twist, presses
from lbr.apps.teleop.kind import TeleopSettings
from lbr.apps.teleop.lines import Lines
from lbr.capability.base import Capability
from lbr.capability.context import Context
from lbr.errors import DeviceError
from lbr.leases.client import LeaseTarget, PendingReply
from lbr.leases.holder import FINAL, GONE, Holder
from lbr.messages.codes import Reason
from lbr.messages.drive import GoalResult, TwistCommand
from lbr.messages.gamepad import GamepadState, TeleopState
from lbr.messages.leases import StopCommand

DRIVE = LeaseTarget("twist", "halt", "drive", f"the drive: {GONE}")
STATE_EVERY_S, SOONEST_S = 0.5, 0.1
DRIVING_HZ, RESTING_HZ = 50.0, 20.0
STOP_S = 1.0
BY_HAND = "stopped at the gamepad"


class Teleop(Capability[TeleopSettings]):
    """Every action of a gamepad needs its dead-man button, except a stop."""

    rate_hz = RESTING_HZ

    def __init__(self, ctx: Context[TeleopSettings]) -> None:
        super().__init__(ctx)
        self._hand = Hand(ctx.settings)
        self._lines = Lines(ctx)
        self._holder = Holder(ctx)
        self._stops: list[PendingReply] = []
        self._stepped_at = ctx.clock()
        self._why = Reason("idle", "")
        self._ended: Reason | None = None
        self._published: TeleopState | None = None
        self._published_at = -inf

    def open(self) -> None:
        """Refuse a second gamepad: one hand could hold the dead-man button, and the other drive."""
        if len(pads := self.ctx.sources("pad")) > 1:
            text = f"{' and '.join(pads)} are wired to it, and one gamepad drives: let a channel row say which"
            raise DeviceError(text, "wiring")

    def step(self) -> None:
        """Read the gamepad, and move the robot accordingly."""
        now = self.ctx.clock()
        held_up_s, self._stepped_at = now - self._stepped_at, now
        for received in self.ctx.take("pad"):
            assert isinstance(received.message, GamepadState)
            for word in presses(self._hand.receive(received.message, received.arrived), self.ctx.settings):
                self._send(word, now)
        if not held_up_s <= self.ctx.settings.ttl_s:  # its lease has lapsed, and the hand may be gone
            self._hand.let_go()
        if not all(map(self.ctx.alive, self.ctx.sources("pad"))):
            self._hand.lose()
        stands = self._hand.stands(now)
        twist, self._why = (REST, stands) if stands is not None else self._hand.twist()
        self._drive(twist)
        results = [one.message for one in self.ctx.take("results") if isinstance(one.message, GoalResult)]
        self._lines.step(results, stands)
        self._read_stops()
        self.rate_hz = DRIVING_HZ if self._holder.asks or self._lines.moving else RESTING_HZ
        self._publish_state(twist, now)

    def woke(self, slept_s: float) -> None:  # noqa: ARG002 - however long
        """Require a new press of the dead-man button: the person may have left during the sleep."""
        self._hand.let_go()

    def close(self) -> None:
        """Stop all motion."""
        self._holder.release("teleop is shutting down")
        self._lines.halt("teleop is shutting down")

    def _send(self, word: str, now: float) -> None:
        match word:
            case "estop":
                self.ctx.engage_estop(BY_HAND)
            case "stop":
                self._holder.release(BY_HAND)
                self._lines.halt(BY_HAND)
                self._stops.append(self.ctx.ask("stop_all", StopCommand(reason=BY_HAND, whole=True), STOP_S))
            case line:
                self._lines.send(line, self._hand.stands(now))

    def _drive(self, twist: Twist) -> None:
        rests = self._why if twist == REST else None
        ended = self._holder.step(lost=rests)
        if ended is not None and ended is not rests:
            self._lost(ended)
        elif rests is None:
            self._ended = None
            command = TwistCommand(**twist._asdict(), ttl_s=self.ctx.settings.ttl_s)
            if self._holder.asks:
                self._holder.change(command)
            else:
                self._lines.halt("the sticks are used")
                self._holder.begin(DRIVE, command)

    def _lost(self, why: Reason) -> None:
        """End the motion.

        After a stop or a takeover the dead-man button must be pressed again, else the sticks centred.
        """
        self._ended = why
        if why.code in FINAL:
            self._hand.let_go()
        else:
            self._hand.centre()

    def _read_stops(self) -> None:
        """Report stops that were not answered by all."""
        for one in [one for one in self._stops if one.answers() is not None]:
            self._stops.remove(one)
            silent = sorted(name for name, answer in (one.answers() or {}).items() if answer is None)
            if silent:
                text = f"{', '.join(silent)} did not answer the stop of the gamepad"
                self.ctx.event("teleop_stop", text, level="error", code="unreachable")

    def _publish_state(self, twist: Twist, now: float) -> None:
        driving = self._holder.asks
        why = self._ended if self._ended is not None and not driving else self._why
        state = TeleopState(
            pad=self._hand.has_pad,
            dead_man=self._hand.dead_man,
            driving=driving,
            line=self._lines.moving,
            reason=why.text,
            code=why.code,
            **(twist if driving else REST)._asdict(),
        )
        since_s = now - self._published_at
        if since_s >= STATE_EVERY_S or (state != self._published and since_s >= SOONEST_S):
            self._published, self._published_at = state, now
            self.ctx.publish("state", state)
