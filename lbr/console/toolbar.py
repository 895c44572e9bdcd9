"""The status bar: the robot's state in one line; words carry the meaning, colours only repeat it."""

from collections.abc import Mapping

from lbr.console import joint_status
from lbr.console.joint_status import BAD, DOUBTFUL, GOOD, Piece
from lbr.console.lease_keeper import LeaseKeeper
from lbr.console.operator import Telemetry
from lbr.console.printable import short
from lbr.messages.plain import one_line
from lbr.messages.sensing import Ranges
from lbr.messages.system import Status

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
        pieces += joint_status.joints(telemetry.joints)
    if telemetry.power is not None:
        pieces += joint_status.power(telemetry.power)
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
