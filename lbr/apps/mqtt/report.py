"""The report for outside: few values of the robot's state, rounded, so that a robot at rest reports no change. Pure."""

from collections.abc import Callable, Collection, Mapping
from math import degrees
from typing import Any, NamedTuple

from lbr.capability.context import Received
from lbr.messages.attitude import AttitudeState
from lbr.messages.battery import BatteryState
from lbr.messages.behaviour import BehaviourState
from lbr.messages.drive import DriveState
from lbr.messages.joints import JointsState, MotionsState
from lbr.messages.motors import MotorsState
from lbr.messages.odometry import OdometryState

Latest = Callable[[str], Received | None]
Report = dict[str, object]
OLD_S = 3.0
"""The age at which a value no longer counts; the slowest of these streams has 1 Hz."""
LONGEST = 120
MOST_FAULTS = 10


class Streams(NamedTuple):
    """The newest message of each reported stream; None if it is old."""

    battery: BatteryState | None
    odometry: OdometryState | None
    attitude: AttitudeState | None
    motors: MotorsState | None
    drive: DriveState | None
    joints: JointsState | None
    motions: MotionsState | None
    behaviour: BehaviourState | None


SOURCES = Streams._fields


def report(parts: Collection[str], latest: Latest, wired: Collection[str], now: float) -> Report:
    """Return these parts of the state; `wired` are the streams with a source. Unknown values are null."""
    seen = Streams(*(_fresh(latest(name), now) for name in SOURCES))
    makers: Mapping[str, Callable[[], object]] = {
        "battery": lambda: _battery(seen.battery),
        "docked": lambda: _docked(seen.battery),
        "position": lambda: _position(seen.odometry, seen.attitude),
        "motion": lambda: _motion(seen),
        "behaviour": lambda: _behaviour(seen.behaviour),
        "faults": lambda: _faults(seen, wired),
    }
    return {name: make() for name, make in makers.items() if name in parts}


def difference(before: Report, now: Report) -> Report:
    """Return the change by which a shadow turns `before` into `now`: new values, and null for removed ones."""
    change: Report = {name: None for name, value in before.items() if name not in now and value is not None}
    for name, value in now.items():
        known = before.get(name)
        if isinstance(value, dict) and isinstance(known, dict):
            if inner := difference(known, value):
                change[name] = inner
        elif not _same(value, known):
            change[name] = value
    return change


def merged(before: Report, change: Report) -> Report:
    """Merge a change into a document as a shadow does: null removes a value, and objects are merged."""
    document = dict(before)
    for name, value in change.items():
        if value is None:
            document.pop(name, None)
        elif isinstance(value, dict):
            known = document.get(name)
            document[name] = merged(known if isinstance(known, dict) else {}, value)
        else:
            document[name] = value
    return document


def _same(one: object, other: object) -> bool:
    """Return whether two values are equal in JSON, where true is not 1."""
    return type(one) is type(other) and one == other


def _fresh(received: Received | None, now: float) -> Any:
    return received.message if received is not None and received.age_s(now) <= OLD_S else None


def _rounded(value: float | None, digits: int) -> float | None:
    return None if value is None else round(value, digits) + 0.0  # turns -0.0 into 0.0


def _battery(battery: BatteryState | None) -> Report | None:
    if battery is None or not battery.valid:
        return None
    charge = battery.charge
    return {
        "charge_percent": None if charge is None else round(100 * charge),
        "voltage_v": _rounded(battery.voltage_v, 1),
        "level": battery.level,
        "charging": battery.charging,
    }


def _docked(battery: BatteryState | None) -> bool | None:
    """Return whether the robot is on its dock, which feeds or charges it."""
    if battery is None or not battery.valid or (battery.charging is None and battery.source is None):
        return None
    return bool(battery.charging) or battery.source == "mains"


def _position(odometry: OdometryState | None, attitude: AttitudeState | None) -> Report:
    known = odometry if odometry is not None and odometry.valid else None
    heading = attitude.heading_deg if attitude is not None and attitude.valid else None
    return {
        "x_m": _rounded(known.x_m, 2) if known else None,
        "y_m": _rounded(known.y_m, 2) if known else None,
        "yaw_deg": _rounded(degrees(known.yaw_rad), 0) if known and known.yaw_rad is not None else None,
        "heading_deg": None if heading is None else round(heading) % 360,
    }


def _motion(seen: Streams) -> Report:
    movers = [mover for mover in (seen.drive, seen.joints) if mover is not None]
    holder = next((mover.holder for mover in movers if mover.holder), None)
    return {
        "moving": any(mover.moving for mover in movers) if movers else None,
        "holder": None if holder is None else holder[:LONGEST],
        "stopped_for_good": any(mover.estop for mover in movers) if movers else None,
    }


def _behaviour(behaviour: BehaviourState | None) -> Report | None:
    if behaviour is None:
        return None
    return {
        "phase": behaviour.phase,
        "table": behaviour.table,
        "state": behaviour.state[:LONGEST],
        "reason": behaviour.reason[:LONGEST] if behaviour.phase in {"ended", "resting"} else "",
    }


def _faults(seen: Streams, wired: Collection[str]) -> list[str] | None:
    """Return the faults, for people, the worst first; None if no stream with faults is wired."""
    if not any(name in wired for name in SOURCES):
        return None
    faults = [
        f"{name}: it reports nothing" for name, message in seen._asdict().items() if name in wired and message is None
    ]
    drive, joints, motors = seen.drive, seen.joints, seen.motors
    battery, odometry, attitude = seen.battery, seen.odometry, seen.attitude
    if any(mover is not None and mover.estop for mover in (drive, joints)):
        faults.insert(0, "the emergency stop is engaged")
    if motors is not None:
        faults += [f"motors: {fault}" for fault in motors.faults]
    if seen.motions is not None and seen.motions.fallen:
        faults.append(f"it lies on its {seen.motions.fallen}")
    if battery is not None and not battery.valid:
        faults.append(f"battery: {battery.reason or 'it is not known'}")
    if battery is not None and battery.valid and battery.level == "critical" and not battery.charging:
        faults.append("battery: almost empty")
    if odometry is not None and odometry.stalled:
        faults.append("the wheels are stalled")
    if attitude is not None and not attitude.valid:
        faults.append(f"attitude: {attitude.reason or 'it is not known'}")
    return [fault[:LONGEST] for fault in faults[:MOST_FAULTS]]
