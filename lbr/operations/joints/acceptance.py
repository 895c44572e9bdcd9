"""The chain of checks before a motion command moves a joint; the first objection refuses it."""

from collections.abc import Callable, Collection, Iterator
from itertools import islice
from math import isfinite

from msgspec.structs import replace

from lbr.leases import rules
from lbr.leases.ask import Ask, quoted, resolve
from lbr.leases.lease import LeaseRequest
from lbr.messages.codes import Reason
from lbr.messages.joints import MAX_FRAMES, JointsCommand, StoredMotion
from lbr.operations.joints import planning, stored, torque
from lbr.operations.joints.move import Move
from lbr.operations.joints.request import JointsRequest, asked, empty, named, strengths
from lbr.operations.joints.state import NOT_ADOPTED, Command, State, joint_trouble, servos_trouble

MOST_NAMED = 3
LONGEST_S = 60.0
LONGEST_STORED_S = 600.0
TORQUE_FIRST = "torque on first (/torque/on)"

Link = Callable[[State, JointsCommand, Ask[Move]], Reason | None]


def asked_of(state: State, event: Command, now: float) -> Ask[Move]:
    """Return a command as a request to the leases; an empty command repeats the motion of its lease."""
    command = event.command
    received = event.received if command.asked_s is None else min(event.received, command.asked_s)
    request = LeaseRequest(
        **event.origin() | {"received": received},
        lease=command.lease,
        content=asked(command, event.new_goal),
        moves=True,
        take_over=command.take_over,
        ttl_s=command.ttl_s,
    )
    lease = quoted(state.leases, request) if empty(command) else None
    return resolve(state.leases, replace(request, content=lease.content) if lease is not None else request, now)


def command_of(ask: Ask[Move]) -> JointsCommand:
    """Return the requested motion."""
    assert isinstance(ask.request.content, JointsRequest)
    return ask.request.content.command


def refusal(state: State, ask: Ask[Move]) -> Reason | None:
    """Return why a command is refused, or None; a renewal passes fewer checks."""
    command = command_of(ask)
    links = RENEWAL if ask.wants == "renewal" else CHAIN
    return next((why for link in links if (why := link(state, command, ask))), None)


def _form(state: State, command: JointsCommand, ask: Ask[Move]) -> Reason | None:
    """Check the content: something must move, all joints must exist, and all numbers be finite and within limits."""
    if empty(command) and ask.request.lease:
        return None  # its lease is dead; the next link refuses it
    if command.stored is not None:
        return _stored_form(state, command, command.stored)
    if not (command.positions or command.append or any(frame.positions for frame in command.frames)):
        return Reason("bad_value", "there is nothing to move: give positions or frames")
    return _combination(command) or _numbers(command) or _several(_wrong(state, command))


def _leases(state: State, command: JointsCommand, ask: Ask[Move]) -> Reason | None:
    """Check that one sender holds the joints, and that the command is in time."""
    del state, command
    return rules.form(ask) or rules.holder(ask)


def _busy(state: State, command: JointsCommand, ask: Ask[Move]) -> Reason | None:
    """Refuse other motion while the controller plays, except for a take-over, which ends that."""
    del command
    lease, request = state.leases.live, ask.request
    foreign = lease is not None and request.lease != lease.id
    if lease is None or (foreign and (request.lease or request.take_over)):
        return None
    why = stored.busy(state, ask.now)
    return Reason("busy", f"{why}, held by {lease.source}") if why and foreign else why


def _order(state: State, command: JointsCommand, ask: Ask[Move]) -> Reason | None:
    """Refuse to append without a motion, or more than can be planned in time."""
    lease = state.leases.live
    if not command.append:
        return None
    if lease is None or ask.request.lease != lease.id:
        return Reason("bad_value", "append follows a motion under way: quote its lease")
    ahead = planning.frames_ahead(lease.motion)
    if ahead + len(command.frames) > MAX_FRAMES:
        why = f"{ahead} key frames lie ahead, and {MAX_FRAMES} may: append more when some of them are passed"
        return Reason("busy", why)
    return None


def _rest(state: State, command: JointsCommand, ask: Ask[Move]) -> Reason | None:
    """Refuse motion while the emergency stop is latched, or no servo would follow."""
    del command
    return rules.at_rest(ask, servos_trouble(state, ask.now))


def _able(state: State, command: JointsCommand, ask: Ask[Move]) -> Reason | None:
    """Check that every joint of it has torque, is measured, and has no fault."""
    if command.stored is not None or command.torque is not None or command.torques:
        return _at_once(state, command, ask.now)
    return _several(_unable(state, command, ask.now))


RENEWAL: tuple[Link, ...] = (_leases, _rest)
CHAIN: tuple[Link, ...] = (_form, _busy, _leases, _order, _rest, _able)


def _combination(command: JointsCommand) -> Reason | None:
    if command.positions and command.frames:
        return Reason("bad_value", "give positions or frames, not both")
    if command.append and not command.frames:
        return Reason("bad_value", "only frames can be appended")
    if command.join and not command.positions:
        return Reason("bad_value", "only positions can join")
    moved = command.positions.keys() | {name for frame in command.frames for name in frame.positions}
    idle = ", ".join(name for name in command.torques if name not in moved)
    return Reason("bad_value", f"torques names what does not move: {idle}") if idle else None


def _stored_form(state: State, command: JointsCommand, motion: StoredMotion) -> Reason | None:
    other = command.positions or command.frames or command.append or command.join
    if other or command.mirror or command.torque is not None or command.torques:
        return Reason("bad_value", f"the controller plays slot {motion.slot} as it is, and nothing beside it")
    if not 0.0 < motion.duration_s <= LONGEST_STORED_S:
        return Reason("bad_value", f"duration_s {motion.duration_s:g} is outside 0 to {LONGEST_STORED_S:g}")
    return _several(_wrong(state, JointsCommand(positions=motion.pose)))


def _at_once(state: State, command: JointsCommand, now: float) -> Reason | None:
    """Refuse a stored motion without a known holder of the torque, or without motions of the controller."""
    if not state.adopted:
        return NOT_ADOPTED
    if command.stored is not None:
        stores = state.servos is not None and state.servos.stores
        return None if stores else Reason("not_possible", "the servos' controller keeps no motions of its own")
    strong = strengths(command, state.body)
    held = (why for name in strong if (why := torque.not_to_be_held(state, name, now)))
    return _several(held) or _several(_unable(state, command, now, strong))


def _numbers(command: JointsCommand) -> Reason | None:
    times_s = [frame.duration_s for frame in command.frames]
    if command.duration_s is not None:
        times_s.append(command.duration_s)
    for time_s in times_s:
        if not 0.0 < time_s <= LONGEST_S:  # this way round, NaN is refused
            return Reason("bad_value", f"duration_s {time_s:g} is outside 0 to {LONGEST_S:g}")
    for strength in (*([] if command.torque is None else [command.torque]), *command.torques.values()):
        if not 0.0 < strength <= 1.0:
            why = f"torque {strength:g} is outside 0 to 1; to switch it off is another command (/torque/off)"
            return Reason("bad_value", why)
    speed_rps = command.speed_rps
    if speed_rps is not None and not (isfinite(speed_rps) and speed_rps > 0.0):
        return Reason("bad_value", f"speed_rps {speed_rps:g} is not a speed; leave it out or give radians a second")
    return None


def _wrong(state: State, command: JointsCommand) -> Iterator[Reason]:
    """Yield the errors of the named joints; the mirrored joint has limits of its own."""
    body, reasons = state.body, set[Reason]()
    for positions in (command.positions, *(frame.positions for frame in command.frames)):
        for name, angle_rad in positions.items():
            why = body.refusal(name, angle_rad)
            if not why and command.mirror:
                why = _not_mirrored(state, name, angle_rad)
            if why and why not in reasons:
                reasons.add(why)
                yield why


def _not_mirrored(state: State, name: str, angle_rad: float) -> Reason | None:
    if not state.body.partner(name):
        return Reason("not_possible", f"{name} has no joint on the other side to mirror it")
    ((partner, mirrored_rad),) = state.body.mirrored({name: angle_rad}).items()
    return state.body.refusal(partner, mirrored_rad)


def _unable(state: State, command: JointsCommand, now: float, strong: Collection[str] = ()) -> Iterator[Reason]:
    joints = [name for name in named(command, state.body) if name not in strong]
    without = [name for name in joints if name not in state.on]
    troubles = {name: joint_trouble(state, name, now) for name in joints}
    yield from (why for why in troubles.values() if why)
    idle = [name for name in without if not troubles[name]]
    if idle:
        some = ", ".join(idle[:MOST_NAMED]) + (f" and {len(idle) - MOST_NAMED} more" if len(idle) > MOST_NAMED else "")
        yield Reason("no_torque", f"{some} {'has' if len(idle) == 1 else 'have'} no torque: {TORQUE_FIRST}")


def _several(whys: Iterator[Reason]) -> Reason | None:
    """Return the first few errors as one reason; the code is that of the first."""
    reasons = list(islice(whys, MOST_NAMED))
    return Reason(reasons[0].code, "; ".join(why.text for why in reasons)) if reasons else None
