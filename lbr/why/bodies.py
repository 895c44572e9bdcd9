"""What joints and servos say of themselves, as links: all of a body, and one joint."""

from collections.abc import Iterator
from math import degrees

from lbr.messages.joints import JointsState, JointState
from lbr.messages.servos import ServosState
from lbr.messages.why import Link
from lbr.why import leases
from lbr.why.snapshot import Part, Snapshot

PASSES_ON = ("", "pc")
"""Modes of a servos' controller in which it passes goals on."""
LOST = ("holding", "releasing")
"""Phases of servos whose mover is gone: the next motion goes on from there."""
NEAR_LIMIT_RAD = 0.02


def joints(now: Snapshot, part: Part, said: JointsState, topic: str, age_s: float | None) -> Iterator[Link]:
    """Yield who holds the joints, which have no torque or have latched, and how the last motion ended."""
    yield from leases.holder(now, part, said.holder, topic, age_s, moving=said.moving)
    recover = now.facts.say(f"{part.name}.recover", "/recover")
    on = now.facts.say(f"{part.name}.torque", "/torque/on", on=True)
    latched = [f"{name} ({', '.join(one.latched)})" for name, one in said.joints.items() if one.latched]
    if latched:
        yield Link(
            name="fault",
            about=part.name,
            state="doubt",
            text=f"latched, and without torque until recovered: {_some(latched)}",
            code="latched",
            age_s=age_s,
            evidence=topic,
            do=f"remove the cause, then {recover}, then {on}",
        )
    without = [name for name, one in said.joints.items() if one.torque == 0.0]
    loose = [name for name in without if not said.joints[name].latched]
    if loose:
        every = len(without) == len(said.joints)
        named = "no joint has torque" if every else f"{_some(loose)} without torque"
        yield Link(
            name="torque",
            about=part.name,
            state="held" if every else "doubt",
            text=named,
            code="no_torque",
            since_s=now.since_s(part.name, ("torque", "let_go")),
            age_s=age_s,
            evidence=topic,
            do=on,
        )
    if said.phase in LOST and without != list(said.joints):
        yield Link(
            name="holder",
            about=part.name,
            state="past",
            text=f"the mover of the joints was lost: they are {said.phase}",
            code="holder_gone",
            since_s=now.since_s(part.name, ("mover_lost", "lapsed")),
            age_s=age_s,
            evidence=topic,
            do="move them again, or /torque/on to keep them",
        )
    yield leases.last(now, part, said.holder, said.code, said.reason, topic, age_s, stopped_by=said.stopped_by)


def joint(now: Snapshot, part: Part, name: str) -> Iterator[Link]:
    """Yield what holds one joint: that it is not measured, has latched, has no torque, or stands at a limit."""
    found = now.heard(part, JointsState)
    if found is None:
        return
    said, topic, _ = found
    one = said.joints.get(name)
    where = f"{topic}: joints.{name}"
    if one is None:
        text = f"'{part.name}' has no joint '{name}': its row names the bus of another driver"
        yield Link(
            name="row",
            about=name,
            state="held",
            text=text,
            code="unknown_name",
            evidence=f"row joint.{name}",
            do="correct column bus of that row",
        )
        return
    if one.latched:
        yield Link(
            name="fault",
            about=name,
            state="held",
            text=f"servo {one.id} of '{name}' has latched {', '.join(one.latched)}",
            code="latched",
            age_s=one.age_s,
            evidence=where,
            do="remove the cause, let it cool, then "
            + now.facts.say(f"{part.name}.recover", f"/recover/{name}", joints=[name]),
        )
    elif one.trusted is False:
        text = f"what servo {one.id} of '{name}' tells of its place is not believed" + (
            f": {one.reason}" if one.reason else ""
        )
        yield Link(
            name="reading",
            about=name,
            state="held",
            text=text,
            code="stale_sensor",
            age_s=one.age_s,
            evidence=where,
            do="look at its horn and its wiring",
        )
    elif one.position_rad is None and not _open_loop(part):
        yield _unmeasured(said, name, one, where)
    if one.torque == 0.0:
        yield Link(
            name="torque",
            about=name,
            state="held",
            text=f"'{name}' has no torque",
            code="no_torque",
            since_s=now.since_s(part.name, ("torque", "let_go")),
            age_s=one.age_s,
            evidence=where,
            do=now.facts.say(f"{part.name}.torque", f"/torque/on/{name}", on=True, joints=[name]),
        )
    elif one.faults and not one.latched:
        text = f"servo {one.id} of '{name}' reports {', '.join(one.faults)}"
        yield Link(
            name="fault",
            about=name,
            state="held",
            text=text,
            code="failed",
            age_s=one.age_s,
            evidence=where,
            do="look at it: temperature, load and voltage are in lbr topic echo joints/state",
        )
    yield from _at_limit(now, name, one.position_rad, where, one.age_s)
    if one.position_rad is not None:
        text = f"at {degrees(one.position_rad):.0f}°" + (
            f", goal {degrees(one.goal_rad):.0f}°" if one.goal_rad is not None else ""
        )
        yield Link(name="motor", about=name, state="ok", text=text, age_s=one.age_s, evidence=where)


def _unmeasured(said: JointsState, name: str, one: JointState, where: str) -> Link:
    """Return why a joint is not measured: its own servo is silent, or many are, which is no servo's fault."""
    others = [other for other, state in said.joints.items() if state.position_rad is None and other != name]
    if others:
        return Link(
            name="power",
            about=name,
            state="held",
            text=f"'{name}' and {_some(others)} are not measured: their supply, what feeds them, or their driver",
            code="unreachable",
            age_s=one.age_s,
            evidence=where,
            do="see that they have power; lbr why tells of all that moves",
        )
    return Link(
        name="line",
        about=name,
        state="held",
        text=f"servo {one.id} of '{name}' does not answer" + (f": {one.reason}" if one.reason else ""),
        code="unreachable",
        age_s=one.age_s,
        evidence=where,
        do="check its cable and its number",
    )


def _at_limit(now: Snapshot, name: str, position_rad: float | None, where: str, age_s: float | None) -> Iterator[Link]:
    row = next((one for one in now.facts.joints if one.name == name), None)
    if row is None or position_rad is None:
        return
    for which, limit_rad, beyond in (
        ("lower", row.lower_rad, position_rad <= row.lower_rad + NEAR_LIMIT_RAD),
        ("upper", row.upper_rad, position_rad >= row.upper_rad - NEAR_LIMIT_RAD),
    ):
        if beyond:
            text = f"'{name}' stands at its {which} limit of {degrees(limit_rad):.0f}°, and moves only the other way"
            yield Link(
                name="limit",
                about=name,
                state="doubt",
                text=text,
                code="limit",
                age_s=age_s,
                evidence=f"{where}; row joint.{name}",
                do=f"move it the other way, or correct {which}_rad of that row",
            )


def unheard(part: Part, who: str, topic: str, age_s: float | None) -> Link:
    """Return that a device has never sent anything: that it does what it is told is an assumption."""
    return Link(
        name="line",
        about=part.device or part.name,
        state="doubt",
        text=f"{who} has sent nothing since its line was opened: it is told, and may not be there",
        code="unreachable",
        age_s=age_s,
        evidence=topic,
        do="check its power and cable; of one that never answers nothing is known but what it was told",
    )


def servos(now: Snapshot, part: Part, said: ServosState, topic: str, age_s: float | None) -> Iterator[Link]:
    """Yield whether the servos of a bus would do what they are told."""
    if said.armed and said.heard is False:
        yield unheard(part, "the servos' line", topic, age_s)
    if said.mode not in PASSES_ON:
        text = f"the servos' controller is in mode '{said.mode}', in which it passes no goals on"
        yield Link(
            name="arming",
            about=part.name,
            state="held",
            text=text,
            code="not_possible",
            age_s=age_s,
            evidence=topic,
            do="wait; it comes back by itself once what it plays is over",
        )
    elif not said.armed and said.phase not in LOST:
        yield Link(
            name="arming",
            about=part.name,
            state="held",
            text=f"the servos are not armed: {said.reason or 'no reason given'}",
            code="estop" if said.estop else "not_armed",
            since_s=now.since_s(part.name, ("mover_lost", "degraded", "let_go")),
            age_s=age_s,
            evidence=topic,
            do="move again; /torque/on keeps what holds",
        )
    else:
        yield Link(
            name="arming", about=part.name, state="ok", text=f"the servos are {said.phase}", age_s=age_s, evidence=topic
        )


def _open_loop(part: Part) -> bool:
    return bool(part.settings.get("open_loop", False))


def _some(names: list[str]) -> str:
    return ", ".join(names[:3]) + (f" and {len(names) - 3} more" if len(names) > 3 else "")
