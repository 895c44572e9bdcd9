"""The status bar of a humanoid: a short summary of its joints, and its power."""

from lbr.console.printable import short
from lbr.messages.joints import JointsState, JointState
from lbr.messages.power import PowerState

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
