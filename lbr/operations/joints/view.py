"""The public state of the joints."""

from math import isfinite

from msgspec.structs import asdict

from lbr.messages.codes import Reason, ReasonCode
from lbr.messages.drive import LoopStatistics
from lbr.messages.joints import Joint, JointsState, JointState
from lbr.messages.servos import ServoState
from lbr.operations.joints import feet, stored, trajectory
from lbr.operations.joints.move import Move
from lbr.operations.joints.state import State, servos_trouble

LETS_GO = "the servos hold, and release slowly unless they are moved or their torque is switched on"


def joints_state(state: State, now: float, loop: LoopStatistics | None = None) -> JointsState:
    """Return every joint from the newest sweep, their mover, and the reason for their rest."""
    lease, servos = state.leases.live, state.servos
    move = lease.motion if lease is not None else None
    order = move.stored if move is not None else None
    targets = move.under_way() if move is not None else {}
    why = None if lease is not None else _why_at_rest(state, now)
    return JointsState(
        sequence=servos.sweep if servos else 0,
        measured_s=servos.measured_s if servos else 0.0,
        moving=state.feet is not None or (move is not None and not (move.stay and move.over)),
        phase=servos.phase if servos else "released",
        joints={name: _joint(state, joint, targets.get(name), now) for name, joint in state.body.joints.items()},
        holder=lease.source if lease else None,
        goal=move.goal if move else None,
        passed=_passed(move),
        stored=order.motion.slot if order is not None else None,
        left_s=round(stored.left_s(order, now), 2) if order is not None else None,
        feet_s=round(max(0.0, feet.left_s(state.feet, now)), 2) if state.feet is not None else None,
        stopped_s=state.leases.stopped if isfinite(state.leases.stopped) else None,
        stopped_by=state.leases.stopped_by,
        halted_s=state.leases.halts.at if isfinite(state.leases.halts.at) else None,
        halted_by=state.leases.halts.source,
        reason=why.text if why else "",
        code=why.code if why else "",
        estop=state.leases.estop,
        loop=loop,
    )


def _passed(move: Move | None) -> int:
    if move is None or move.trajectory is None:
        return 0
    return move.passed + trajectory.passed(move.trajectory, move.elapsed_s)


def _joint(state: State, joint: Joint, target_rad: float | None, now: float) -> JointState:
    servo = state.seen.get(joint.name)
    if servo is None:
        absence = _absence(state)
        return JointState(id=joint.device_id, target_rad=target_rad, reason=absence.text, code=absence.code)
    as_joint = {
        "position_rad": _angle(joint, servo.position_rad),
        "speed_rps": _signed(joint, servo.speed_rps),
        "load": _signed(joint, servo.load),
        "goal_rad": _angle(joint, servo.goal_rad),
        "age_s": _age_s(state, servo, now),
        "target_rad": target_rad,
        "code": _code(servo),
    }
    return JointState(**{**asdict(servo), **as_joint})


def _absence(state: State) -> Reason:
    if state.servos is None:
        return Reason("unreachable", state.servos_gone)
    if state.servos.armed:
        return Reason("wiring", "the servo driver does not know it")
    return Reason("not_armed", "the servos are not armed")


def _code(servo: ServoState) -> ReasonCode:
    if not servo.reason:
        return ""
    silent = servo.position_rad is None and servo.raw is None
    return "latched" if servo.latched else "unreachable" if silent else "no_torque"


def _angle(joint: Joint, servo_rad: float | None) -> float | None:
    return None if servo_rad is None else round((servo_rad - joint.zero_rad) * joint.sign, 5) + 0.0  # no -0.0


def _signed(joint: Joint, value: float | None) -> float | None:
    return None if value is None else value * joint.sign + 0.0  # no -0.0


def _age_s(state: State, servo: ServoState, now: float) -> float | None:
    return None if servo.age_s is None else round(servo.age_s + max(0.0, now - state.servos_at), 4)


def _why_at_rest(state: State, now: float) -> Reason:
    held = state.leases
    if held.estop:
        return Reason("estop", f"emergency stop: {held.estop_reason or 'no reason given'}")
    if trouble := servos_trouble(state, now):
        return trouble
    if held.offers:
        return Reason("not_ready", f"waiting for {', '.join(offer.source for offer in held.offers)} to confirm")
    return Reason(held.reason.code, f"{held.reason}; {LETS_GO}") if state.lost and state.on else held.reason
