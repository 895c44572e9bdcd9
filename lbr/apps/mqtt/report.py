"""From what the robot says of itself to what is told outside: few values, rounded, so that what rests changes nothing.
Pure."""

from collections.abc import Callable, Collection, Mapping
from math import degrees
from typing import Any

from lbr.capability.context import Received

Latest = Callable[[str], Received | None]
Report = dict[str, Any]
OLD_S = 3.0
"""Older values are not known: the slowest of these streams comes once a second."""
SOURCES = ("battery", "odometry", "attitude", "motors", "drive", "joints", "motions", "behaviour")
LONGEST = 120
MOST_FAULTS = 10


def report(parts: Collection[str], latest: Latest, wired: Collection[str], now: float) -> Report:
    """Return these parts of what is known; `wired` are the streams that somebody feeds, and null is not known."""
    seen = {name: _fresh(latest(name), now) for name in SOURCES}
    told: Mapping[str, Callable[[], Any]] = {
        "battery": lambda: _battery(seen["battery"]),
        "docked": lambda: _docked(seen["battery"]),
        "position": lambda: _position(seen["odometry"], seen["attitude"]),
        "motion": lambda: _motion(seen),
        "behaviour": lambda: _behaviour(seen["behaviour"]),
        "faults": lambda: _faults(seen, wired),
    }
    return {name: make() for name, make in told.items() if name in parts}


def difference(before: Report, now: Report) -> Report:
    """Return what a shadow must merge into `before` to have `now`: what is new or otherwise, and null for what is
    gone."""
    found: Report = {name: None for name, value in before.items() if name not in now and value is not None}
    for name, value in now.items():
        old = before.get(name)
        if isinstance(value, dict) and isinstance(old, dict):
            if inner := difference(old, value):
                found[name] = inner
        elif not _same(value, old):
            found[name] = value
    return found


def merged(before: Report, change: Report) -> Report:
    """Return what a shadow makes of a document and a change to it: null takes away, and objects are merged."""
    found = dict(before)
    for name, value in change.items():
        if value is None:
            found.pop(name, None)
        elif isinstance(value, dict):
            old = found.get(name)
            found[name] = merged(old if isinstance(old, dict) else {}, value)
        else:
            found[name] = value
    return found


def _same(one: object, other: object) -> bool:
    """Say whether two values are one in JSON, where true is not 1."""
    return type(one) is type(other) and one == other


def _fresh(received: Received | None, now: float) -> Any:
    return received.message if received is not None and received.age_s(now) <= OLD_S else None


def _rounded(value: float | None, digits: int) -> float | None:
    return None if value is None else round(value, digits) + 0.0  # so that -0.0 is 0.0


def _battery(battery: Any) -> Report | None:
    if battery is None or not battery.valid:
        return None
    charge = battery.charge
    return {
        "charge_percent": None if charge is None else round(100 * charge),
        "voltage_v": _rounded(battery.voltage_v, 1),
        "level": battery.level,
        "charging": battery.charging,
    }


def _docked(battery: Any) -> bool | None:
    """Return whether it is on its dock: then it is fed or charged by it."""
    if battery is None or not battery.valid or (battery.charging is None and battery.source is None):
        return None
    return bool(battery.charging) or battery.source == "mains"


def _position(odometry: Any, attitude: Any) -> Report:
    known = odometry if odometry is not None and odometry.valid else None
    heading = attitude.heading_deg if attitude is not None and attitude.valid else None
    return {
        "x_m": _rounded(known.x_m, 2) if known else None,
        "y_m": _rounded(known.y_m, 2) if known else None,
        "yaw_deg": _rounded(degrees(known.yaw_rad), 0) if known and known.yaw_rad is not None else None,
        "heading_deg": None if heading is None else round(heading) % 360,
    }


def _motion(seen: Mapping[str, Any]) -> Report:
    movers = [seen[name] for name in ("drive", "joints") if seen[name] is not None]
    holder = next((one.holder for one in movers if one.holder), None)
    return {
        "moving": any(one.moving for one in movers) if movers else None,
        "holder": None if holder is None else holder[:LONGEST],
        "stopped_for_good": any(one.estop for one in movers) if movers else None,
    }


def _behaviour(behaviour: Any) -> Report | None:
    if behaviour is None:
        return None
    return {
        "phase": behaviour.phase,
        "table": behaviour.table,
        "state": behaviour.state[:LONGEST],
        "reason": behaviour.reason[:LONGEST] if behaviour.phase in {"ended", "resting"} else "",
    }


def _faults(seen: Mapping[str, Any], wired: Collection[str]) -> list[str] | None:
    """Return what is wrong, for people, the worst first; None where no stream is wired that would tell."""
    if not any(name in wired for name in SOURCES):
        return None
    found = [f"{name}: it says nothing" for name in SOURCES if name in wired and seen[name] is None]
    drive, joints, motors = seen["drive"], seen["joints"], seen["motors"]
    battery, odometry, attitude = seen["battery"], seen["odometry"], seen["attitude"]
    if any(one is not None and one.estop for one in (drive, joints)):
        found.insert(0, "the emergency stop is engaged")
    if motors is not None:
        found += [f"motors: {fault}" for fault in motors.faults]
    if seen["motions"] is not None and seen["motions"].fallen:
        found.append(f"it lies on its {seen['motions'].fallen}")
    if battery is not None and not battery.valid:
        found.append(f"battery: {battery.reason or 'it is not known'}")
    if battery is not None and battery.valid and battery.level == "critical" and not battery.charging:
        found.append("battery: almost empty")
    if odometry is not None and odometry.stalled:
        found.append("the wheels are stalled")
    if attitude is not None and not attitude.valid:
        found.append(f"attitude: {attitude.reason or 'it is not known'}")
    return [one[:LONGEST] for one in found[:MOST_FAULTS]]
