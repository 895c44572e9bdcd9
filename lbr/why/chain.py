"""From a snapshot and the name of a part to the answer: the first link that holds it, in one sentence."""

from collections.abc import Callable, Iterator
from math import inf
from typing import Literal

from msgspec.structs import replace

from lbr.errors import InputError
from lbr.messages.why import Chain, Link, LinkName, Repair
from lbr.names import did_you_mean
from lbr.why import bodies
from lbr.why.parts import update
from lbr.why.rendering import ago
from lbr.why.snapshot import ITSELF, Facts, Part, Saying, Snapshot
from lbr.why.walk import Walk

ILL = frozenset({"failed", "degraded"})


def repairs(now: Snapshot, explain: Callable[[Snapshot, str], Chain]) -> tuple[Repair, ...]:
    """Return the repairs, the part that holds the most first; `explain` gives the reason of one part."""
    units = now.status.capabilities if now.status is not None else ()
    ill = {unit.name: unit for unit in units if unit.phase in ILL and unit.name in now.facts.parts}
    chains = {name: explain(now, name) for name in ill}
    sources = {name: _sources(now, chains[name]) & (ill.keys() - {name}) for name in ill}
    devices = {name for name, unit in ill.items() if _without_device(now, chains[name], unit.code)}
    waits: dict[str, list[str]] = {}
    for name in ill:
        for root in _roots(name, sources, devices) or {name}:
            waits.setdefault(root, []).extend([name] if root != name else [])
    order = sorted(waits, key=lambda name: (-len(waits[name]), ill[name].phase != "failed", name))
    return tuple(
        Repair(
            part=name,
            text=ill[name].reason or chains[name].text,
            do=chains[name].do,
            device=name in devices,
            waits=tuple(waits[name]),
        )
        for name in order
    )


def _about(chain: Chain) -> str:
    """Return the subject of the link that holds a part."""
    return chain.part if chain.first is None else chain.links[chain.first].about


def _sources(now: Snapshot, chain: Chain) -> set[str]:
    """Return the parts that may hold a part: the one that its chain names, and those that feed it."""
    feeds = {one.source_part for one in now.facts.channels if one.enabled and one.target_part == chain.part}
    return {_about(chain), *feeds}


def _without_device(now: Snapshot, chain: Chain, code: str) -> bool:
    about = _about(chain)
    line = chain.first is not None and chain.links[chain.first].name == "line"
    own = about == chain.part or about not in now.facts.parts
    return own and (line or "unreachable" in {chain.code, code})


def _roots(name: str, sources: dict[str, set[str]], devices: set[str]) -> set[str]:
    """Return the parts that hold one: those without their device, and those that nothing else holds."""
    roots, seen, ahead = set(), set(), [name]
    while ahead:
        part = ahead.pop()
        if part in seen:
            continue
        seen.add(part)
        if part in devices or not sources[part]:
            roots.add(part)
        else:
            ahead.extend(sources[part])
    return roots


CAMERA = "camera_"
ORDER = ("held", "doubt", "refused", "beside", "reading", "rows", "past", "machine", "unknown", "ok")
"""The order in which links are shown: the first one counts.

A command that was just refused comes before a sensor's reading, which may block another direction than the requested
one. An overloaded machine comes after all known causes.
"""

UNEXPLAINED: frozenset[LinkName] = frozenset({"last", "refused", "machine"})
"""Links whose cause is unknown: an earlier edit of the rows is shown with them."""


def explain(now: Snapshot, part: str = "") -> Chain:
    """Return why a part, or everything that moves, stands still; raise InputError if there is nothing of that name."""
    wanted = part.strip()
    now = replace(now, asked=wanted)
    walk = Walk(now)
    holding = tuple(_links(now, walk, wanted))
    beside = () if wanted else tuple(_beside(now, walk))
    edits = tuple(walk.edited())
    links = (*holding, *beside, *edits)
    first = _first(links, len(holding))
    since = _since(edits)
    source: Literal["bus", "rows"] = "bus" if now.executive == "up" else "rows"
    name = wanted or now.facts.robot
    to_mend = () if wanted else repairs(now, explain)
    if first is None:
        text = _well(links) + since
        return Chain(
            robot=now.facts.robot, part=name, state="ok", text=text, source=source, links=links, repairs=to_mend
        )
    link = links[first]
    return Chain(
        robot=now.facts.robot,
        part=name,
        state=link.state,
        text=link.text + (since if link.name in UNEXPLAINED else ""),
        code=link.code,
        since_s=link.since_s,
        evidence=link.evidence,
        do=link.do,
        first=first,
        source=source,
        links=links,
        repairs=to_mend,
    )


def _since(edits: tuple[Link, ...]) -> str:
    """Return the text about an earlier edit."""
    return "".join(f"; {ago(one.since_s or 0.0)} ago {one.text}" for one in edits)


def _first(links: tuple[Link, ...], holding: int) -> int | None:
    """Return the index of the link to show: of past ones the newest; None if all are well.

    Links from `holding` on do not belong to what moves, and hold none of it.
    """
    ranks = [max(ORDER.index(_sort(one)), 0 if at < holding else ORDER.index("beside")) for at, one in enumerate(links)]
    ranked = [
        (rank, inf if links[at].since_s is None else links[at].since_s, at)
        if ORDER[rank] == "past"
        else (rank, 0.0, at)
        for at, rank in enumerate(ranks)
        if ORDER[rank] != "ok"
    ]
    return min(ranked)[2] if ranked else None


def _sort(link: Link) -> str:
    doubtful = link.state == "doubt" and link.name in {"reading", "rows", "machine"}
    return link.name if doubtful or link.name == "refused" else link.state


def names(facts: Facts) -> list[str]:
    """Return the names for questions: capabilities, joints, devices, external commands, words of the console."""
    words = (one.word for one in facts.sayings)
    return sorted({*facts.parts, *(one.name for one in facts.joints), *facts.devices, *facts.programs, *words})


def _links(now: Snapshot, walk: Walk, part: str) -> Iterator[Link]:
    facts = now.facts
    yield from walk.executive()
    if not part:
        yield from _whole(now, walk)
    elif part in facts.parts:
        yield from walk.asker(facts.parts[part])
        docks = _docks(facts.parts[part])
        yield from (link if docks else _away_from_dock(facts, link) for link in walk.of(part))
    elif f"{CAMERA}{part}" in facts.parts:
        yield from walk.of(f"{CAMERA}{part}")
    elif any(joint.name == part for joint in facts.joints):
        yield from _joint(now, walk, part)
    elif owners := [owner for owner in facts.parts.values() if owner.device == part]:
        for owner in owners:
            yield from walk.of(owner.name)
    elif part in facts.programs:
        yield _program(facts, part)
    elif words := [word for word in facts.sayings if word.word == _word(part)]:
        yield from _saying(walk, facts, words)
    elif now.executive == "up" or facts.parts:
        raise _unknown(part, facts)


def _whole(now: Snapshot, walk: Walk) -> Iterator[Link]:
    """Yield the links of everything that moves."""
    parts = now.facts.parts.values()
    movers = [one for one in parts if one.moves and one.enabled and one.runs and one.family == "operation"]
    for mover in movers or [one for one in parts if one.moves and one.enabled]:
        yield from (_away_from_dock(now.facts, link) for link in walk.of(mover.name))


def _beside(now: Snapshot, walk: Walk) -> Iterator[Link]:
    """Yield the faults of all other parts."""
    for one in now.facts.parts.values():
        if one.enabled and one.runs:
            yield from (
                link for link in walk.of(one.name) if link.name in {"process", "line", "fault"} and link.state != "ok"
            )


def _docks(part: Part) -> bool:
    """Return whether a part follows the beams of the dock, or sees them."""
    goes_by = part.family == "operation" and "DockSignal" in part.inputs.values()
    return goes_by or "DockSignal" in part.outputs.values()


def _away_from_dock(facts: Facts, link: Link) -> Link:
    """Return a link for a robot that does not go to its dock: away from it, no beam is seen, and all is well."""
    about = facts.parts.get(link.about)
    if link.name != "reading" or about is None or "DockSignal" not in about.outputs.values():
        return link
    return replace(link, state="ok", code="", do="")


def _joint(now: Snapshot, walk: Walk, name: str) -> Iterator[Link]:
    """Yield the links of the operation that moves a joint, without its reports about other joints."""
    row = f"row joint.{name}"
    yield Link("row", name, "ok", f"'{name}' is a joint of this robot", evidence=row)
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
        text = f"'{name}' is a program that its word starts"
        return Link("row", name, "ok", text, evidence=row)
    do = update("external_command", f"name = '{name}'", facts.robot)
    text = f"'{name}' is switched off by its row: enabled is 0"
    return Link("row", name, "held", text, "off", evidence=row, do=do)


def _word(line: str) -> str:
    """Return the word of a line of the console, or of its beginning."""
    return line.removeprefix("/").partition("/")[0]


def _saying(walk: Walk, facts: Facts, sayings: list[Saying]) -> Iterator[Link]:
    """Yield the links of the parts that lines with one word command."""
    for owner in dict.fromkeys(saying.target_part for saying in sayings):
        asked = "the robot itself" if owner == ITSELF else f"'{owner}'"
        text, row = f"'{sayings[0].word}' asks {asked}", f"row verb.{sayings[0].word}"
        yield Link("row", sayings[0].word, "ok", text, evidence=row)
        if owner in facts.parts:
            yield from walk.asker(facts.parts[owner])
        if owner != ITSELF:
            yield from walk.of(owner)


def _unknown(part: str, facts: Facts) -> InputError:
    shown = part[:64] if part.isprintable() else ascii(part[:64])
    return InputError(f"there is no part '{shown}'; {did_you_mean(part, names(facts))}", "unknown_name")


def _well(links: tuple[Link, ...]) -> str:
    return f"Nothing is wrong: {next((link.text for link in links if link.name == 'last'), 'nothing holds it')}"
