"""Motions as a capability: every decision is the kernel's, every message passes here."""

from math import inf

from msgspec.structs import replace

from lbr.capability.context import Call, Context
from lbr.errors import InputError
from lbr.leases.lease import LeaseRequest
from lbr.messages.codes import Reason
from lbr.messages.joints import (
    MAX_FRAMES,
    CaptureCommand,
    Joint,
    JointsCommand,
    JointsState,
    KeyFrame,
    Motion,
    MotionRow,
    MotionsState,
    MotionStep,
    PlayCommand,
    motions_of,
)
from lbr.messages.leases import CommandReply
from lbr.operations.lender import LeasingCapability, new_goal, origin_of
from lbr.operations.motions import MotionsSettings, fall
from lbr.operations.motions.joints_client import JointsClient
from lbr.operations.motions.kernel import decide
from lbr.operations.motions.pose import key_frame, reach_s
from lbr.operations.motions.programme import Programme, programme
from lbr.operations.motions.state import (
    Abandon,
    Answer,
    Event,
    Fell,
    Halt,
    Output,
    Outputs,
    Play,
    Send,
    State,
    Tick,
    first_state,
)
from lbr.operations.motions.view import motions_state

STATE_PERIOD_S = 0.5
OLDEST_S = 0.5
PLAYING_HZ, IDLE_HZ = 50.0, 10.0
"""The rates of rounds; commands and the joints' messages wake the process anyway."""


class Motions(LeasingCapability[MotionsSettings, State]):
    """Plays the motions of the rows through the joints, for their lease's holder, and captures poses made by hand."""

    ends, tick = "motions are shutting down", Tick()
    feeds = ("joints", "attitude")
    rate_hz = IDLE_HZ

    def __init__(self, ctx: Context[MotionsSettings]) -> None:
        super().__init__(ctx)
        self.begin()

    def open(self) -> None:
        """Start with nothing played."""
        self.begin()
        self.listen()

    def step(self) -> None:
        """Process arrived messages, and continue to play."""
        self.listen()
        self.happen(Tick())
        self.report()
        self.rate_hz = IDLE_HZ if self._state.lease is None and self._player is None else PLAYING_HZ

    def lend(self, call: Call) -> None:
        """Handle `play` and `capture`."""
        if isinstance(call.message, PlayCommand):
            self._play(call, call.message)
        elif isinstance(call.message, CaptureCommand):
            try:
                call.reply(CommandReply(accepted=True, reason=self._capture(call.message, call.source)))
            except InputError as err:
                call.refuse(str(err), err.code)
        else:
            super().lend(call)

    def close(self) -> None:
        """Make the joints hold."""
        super().close()
        self._follower.halt(self.ends)

    def begin(self) -> None:
        """Start without a lease."""
        super().begin()
        self._follower = JointsClient(self.ctx, self.happen)
        self._fall = fall.Fall()
        self._player: Call | None = None
        self._reported: MotionsState | None = None
        self._reported_at = -inf

    def first(self) -> State:
        """Return the state before any motion."""
        return first_state(self.ctx.settings.ttl_s, self.ctx.clock())

    def decide(self, event: Event, now: float) -> tuple[State, Outputs]:
        """Return the kernel's decision on an event."""
        return decide(self._state, event, now)

    def hear(self) -> None:
        """Process the joints' messages, and detect a fall."""
        self._follower.step()
        newest = self.ctx.latest("attitude")
        before, now = self._fall.lies, self.ctx.clock()
        if newest is None:
            return
        self._fall = fall.seen(self._fall, newest.message, now)
        if self._fall.lies and not before:
            how = fall.ON[self._fall.lies]
            self.ctx.event("fallen", f"{self.ctx.robot} has fallen, it lies {how}", level="warning", code="fallen")
            self.happen(Fell(how=how))
        elif before and not self._fall.lies:
            self.ctx.event("upright", f"{self.ctx.robot} is upright again", code="done")

    def not_at_rest(self) -> str:
        """Return an empty string: the joints move, and acknowledge the stop themselves."""
        return ""

    def trouble(self) -> Reason | None:
        """Return why the joints would not follow, or None."""
        return self._follower.trouble

    def pass_on(self, output: Output, call: Call | None) -> None:
        """Publish an output, reply, or send a command to the joints."""
        match output:
            case Answer(message=reply):
                self._answer(reply)
            case Send():
                self._send(output, call)
            case Halt(why=why, lost=lost, by=by, at_once=at_once):
                self._follower.halt(why, lost=lost, by="" if by == self.ctx.name else by, at_once=at_once)
            case Abandon():
                self._follower.abandon()
            case _:
                super().pass_on(output, call)

    def _play(self, call: Call, command: PlayCommand) -> None:
        wanted: Programme | None = None
        why: Reason | None = None
        try:
            wanted = programme(self._motions(), command)
            why = fall.refusal(self._fall, command.motion)
        except InputError as err:
            why = Reason(err.code, str(err))
        event = Play(
            ask=_ask(call, command),
            programme=wanted,
            new_goal=new_goal(),
            reason=why,
            trouble=self._follower.trouble,
        )
        self.happen(event, call)

    def _motions(self) -> tuple[Motion, ...]:
        """Return the motions as they are now."""
        return motions_of(self.ctx.rows(MotionRow), self.ctx.rows(MotionStep))

    def _from_here(self, frames: tuple[KeyFrame, ...], *, mirror: bool) -> tuple[KeyFrame, ...]:
        """Return key frames with enough time to the first, so that no joint is too slow for it."""
        newest = self.ctx.latest("joints")
        if newest is None or not frames:
            return frames
        way_s = reach_s(self.ctx.rows(Joint), newest.message, frames[0], mirror=mirror)
        return (replace(frames[0], duration_s=max(frames[0].duration_s, way_s)), *frames[1:])

    def _capture(self, command: CaptureCommand, source: str) -> str:
        """Store the present pose; raise InputError if it is unknown."""
        if self._state.lease is not None:
            raise InputError(f"'{self._state.lease.motion.programme.motion.name}' is being played; stop it first")
        newest = self.ctx.latest("joints")
        if newest is None or not newest.age_s(self.ctx.clock()) <= OLDEST_S:
            raise InputError("the joints have not been reported for a while; see /report/joints")
        state: JointsState = newest.message
        motion = next((motion for motion in self._motions() if motion.name == command.motion), None)
        if motion is not None and (motion.builtin or motion.slot is not None):
            raise InputError(f"motion '{command.motion}' stays as it is; capture under another name")
        known = motion.frames if motion is not None else ()
        if len(known) >= MAX_FRAMES:
            raise InputError(f"motion '{command.motion}' has {MAX_FRAMES} key frames, the most there can be")
        frame = key_frame(self.ctx.rows(Joint), state, command.duration_s)
        last = max((step.step for step in self.ctx.rows(MotionStep) if step.motion == command.motion), default=0)
        new = () if motion is not None else (MotionRow(name=command.motion, help=command.help),)
        step = MotionStep(motion=command.motion, step=last + 1, duration_s=frame.duration_s, positions=frame.positions)
        self.ctx.learn(*new, step)
        text = f"key frame {len(known) + 1} of '{command.motion}' is the pose of now"
        self.ctx.event("captured", f"{source}: {text}", about=source)
        return text

    def _answer(self, reply: CommandReply) -> None:
        player, self._player = self._player, None
        if player is not None:
            player.reply(reply)

    def _send(self, output: Send, call: Call | None) -> None:
        frames = output.frames if output.append else self._from_here(output.frames, mirror=output.mirror)
        command = JointsCommand(
            frames=frames,
            stored=output.stored,
            mirror=output.mirror,
            append=output.append,
            asked_s=output.asked_s,
            take_over=output.take_over,
        )
        if output.append:
            self._follower.append(command)
        else:
            self._player = self._player if output.leg else call
            self._follower.follow(command)

    def report(self) -> None:
        """Publish the state twice a second, and at once when it changed."""
        now = self.ctx.clock()
        state = replace(motions_state(self._state), fallen=self._fall.lies)
        bare = replace(state, left_s=None)  # alone it is no change
        if bare != self._reported or not now - self._reported_at < STATE_PERIOD_S:
            self._reported, self._reported_at = bare, now
            self.ctx.publish("state", state)


def _ask(call: Call, command: PlayCommand) -> LeaseRequest:
    return LeaseRequest(
        content=(command.motion, command.times, command.speed, command.mirror),
        moves=True,
        lease=command.lease,
        take_over=command.take_over,
        ttl_s=command.ttl_s,
        **origin_of(call),
    )
