"""The repairs of a robot: its faulty parts, by the part that holds them."""

from collections.abc import Callable

from lbr.messages.why import Chain, Repair
from lbr.why.snapshot import Snapshot

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
