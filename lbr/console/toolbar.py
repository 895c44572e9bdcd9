"""The status bar: the robot's state in one line; words carry the meaning, colours only repeat it."""

from collections.abc import Mapping

from lbr.console.lease_keeper import LeaseKeeper
from lbr.console.operator import Telemetry
from lbr.messages.joints import JointsState, JointState
from lbr.messages.plain import one_line
from lbr.messages.power import PowerState
from lbr.messages.rows import short
from lbr.messages.sensing import Ranges
from lbr.messages.system import Status

GOOD, DOUBTFUL, BAD = "class:good", "class:doubtful", "class:bad"
Piece = tuple[int, str, str]
"""Rank (the highest is dropped first if there is no room), style, text."""

HOT_C = 60.0
"""From this temperature on, a joint is worth a look; small servos release at 70 by themselves."""
_PHASES = {
    "released": ("", "torque off"),
    "following": ("", "holding"),
    "holding": (DOUBTFUL, "mover lost: holding"),
    "releasing": (DOUBTFUL, "mover lost: releasing"),
}


def joints(state: JointsState) -> list[Piece]:
    """Return the state of the joints, their sender, the latches, the hottest joint and the lowest voltage."""
    pieces: list[Piece] = [(2, *_doing(state))]
    latched = [f"{name} {' and '.join(one.latched)}" for name, one in state.joints.items() if one.latched]
    if latched:
        more = f" and {len(latched) - 1} more" if len(latched) > 1 else ""
        pieces.append((1, BAD, f"latched: {short(latched[0])}{more}"))
    if state.holder:
        pieces.append((4, "", f"held by {short(state.holder)}"))
    return [*pieces, *_hottest(state.joints), *_lowest(state.joints)]


def power(state: PowerState) -> list[Piece]:
    """Return the source of the power, or how soon it is switched off."""
    if state.phase in {"countdown", "parking", "powering_off"}:
        left = f" in {state.remaining_s:.0f} s" if state.remaining_s is not None else ""
        return [(1, BAD, f"SHUTDOWN{left}")]
    if state.phase in {"warning", "failed"}:
        return [
            (1, DOUBTFUL, f"power {state.phase}: {short(state.reason)}" if state.reason else f"power {state.phase}")
        ]
    ups = state.ups
    volts = ups.external_v if ups is not None and ups.source == "external" else ups.battery_v if ups else None
    source = f"{ups.source} " if ups is not None and ups.source else ""
    known = [(6, "", f"{source}{volts:.1f} V")] if volts is not None else []
    return known if state.armed else [*known, (7, "", "power watch disarmed")]


def _doing(state: JointsState) -> tuple[str, str]:
    if state.stored is not None:
        left = "" if state.left_s is None else f", {state.left_s:.0f} s more"
        return DOUBTFUL, f"controller plays slot {state.stored}{left}"
    if state.moving:
        return DOUBTFUL, "joints moving"
    style, words = _PHASES[state.phase]
    unknown = sum(1 for joint in state.joints.values() if joint.torque is None)
    if unknown:
        known = "" if state.phase == "released" else f"{words}, "
        words = f"{known}torque of {unknown} of {len(state.joints)} unknown"
    without = sum(1 for joint in state.joints.values() if joint.torque == 0.0)
    if state.phase == "following" and 0 < without < len(state.joints):
        words = f"{words}, {without} without torque"
    doubted = sum(1 for joint in state.joints.values() if joint.trusted is False)
    if doubted:
        words = f"{words}, {doubted} not believed"
    return style, f"joints {words}"


def _hottest(of: dict[str, JointState]) -> list[Piece]:
    known = {name: one.temperature_c for name, one in of.items() if one.temperature_c is not None}
    if not known:
        return []
    name = max(known, key=lambda each: known[each])
    hot = known[name] >= HOT_C
    return [(2 if hot else 5, DOUBTFUL if hot else "", f"{short(name)} {known[name]:.0f} °C")]


def _lowest(of: dict[str, JointState]) -> list[Piece]:
    known = [one.voltage_v for one in of.values() if one.voltage_v is not None]
    return [(5, "", f"{min(known):.1f} V at the joints")] if known else []


Fragments = list[tuple[str, str]]
CONTACT_S = 3.0
SEPARATOR = " | "
WHERE = {"forward": "ahead", "back": "behind", "left": "left", "right": "right"}


def toolbar(
    robot: str, telemetry: Telemetry, held: LeaseKeeper | None, under_way: Mapping[str, float], columns: int = 1000
) -> Fragments:
    """Return the bar, cut to `columns` from its least important end; `under_way` maps unanswered lines to seconds."""
    pieces: list[Piece] = [(0, "", robot), (0, *_state(telemetry))]
    drive, motors = telemetry.drive, telemetry.motors
    if held is not None:
        bound = f" of {held.hold.max_run_s:g}" if not held.hold.goal else ""
        pieces.append((1, DOUBTFUL, f"moving {held.elapsed_s:4.1f}{bound} s"))
    if drive is not None and drive.holder:
        pieces.append((4, "", f"held by {short(drive.holder)}"))
    if drive is not None and drive.limited_by:
        pieces.append((2, DOUBTFUL, f"slowed by {short(drive.limited_by)}"))
    if motors is not None:
        pieces.append((3, "", f"L {motors.left:+.2f} R {motors.right:+.2f}"))
        if motors.voltage_v is not None:
            pieces.append((5, "", f"{motors.voltage_v:4.1f} V"))
    sees = drive.sees if drive is not None else {}
    if telemetry.ranges is not None or sees:
        pieces.append((6, "", _nearest(telemetry.ranges, sees)))
    if telemetry.joints is not None:
        pieces += joints(telemetry.joints)
    if telemetry.power is not None:
        pieces += power(telemetry.power)
    pieces += [(7, "", f"{short(line)} ({age_s:.0f} s)") for line, age_s in under_way.items()]
    return _joined(_fitting(pieces, columns))


def state_of(status: Status) -> tuple[str, str]:
    """Return style and words for the state of a robot."""
    if status.estop.engaged:
        why = f": {one_line(status.estop.reason)}" if status.estop.reason else ""
        return BAD, f"E-STOP{why}"
    bad = [one.name for one in status.capabilities if one.phase == "failed"]
    if bad:
        return BAD, f"failed: {', '.join(bad)}"
    away = {one.name: one.host for one in status.capabilities if one.host and one.phase == "waiting"}
    degraded = [name for name in status.degraded if name not in away]
    if degraded:
        return DOUBTFUL, f"degraded: {', '.join(degraded)}"
    absent = sorted(set(away.values()))
    if absent:
        return DOUBTFUL, f"{'ready' if status.ready else 'starting'}, without host {', '.join(absent)}"
    return (GOOD, "ready") if status.ready else (DOUBTFUL, "starting")


def _state(telemetry: Telemetry) -> tuple[str, str]:
    if not telemetry.status_age_s <= CONTACT_S:
        return BAD, f"NO CONTACT for {telemetry.status_age_s:.0f} s"
    return state_of(telemetry.status) if telemetry.status is not None else (DOUBTFUL, "listening")


def _nearest(ranges: Ranges | None, sees: Mapping[str, float | None]) -> str:
    """Return the nearest distance of the ring, the obstacle that other sensors show the drive, and their readings."""
    read = {} if ranges is None else {name: ranges.metres(name) for name in WHERE} | ranges.others_m
    watching = {view.partition(" ")[0] for view in sees}
    distances = {WHERE.get(name, name): metres for name, metres in read.items() if name not in watching}
    for view, metres in sees.items():
        sensor, _, side = view.partition(" ")
        distances[f"{WHERE.get(side, side)} ({short(sensor)})"] = metres
    known = {where: metres for where, metres in distances.items() if metres is not None}
    if not known:
        return "no ranges"
    where = min(known, key=lambda name: known[name])
    return f"{known[where]:.2f} m {where}"


def _fitting(pieces: list[Piece], columns: int) -> Fragments:
    """Drop the pieces without room, and finally shorten the state."""
    while len(pieces) > 2 and _width(pieces) > columns:
        rank = max(rank for rank, _, _ in pieces)
        pieces.remove(next(piece for piece in reversed(pieces) if piece[0] == rank))
    fitting = [(style, text) for _, style, text in pieces]
    over = _width(pieces) - columns
    if over > 0:
        style, text = fitting[1]
        fitting[1] = style, text[: max(1, len(text) - over - 1)] + "…"
    return fitting


def _width(pieces: list[Piece]) -> int:
    return sum(len(text) + len(SEPARATOR) for _, _, text in pieces) - 1  # one blank before, one after


def _joined(pieces: Fragments) -> Fragments:
    bar: Fragments = [("", " ")]
    for style, text in pieces:
        bar += [(style, text), ("", SEPARATOR)]
    return bar[:-1]
