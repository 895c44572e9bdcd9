"""The decisions of motions, as a pure function of state, event and time."""

from math import inf

from msgspec.structs import replace

from lbr.leases import decide as leasing
from lbr.leases import ending, rules
from lbr.leases.ask import Ask, resolve
from lbr.leases.lease import Ended, Ending, EstopChanged, Happened, Lease, Stop
from lbr.messages.codes import Reason, heard
from lbr.messages.drive import GoalResult
from lbr.messages.joints import MAX_FRAMES
from lbr.messages.leases import refused
from lbr.operations.motions.state import (
    Abandon,
    Accepted,
    Answer,
    Event,
    Fell,
    Halt,
    JointsEnded,
    JointsStopped,
    Lost,
    Outputs,
    Passed,
    Play,
    Playing,
    Send,
    State,
    Tick,
)
from lbr.operations.results import goal_result

Decision = tuple[State, Outputs]
ANSWER_S = 1.5
"""The wait of a motion for joints operation to answer; its own lease counts from then on."""
AHEAD_S = 4.0
"""The duration of motion sent ahead: enough for any pause of this process, little enough to compute."""
AHEAD_FRAMES = MAX_FRAMES // 2
"""The limit of frames ahead, however short they are: the joints accept no more than `MAX_FRAMES`."""
GRACE_S = 0.2
"""The delay after the end of their lease by which the result of the joints may arrive."""
ENDINGS: dict[str, Ending] = {"stopped": "stopped", "superseded": "superseded"}


def decide(state: State, event: Event, now: float) -> Decision:
    """Return the state after an event, and the outputs; what is over by `now` ends before the event counts."""
    if now >= state.clock:
        held, reports = ending.lapse(state.leases, now)
    else:
        held, reports = ending.lose_time(state.leases, state.clock, now)
    state, outputs = _take(replace(state, leases=held, clock=now), reports, now)
    state, more = _handle(state, event, now)
    state, fed = _feed(state, now)
    return state, outputs + more + fed


def _handle(state: State, event: Event, now: float) -> Decision:
    match event:
        case Play():
            state, ended = _late(state, now, 0.0)  # with its joints lost a lease begins nothing else
            state, outputs = _play(state, event, now)
            decision = state, ended + outputs
        case Stop():
            held, reports = leasing.stop(state.leases, event, now)
            state, outputs = _take(replace(state, leases=held), reports, now)
            decision = state, (*_halted(outputs, event), leasing.STOPPED)
        case EstopChanged():
            held, reports = leasing.latch(state.leases, event, now)
            decision = _take(replace(state, leases=held), reports, now)
        case Accepted():
            decision = _accepted(state, event, now)
        case Lost():
            decision = _lost(state, event, now)
        case JointsEnded(result=result):
            decision = _joints_ended(state, result, now)
        case JointsStopped():
            decision = _joints_stopped(state, event, now)
        case Passed() | Fell():
            decision = _noticed(state, event, now)
        case Tick():
            decision = _late(state, now)
    return decision


def _play(state: State, event: Play, now: float) -> Decision:
    ask = resolve(state.leases, event.ask, now)
    if why := _refusal(ask, event):
        held, refusal = leasing.refuse(ask, why)
        return replace(state, leases=held), (refusal,)
    if ask.wants == "renewal":
        held = leasing.renew(ask)
        lease = leasing.lent(held, ask)
        return replace(state, leases=held), (leasing.accepted(lease, goal=lease.motion.goal),)
    assert event.programme is not None, "the chain refuses what cannot be played"
    playing = Playing(goal=event.new_goal, programme=event.programme, started=now)
    if ask.wants == "offer":
        held, said = leasing.grant(state.leases, ask, playing)
        state, outputs = _take(replace(state, leases=held), said, now)
        return state, (*outputs, leasing.accepted(leasing.lent(held, ask), goal=playing.goal))
    return _begin(state, ask, playing)


def _refusal(ask: Ask[Playing], event: Play) -> Reason | None:
    """Return why a command is refused, or None."""
    return (
        rules.form(ask)
        or _busy(ask.leases.live, ask.request.lease, take_over=ask.request.take_over)
        or rules.holder(ask)
        or rules.at_rest(ask, event.trouble)
        or (None if ask.wants == "renewal" else event.reason)
    )


def _busy(lease: Lease[Playing] | None, lease_id: str, *, take_over: bool) -> Reason | None:
    """Refuse a second motion."""
    if lease is None or lease_id or take_over:
        return None
    why = f"busy: '{lease.motion.programme.motion.name}' is played by {lease.source}; stop it, or take over"
    return Reason("busy", why)


def _begin(state: State, ask: Ask[Playing], playing: Playing) -> Decision:
    """Send the first key frames to the joints; the reply to the player waits for theirs."""
    if ask.confirms is not None:
        playing = replace(playing, goal=ask.confirms.motion.goal)
    before, now = state.lease, ask.now
    held, said = leasing.grant(state.leases, ask, playing)
    state, outputs = _take(replace(state, leases=held), said, now, goes_on=True)
    assert state.lease is not None
    if ask.wants == "change" and before is not None and before.motion.asked:
        outputs = (*outputs, Answer(message=refused(leasing.ANOTHER)))
    send = _leg(playing, 0)
    state = _with(state, replace(playing, sent=len(send.frames) or 1), expires=now + ANSWER_S)
    return state, (*outputs, replace(send, asked_s=ask.request.received, take_over=ask.request.take_over))


def _next_leg(state: State, playing: Playing, now: float) -> Decision:
    """Continue after the joints have come to rest, with the next part, which they cannot join to the last."""
    send = replace(_leg(playing, playing.sent), asked_s=now, leg=True)
    sent = playing.sent + (len(send.frames) or 1)
    playing = replace(playing, leg=playing.sent, passed=playing.sent, sent=sent, joints_goal="")
    return _with(state, replace(playing, lost=None, lost_at=inf)), (Abandon(), send)


def _leg(playing: Playing, start: int) -> Send:
    programme = playing.programme
    stored = programme.stored(start)
    return Send(frames=programme.portion(start), append=False, mirror=programme.mirror, stored=stored)


def _accepted(state: State, event: Accepted, now: float) -> Decision:
    lease = state.lease
    if lease is None or not (lease.motion.asked or not lease.motion.joints_goal):
        return state, ()
    if not lease.motion.asked:
        return _with(state, replace(lease.motion, joints_goal=event.goal)), ()
    playing = replace(lease.motion, asked=False, joints_goal=event.goal, started=now)
    state = _with(state, playing, expires=now + lease.ttl_s)
    return state, (Answer(message=leasing.accepted(lease, event.note, playing.goal).message),)


def _lost(state: State, event: Lost, now: float) -> Decision:
    lease = state.lease
    if lease is None:
        return state, ()
    state = _with(state, replace(lease.motion, lost=event.why, lost_at=now))
    return _end(state, "fault", event.why, now) if lease.motion.asked else (state, ())


def _late(state: State, now: float, grace_s: float = GRACE_S) -> Decision:
    """End a motion that lost the joints, if their own result has not arrived."""
    lease = state.lease
    if lease is None or not now - lease.motion.lost_at >= grace_s:
        return state, ()
    lost = lease.motion.lost
    assert lost is not None
    return _end(state, "stopped" if lost.code == "stopped" else "fault", lost, now)


def _joints_ended(state: State, result: GoalResult, now: float) -> Decision:
    lease = state.lease
    if lease is None or lease.motion.asked or result.goal != lease.motion.joints_goal:
        return state, ()
    playing = lease.motion
    if result.result != "reached":
        why = heard(result.code, result.reason or result.result, result.cause)
        state = _with(state, replace(playing, lost=why))
        return _end(state, ENDINGS.get(result.result, "fault"), why, now)
    if playing.sent < playing.programme.leg_end(playing.leg):
        late = Reason("late", "the joints came to the end of what was sent before more of it was")
        return _end(state, "fault", late, now)
    if playing.sent < playing.programme.length:
        return _next_leg(state, playing, now)
    state = _with(state, replace(playing, passed=playing.sent))
    return _end(state, "reached", _played(playing, result, now), now)


def _joints_stopped(state: State, event: JointsStopped, now: float) -> Decision:
    """End earlier motions and offers after a stop of the joints themselves."""
    held = state.leases
    earlier = tuple(offer for offer in held.offers if not offer.asked_s > event.at)
    held = replace(held, stopped=max(held.stopped, min(event.at, now)))
    held, said = ending.drop_offers(held, earlier, "stopped", event.why)
    state, outputs = _take(replace(state, leases=held), said, now)
    lease = state.lease
    if lease is None or lease.asked_s > event.at:
        return state, outputs
    state, ended = _end(_with(state, replace(lease.motion, lost=event.why)), "stopped", event.why, now)
    return state, outputs + ended


def _played(playing: Playing, result: GoalResult, now: float) -> Reason:
    """Return the reason of a completed motion, with the joints' note."""
    programme = playing.programme
    times = f"{programme.times} times " if programme.times > 1 else ""
    text = f"'{programme.motion.name}' was played {times}to its end in {now - playing.started:.1f} s"
    but = f", but {result.note}" if result.note else ""
    return Reason("done", text + but, cause=result.cause, note=result.note)


def _noticed(state: State, event: Passed | Fell, now: float) -> Decision:
    if isinstance(event, Passed):
        return _passed(state, event), ()
    why = Reason("fallen", f"the robot has fallen, it lies {event.how}")
    if state.lease is None:  # its motion is over, but the joints may be stepping to its feet
        return state, (Halt(why=why.text, at_once=True),)
    return _end(state, "fault", why, now)


def _passed(state: State, event: Passed) -> State:
    lease = state.lease
    if lease is None or lease.motion.asked or event.goal != lease.motion.joints_goal:
        return state
    passed = min(max(lease.motion.passed, lease.motion.leg + event.frames), lease.motion.sent)
    return state if passed == lease.motion.passed else _with(state, replace(lease.motion, passed=passed))


def _feed(state: State, now: float) -> Decision:
    """Send more key frames if some remain and too few lie ahead."""
    lease = state.lease
    if lease is None or lease.motion.asked or lease.motion.lost or not now < lease.expires:
        return state, ()
    playing = lease.motion
    enough = _ahead_s(playing) >= AHEAD_S or playing.sent - playing.passed > AHEAD_FRAMES
    if playing.sent >= playing.programme.leg_end(playing.leg) or enough:
        return state, ()
    frames = playing.programme.portion(playing.sent)
    more = Send(frames=frames, append=True, mirror=playing.programme.mirror)
    return _with(state, replace(playing, sent=playing.sent + len(frames))), (more,)


def _ahead_s(playing: Playing) -> float:
    return sum(playing.programme.at(index).duration_s for index in range(playing.passed, playing.sent))


def _end(state: State, how: Ending, why: Reason, now: float) -> Decision:
    held, said = ending.end(state.leases, how, why, now)
    return _take(replace(state, leases=held), said, now)


def _take(state: State, said: ending.Endings[Playing], now: float, *, goes_on: bool = False) -> Decision:
    """Return the outputs for ended leases; `goes_on`: another motion begins at once with the same joints."""
    outputs: Outputs = ()
    for one in said:
        outputs += (one,) if isinstance(one, Happened) else _ended(one, now, goes_on=goes_on)
    return state, outputs


def _ended(ended: Ended[Playing], now: float, *, goes_on: bool) -> Outputs:
    playing = ended.lease.motion
    end = goal_result(ended, playing.goal, playing.started, now)
    if not ended.held:
        return (end,)
    halt = Halt(why=ended.why.text, lost=ended.how == "lapsed", at_once=ended.why.code == "fallen")
    joints: Outputs = (Abandon(),) if ended.how == "reached" or playing.lost else (halt,)
    joints = () if goes_on else joints
    if playing.asked:
        return (*joints, Answer(message=refused(ended.why)))
    kind = "played" if ended.how == "reached" else ended.how
    return (*joints, end, ending.happened(ended, kind))


def _halted(outputs: Outputs, event: Stop) -> Outputs:
    """Return the outputs with the sender of the stop; it may reach the joints by other ways too, and more than once."""
    by = event.by or event.source
    halts = tuple(replace(one, by=by) if isinstance(one, Halt) else one for one in outputs)
    sent = any(isinstance(one, Halt | Abandon) for one in halts)
    return halts if sent or event.lost else (Halt(why=f"stopped by {by}", by=by), *halts)


def _with(state: State, playing: Playing, *, expires: float | None = None) -> State:
    held = leasing.with_motion(state.leases, playing)
    if expires is not None and held.live is not None:
        held = replace(held, live=replace(held.live, expires=expires))
    return replace(state, leases=held)
