"""Whatever happens in whatever order: one motion at a time, nothing begins by itself, every player is answered once."""

from itertools import count

from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule

from lbr.leases.lease import EstopChanged, LeaseRequest, Reply, Result, Stop
from lbr.messages.codes import MEANINGS, Reason
from lbr.messages.drive import GoalResult
from lbr.messages.joints import PlayCommand
from lbr.operations.motions.kernel import decide
from lbr.operations.motions.programme import programme
from lbr.operations.motions.state import (
    Abandon,
    Accepted,
    Answer,
    Halt,
    JointsEnded,
    JointsStopped,
    Lost,
    Passed,
    Play,
    Send,
    Tick,
    first_state,
)
from lbr.operations.motions.view import motions_state
from tests.operations.motions.motions_bench import MOTIONS

SOURCES = st.sampled_from(["console", "pad", "laptop"])
PROGRAMMES = {
    (motion, times): programme(MOTIONS, PlayCommand(motion=motion, times=times))
    for motion in ("wave", "walk", "stand", "greet")
    for times in (1, 90)
}
ENDINGS = st.sampled_from(["reached", "stopped", "lapsed", "superseded", "fault"])


class Motions(RuleBasedStateMachine):
    def __init__(self):
        super().__init__()
        self.state = first_state(0.3)
        self.now = 100.0
        self.numbers = count(1)
        self.waiting = 0
        self.borrowed = False
        self.joints_goal = ""
        self.sent = 0
        self.length = 0
        self.stopped = -1.0
        self.leases = [""]
        self.dead: set[str] = set()

    def happens(self, event):
        self.now += 0.001
        self.state, outputs = decide(self.state, event, self.now)
        for output in outputs:
            self.take(event, output)
            if isinstance(output, Reply | Answer):
                assert output.message.accepted or output.message.code in MEANINGS
            elif isinstance(output, Result):
                assert output.message.code in MEANINGS
        return outputs

    def take(self, event, output):
        match output:
            case Send(leg=True):
                assert isinstance(event, JointsEnded), "a leg began before the one before was over"
                assert event.result.result == "reached"
                assert not self.borrowed, "the joints were asked for twice"
                self.borrowed, self.joints_goal = True, ""
                self.sent += len(output.frames) or 1
                assert self.sent <= self.length
            case Send(append=False):
                assert isinstance(event, Play), "a motion began by itself"
                assert event.ask.received > self.stopped, "what was asked for before a stop began after it"
                assert output.asked_s == event.ask.received
                self.waiting += 1
                self.borrowed, self.joints_goal = True, ""
                self.sent, self.length = len(output.frames) or 1, event.programme.length
            case Send():
                assert output.frames
                assert self.borrowed, "key frames for joints that are not borrowed"
                self.sent += len(output.frames)
                assert self.sent <= self.length
            case Answer(message=reply):
                self.waiting -= 1
                assert self.waiting >= 0, "somebody was answered who did not wait"
                if reply.accepted:
                    self.leases.append(reply.lease)
            case Reply(message=reply) if reply.accepted and reply.lease:
                self.leases.append(reply.lease)
            case Halt() | Abandon():
                self.borrowed = False
            case Result(message=result):
                assert result.reason

    @rule(
        source=SOURCES,
        motion=st.sampled_from(["wave", "walk", "stand", "greet", "waves"]),
        times=st.sampled_from([1, 90]),
        lease=st.integers(-3, 0),
        take_over=st.booleans(),
        remote=st.booleans(),
        late_s=st.sampled_from([0.0, 0.0, 0.05, 1.0]),
        trouble=st.sampled_from([None, None, Reason("unreachable", "joints operation is not running")]),
    )
    def play(self, source, motion, times, lease, take_over, remote, late_s, trouble):
        number = next(self.numbers)
        known = (motion, times) in PROGRAMMES
        received = self.now + 0.001 - late_s
        quoted = self.leases[max(lease, -len(self.leases))] if lease else ""
        ask = LeaseRequest(
            source=source,
            lease=quoted,
            content=(motion, times),
            moves=True,
            received=received,
            new_lease=f"lease-{number}",
            take_over=take_over,
            remote=remote,
            sender_s=received - 50.0,
        )
        wanted = PROGRAMMES.get((motion, times))
        reason = None if known else Reason("unknown_name", "there is no such motion")
        event = Play(ask=ask, programme=wanted, new_goal=f"goal-{number}", reason=reason, trouble=trouble)
        outputs = self.happens(event)
        answered = sum(isinstance(one, Reply) for one in outputs)
        begun = sum(isinstance(one, Send) and not one.append for one in outputs)
        assert answered + begun == 1
        assert not (begun and (trouble or not known))
        assert not (begun and quoted in self.dead), "a lease that was stopped or lost began something"

    def die(self):
        """Note the leases that are worth nothing any more, whatever is quoted later."""
        known = (self.state.lease, *self.state.leases.offers)
        self.dead |= {one.id for one in known if one is not None}

    @rule(source=SOURCES)
    def stop(self, source):
        self.die()
        self.stopped = self.now + 0.001
        outputs = self.happens(Stop(source=source, received=self.stopped))
        assert self.state.lease is None
        assert any(isinstance(one, Reply) and one.message.accepted for one in outputs)

    @rule(engaged=st.booleans())
    def emergency_stop(self, engaged):
        self.die()
        self.stopped = self.now + 0.001
        self.happens(EstopChanged(engaged=engaged, reason="test"))
        assert self.state.lease is None

    @rule()
    def joints_were_stopped(self):
        self.die()
        self.stopped = self.now + 0.001
        self.happens(JointsStopped(at=self.stopped, why=Reason("stopped", "stopped by phone")))
        assert self.state.leases.offers == ()

    @rule()
    def granted(self):
        if self.borrowed:
            self.joints_goal = f"joints-{next(self.numbers)}"
        self.happens(Accepted(goal=self.joints_goal))

    @rule()
    def lost(self):
        self.dead |= {self.state.lease.id} if self.state.lease is not None else set()
        self.happens(Lost(why=Reason("unreachable", "the joints do not answer")))

    @rule(how=ENDINGS, ours=st.booleans())
    def joints_ended(self, how, ours):
        before, sent = self.state.lease, self.sent
        goal = self.joints_goal if ours else "somebody's"
        self.happens(JointsEnded(result=GoalResult(goal=goal, result=how, reason="so it was", elapsed_s=1.0)))
        if before is not None and not before.motion.asked and ours and goal == before.motion.joints_goal:
            assert self.state.lease is None or self.sent > sent

    @rule(frames=st.integers(0, 300))
    def passed(self, frames):
        self.happens(Passed(goal=self.joints_goal, frames=frames))

    @rule(seconds=st.sampled_from([0.01, 0.1, 0.31, 2.0]))
    def time_goes_by(self, seconds):
        self.now += seconds
        self.happens(Tick())
        if seconds >= 2.0:
            assert self.state.lease is None
            assert self.waiting == 0

    @rule()
    def the_clock_goes_back(self):
        self.now -= 10.0
        self.leases = [""]
        if self.now + 0.001 < self.state.clock:
            self.stopped = self.now + 0.001
        self.happens(Tick())
        assert self.state.lease is None

    @invariant()
    def who_holds_has_the_joints_or_waits_for_them(self):
        hold = self.state.lease
        assert self.waiting == (hold is not None and hold.motion.asked)
        assert self.borrowed == (hold is not None)
        told = motions_state(self.state)
        assert told.playing == (hold is not None and not hold.motion.asked)
        assert not (self.state.leases.estop and hold is not None)


TestMotions = Motions.TestCase
TestMotions.settings = settings(stateful_step_count=25)
