"""From a snapshot and the name of a part to the answer: which link holds it first, in one sentence."""

import difflib
from collections.abc import Iterator
from math import inf
from typing import Literal

from msgspec.structs import replace

from lbr.errors import InputError
from lbr.messages.why import Chain, Link
from lbr.why import bodies
from lbr.why.snapshot import Facts, Part, Snapshot
from lbr.why.walk import Walk, enable

CAMERA = "camera_"
PAST, WELL = 3, 6
"""Ranks: of what is over the newest is told; of what is well nothing."""


def explain(now: Snapshot, part: str = "") -> Chain:
    """Return why a part stands still, or all that moves; raise InputError if there is nothing of that name."""
    wanted = part.strip()
    links = tuple(_links(now, wanted))
    first = _first(links)
    source: Literal["bus", "rows"] = "bus" if now.executive == "up" else "rows"
    told = wanted or now.facts.robot
    if first is None:
        return Chain(robot=now.facts.robot, part=told, state="ok", text=_well(told, links), source=source, links=links)
    one = links[first]
    return Chain(
        robot=now.facts.robot,
        part=told,
        state=one.state,
        text=one.text,
        code=one.code,
        since_s=one.since_s,
        evidence=one.evidence,
        do=one.do,
        first=first,
        source=source,
        links=links,
    )


def _first(links: tuple[Link, ...]) -> int | None:
    """Return the place of the link that is told: what holds, then what may, then what was last; what is not known is last.

    An edit that was refused comes after what may hold, and a machine that is too busy after all that is known.
    """
    ranks = [(_rank(one), inf if one.since_s is None else one.since_s, index) for index, one in enumerate(links)]
    told = [(rank, since_s if rank == PAST else 0.0, index) for rank, since_s, index in ranks if rank < WELL]
    return min(told)[2] if told else None


def _rank(link: Link) -> int:
    if link.state == "doubt":
        return {"rows": 2, "machine": 4}.get(link.name, 1)
    return {"held": 0, "past": PAST, "unknown": 5, "ok": WELL}[link.state]


def names(facts: Facts) -> list[str]:
    """Return what can be asked about: capabilities, joints, devices, external commands."""
    return sorted({*facts.parts, *(one.name for one in facts.joints), *facts.devices, *facts.programs})


def _links(now: Snapshot, part: str) -> Iterator[Link]:
    facts, walk = now.facts, Walk(now)
    yield from walk.executive()
    if not part:
        yield from _whole(now, walk)
    elif part in facts.parts:
        yield from walk.asker(facts.parts[part])
        yield from walk.of(part)
    elif f"{CAMERA}{part}" in facts.parts:
        yield from walk.of(f"{CAMERA}{part}")
    elif any(one.name == part for one in facts.joints):
        yield from _joint(now, walk, part)
    elif owners := [one for one in facts.parts.values() if one.device == part]:
        for owner in owners:
            yield from walk.of(owner.name)
    elif part in facts.programs:
        yield _program(facts, part)
    elif now.executive == "up" or facts.parts:
        raise _unknown(part, facts)


def _whole(now: Snapshot, walk: Walk) -> Iterator[Link]:
    """Yield the links of all that moves, and then of what is not as it should be."""
    parts = now.facts.parts.values()
    movers = [one for one in parts if one.moves and one.enabled and one.family == "operation"]
    for mover in movers or [one for one in parts if one.moves and one.enabled]:
        yield from (_away_from_dock(now.facts, link) for link in walk.of(mover.name))
    for one in parts:
        if one.enabled and one.runs:
            yield from (
                link for link in walk.of(one.name) if link.name in {"process", "line", "fault"} and link.state != "ok"
            )


def _away_from_dock(facts: Facts, link: Link) -> Link:
    """Return a link as the whole robot has it: one that is not before its dock sees no beam, and is well."""
    about = facts.parts.get(link.about)
    if link.name != "reading" or about is None or "DockSignal" not in about.outputs.values():
        return link
    return replace(link, state="ok", code="", do="")


def _joint(now: Snapshot, walk: Walk, name: str) -> Iterator[Link]:
    """Yield the links of the operation that moves a joint: what that says of others does not hold this one."""
    row = f"row joint.{name}"
    yield Link(name="row", about=name, state="ok", text=f"'{name}' is a joint of this robot", evidence=row)
    for owner in (one for one in now.facts.parts.values() if "JointsState" in one.outputs.values()):
        yield from walk.asker(owner)
        yield from (link for link in walk.of(owner.name) if not _of_others(link, owner))
        yield from bodies.joint(now, owner, name)


def _of_others(link: Link, owner: Part) -> bool:
    whole = link.about == owner.name and link.name in {"torque", "fault"}
    return whole or (link.name == "line" and link.state == "doubt")


def _program(facts: Facts, name: str) -> Link:
    row = f"row external_command.{name}"
    if facts.programs[name]:
        text = f"'{name}' is a program that runs when it is said"
        return Link(name="row", about=name, state="ok", text=text, evidence=row)
    do = enable("external_command", f"name = '{name}'", facts.robot)
    text = f"'{name}' is switched off by its row: enabled is 0"
    return Link(name="row", about=name, state="held", text=text, code="off", evidence=row, do=do)


def _unknown(part: str, facts: Facts) -> InputError:
    near = difflib.get_close_matches(part[:64], names(facts), n=3, cutoff=0.5)
    hint = f"did you mean {' or '.join(near)}?" if near else f"there are {', '.join(names(facts)[:12])}"
    shown = part[:64] if part.isprintable() else ascii(part[:64])
    return InputError(f"there is no part '{shown}'; {hint}", "unknown_name")


def _well(part: str, links: tuple[Link, ...]) -> str:
    last = next((link.text for link in links if link.name == "last"), "")
    return f"nothing holds '{part}' still" + (f"; {last}" if last else "")
