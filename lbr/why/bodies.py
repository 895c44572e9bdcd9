"""The reports of joints and servos, as links: all of a body, and one joint."""

from collections.abc import Iterator
from dataclasses import replace
from math import degrees

from lbr.messages.codes import ReasonCode
from lbr.messages.joints import JointsState, JointState
from lbr.messages.motors import MotorsState
from lbr.messages.servos import ServosState
from lbr.messages.why import Link
from lbr.why import leases
from lbr.why.snapshot import Part, Report, Snapshot

PASSES_ON = ("", "pc")
"""Modes of a servos' controller in which it passes on goals."""
LOST = ("holding", "releasing")
"""Phases of servos whose sender is gone: the next motion begins from there."""
NEAR_LIMIT_RAD = 0.02


def joints(report: Report[JointsState]) -> Iterator[Link]:
    """Yield the holder of the joints, those without torque or with a latch, and the end of the last motion."""
    state, part, say = report.state, report.part, report.now.facts.say
    yield from leases.holder(report, moving=state.moving)
    recover = say(f"{part.name}.recover", "/recover")
    on = say(f"{part.name}.torque", "/torque/on", on=True)
    if latched := [f"{name} ({', '.join(one.latched)})" for name, one in state.joints.items() if one.latched]:
        text = f"latched, and without torque until recovered: {_some(latched)}"
        yield report.link("fault", "doubt", text, "latched", do=f"remove the cause, then {recover}, then {on}")
    without = [name for name, one in state.joints.items() if one.torque == 0.0]
    if loose := [name for name in without if not state.joints[name].latched]:
        every = len(without) == len(state.joints)
        text = "no joint has torque" if every else f"{_some(loose)} without torque"
        yield report.link("torque", "held" if every else "doubt", text, "no_torque", do=on, since=("torque", "let_go"))
    if state.phase in LOST and without != list(state.joints):
        text = f"the mover of the joints was lost: they are {state.phase}"
        do = "move them again, or /torque/on to keep them"
        yield report.link("holder", "past", text, "holder_gone", do=do, since=("mover_lost", "lapsed"))
    yield leases.last(report)


def joint(now: Snapshot, part: Part, name: str) -> Iterator[Link]:
    """Yield the hindrances of one joint: it is not measured, has latched, has no torque, or stands at a limit."""
    report = now.report(part, JointsState)
    if report is None:
        return
    state = report.state.joints.get(name)
    if state is None:
        text = f"'{part.name}' has no joint '{name}': its row names the bus of another driver"
        row, do = f"row joint.{name}", "correct column bus of that row"
        yield Link("row", name, "held", text, "unknown_name", evidence=row, do=do)
        return
    of_joint = replace(report, about=name, topic=f"{report.topic}: joints.{name}", age_s=state.age_s)
    yield from _joint(of_joint, name, state)


def _joint(report: Report[JointsState], name: str, state: JointState) -> Iterator[Link]:
    part, say = report.part, report.now.facts.say
    reason = f": {state.reason}" if state.reason else ""
    if state.latched:
        text = f"servo {state.id} of '{name}' has latched {', '.join(state.latched)}"
        recover = say(f"{part.name}.recover", f"/recover/{name}", joints=[name])
        yield report.link("fault", "held", text, "latched", do=f"remove the cause, let it cool, then {recover}")
    elif state.trusted is False:
        text = f"what servo {state.id} of '{name}' reports as its position is not believed{reason}"
        yield report.link("reading", "held", text, "stale_sensor", do="look at its horn and its wiring")
    elif state.position_rad is None and not _open_loop(part):
        others = [other for other, each in report.state.joints.items() if each.position_rad is None and other != name]
        if others:  # that is not the fault of one servo
            text = f"'{name}' and {_some(others)} are not measured: their supply, what feeds them, or their driver"
            do = "check their power; lbr why lists all that moves"
            yield report.link("power", "held", text, "unreachable", do=do)
        else:
            text = f"servo {state.id} of '{name}' does not answer{reason}"
            yield report.link("line", "held", text, "unreachable", do="check its cable and its number")
    if state.torque == 0.0:
        do = say(f"{part.name}.torque", f"/torque/on/{name}", on=True, joints=[name])
        yield report.link("torque", "held", f"'{name}' has no torque", "no_torque", do=do, since=("torque", "let_go"))
    elif state.faults and not state.latched:
        text = f"servo {state.id} of '{name}' reports {', '.join(state.faults)}"
        do = "look at it: temperature, load and voltage are in lbr topic echo joints/state"
        yield report.link("fault", "held", text, "failed", do=do)
    if state.position_rad is not None:
        yield from _at_limit(report, name, state.position_rad)
        goal = f", goal {degrees(state.goal_rad):.0f}°" if state.goal_rad is not None else ""
        yield report.link("motor", "ok", f"at {degrees(state.position_rad):.0f}°{goal}")


def _at_limit(report: Report[JointsState], name: str, position_rad: float) -> Iterator[Link]:
    row = next((one for one in report.now.facts.joints if one.name == name), None)
    if row is None:
        return
    for which, limit_rad, beyond in (
        ("lower", row.lower_rad, position_rad <= row.lower_rad + NEAR_LIMIT_RAD),
        ("upper", row.upper_rad, position_rad >= row.upper_rad - NEAR_LIMIT_RAD),
    ):
        if beyond:
            text = f"'{name}' stands at its {which} limit of {degrees(limit_rad):.0f}°, and moves only the other way"
            do = f"move it the other way, or correct {which}_rad of that row"
            evidence = f"{report.topic}; row joint.{name}"
            yield report.link("limit", "doubt", text, "limit", do=do, evidence=evidence)


def unheard(report: Report[MotorsState | ServosState], who: str) -> Link:
    """Return that a device has never sent anything: that it works is only an assumption."""
    text = f"{who} has sent nothing since its line was opened: perhaps it is missing"
    do = "check its power and cable; without an answer lbr knows only what it sent"
    return report.link("line", "doubt", text, "unreachable", do=do, about=report.part.device)


def servos(report: Report[ServosState]) -> Iterator[Link]:
    """Yield whether the servos of a bus would follow their goals."""
    state = report.state
    if state.armed and state.heard is False:
        yield unheard(report, "the servos' line")
    if state.mode not in PASSES_ON:
        text = f"the servos' controller is in mode '{state.mode}', in which it passes no goals on"
        do = "wait; it comes back by itself once what it plays is over"
        yield report.link("arming", "held", text, "not_possible", do=do)
    elif not state.armed and state.phase not in LOST:
        text = f"the servos are not armed: {state.reason or 'no reason given'}"
        code: ReasonCode = "estop" if state.estop else state.code or "not_armed"
        do, since = "move again; /torque/on keeps what holds", ("mover_lost", "degraded", "let_go")
        yield report.link("arming", "held", text, code, do=do, since=since)
    else:
        yield report.link("arming", "ok", f"the servos are {state.phase}")


def _open_loop(part: Part) -> bool:
    return bool(part.settings.get("open_loop", False))


def _some(names: list[str]) -> str:
    return ", ".join(names[:3]) + (f" and {len(names) - 3} more" if len(names) > 3 else "")
