"""The rules between capabilities: a channel joins ports of one type, a verb names a command that exists.

The database checks that the capabilities in these rows exist; unknown ones are ignored here.
"""

import re
from collections.abc import Iterable, Iterator, Mapping
from collections.abc import Set as AbstractSet

import msgspec
from msgspec import Struct

from lbr.capability.kind import Kind
from lbr.database.reading import Problem
from lbr.database.rows import ChannelRow, RobotRows, VerbRow
from lbr.executive.planning.draft import ANY, Draft
from lbr.messages.faces import EditCommand
from lbr.messages.system import EstopResetCommand, LineCommand, Role

EXECUTIVE = "executive"
EXECUTIVE_COMMANDS: Mapping[str, type[Struct]] = {
    "edit": EditCommand,
    "estop_reset": EstopResetCommand,
    "line": LineCommand,
}
"""Requests of capabilities to the executive, if their rows wire them to it."""

EXECUTIVE_VERBS: Mapping[str, frozenset[str]] = {
    "stop": frozenset({"reason"}),
    "report": frozenset({"name"}),
    "estop": frozenset({"reason"}),
    "restart": frozenset({"name"}),
    "pair": frozenset({"role"}),
    "why": frozenset({"part"}),
    **dict.fromkeys(("reset", "help", "shutdown", "status", "phone", "open", "close"), frozenset()),
}
"""The commands of the executive itself, and the fields of each."""

EXECUTIVE_ROLES: Mapping[str, Role] = {
    **dict.fromkeys(("stop", "estop", "status", "help", "report", "why"), "view"),
    "reset": "operate",
    **dict.fromkeys(("restart", "shutdown", "phone", "pair", "open", "close"), "admin"),
}
"""The lowest role that may use each."""


def least_roles(kinds: Mapping[str, Kind]) -> dict[str, Role]:
    """Return the lowest role for each command of a robot, by `capability.command`, as its kind declares it."""
    found = {f"{EXECUTIVE}.{command}": role for command, role in EXECUTIVE_ROLES.items()}
    return found | {
        f"{name}.{command}": kind.role(command) for name, kind in kinds.items() for command in kind.commands
    }


_FIELD = re.compile(r"\{([a-z_]+)(?:\.\.\.)?\}")


def check_channels(draft: Draft) -> Iterator[Problem]:
    """Yield the faults in the channel rows."""
    feeders: dict[str, str] = {}
    for row, label, bad in draft.rows.every(ChannelRow):
        yield from _check_channel(draft, row, label, bad)
        target, port = row.target_end
        if not bad and row.enabled and target in draft.kinds and port in draft.kinds[target].setpoints:
            if row.target in feeders:
                text = f"'{feeders[row.target]}' feeds it already, and a setpoint has one writer"
                yield Problem("channel", label, "target", text)
            feeders[row.target] = row.source


def _check_channel(draft: Draft, row: ChannelRow, label: str, bad: AbstractSet[str]) -> Iterator[Problem]:
    """Yield the faults in the ends of a channel, except in columns that are already bad."""
    source, target = row.source_end, row.target_end
    from_known = "source" not in bad and source[0] in draft.kinds
    to_known = "target" not in bad and target[0] in {EXECUTIVE, *draft.kinds}
    sent = draft.ports(source[0], "outputs", "requests") if from_known else {}
    asks = source[1] in draft.ports(source[0], "requests") if from_known else None
    accepted = _accepted_ports(draft, target[0], asks) if to_known else {}
    if from_known and source[1] not in sent:
        yield Problem("channel", label, "source", _no_port(source, "output", sent))
    if to_known and target[1] not in accepted:
        yield Problem("channel", label, "target", _no_port(target, "command" if asks else "input", accepted))
    sends, takes = sent.get(source[1]), accepted.get(target[1])
    if sends is not None and takes is not None and not _same(sends, takes):
        names_of = f"{sends.__name__}, and {row.target} takes {takes.__name__}"
        yield Problem("channel", label, "target", f"{row.source} sends {names_of}")


def by_themselves(names: Iterable[str], rows: RobotRows, kinds: Mapping[str, Kind]) -> Iterator[ChannelRow]:
    """Yield the channels that kinds wire by themselves, between running capabilities; a port's own row has priority."""
    names = tuple(names)
    given = {end for row in rows.channels for end in (row.source_end, row.target_end)}
    for name in names:
        for port, wire in kinds[name].wires.items():
            if (name, port) in given:
                continue
            asks = port in kinds[name].requests
            for other in names:
                there = _same_type(kinds[name], port, kinds[other], wire.to, asks=asks)
                if there and other != name:
                    mine, theirs = f"{name}.{port}", f"{other}.{there}"
                    source, target = (mine, theirs) if asks else (theirs, mine)
                    yield ChannelRow(source=source, target=target, history=wire.history)


def _same_type(kind: Kind, port: str, peer: Kind, to: str, *, asks: bool) -> str:
    """Return the port of another kind for such a wire, empty if none has its type."""
    of, _, name = to.rpartition(".")
    wanted = (kind.requests if asks else kind.inputs)[port]
    found = (peer.messages if asks else peer.outputs).get(name)
    return name if of in {"", peer.name} and found is wanted else ""


def _accepted_ports(draft: Draft, name: str, asks: bool | None) -> dict[str, type[Struct]]:
    """Return the ports that accept requests or streams; both, if it is unknown which one the channel carries."""
    if name == EXECUTIVE:
        return {} if asks is False else dict(EXECUTIVE_COMMANDS)
    groups = ("commands",) * (asks is not False) + ("inputs", "setpoints") * (asks is not True)
    return draft.ports(name, *groups)


def _same(sends: type[Struct], takes: type[Struct]) -> bool:
    """Return whether two ports carry one type; a user's files may declare the same type twice."""
    if sends is takes or ANY in {sends, takes}:
        return True
    return bool(msgspec.json.schema(sends) == msgspec.json.schema(takes))


def _no_port(end: tuple[str, str], what: str, there: Iterable[str]) -> str:
    return f"'{end[0]}' has no {what} '{end[1]}'; it has {', '.join(sorted(there)) or 'none'}"


def check_verbs(draft: Draft) -> Iterator[Problem]:
    """Yield the faults in the verb rows."""
    for row, label, bad in draft.rows.every(VerbRow):
        yield from _check_verb(draft, row, label, bad)


def _check_verb(draft: Draft, row: VerbRow, label: str, bad: AbstractSet[str]) -> list[Problem]:
    """Return the faults in its target, its pattern and its payload, except in columns that are already bad."""
    owner, command = row.target_end
    if "target" in bad or owner not in {EXECUTIVE, *draft.kinds}:
        return []
    if owner == EXECUTIVE and command not in EXECUTIVE_VERBS:
        there = ", ".join(f"executive.{name}" for name in sorted(EXECUTIVE_VERBS))
        return [Problem("verb", label, "target", f"the executive has no '{command}'; it has {there}")]
    if owner == EXECUTIVE:
        return _check_fields(row, label, bad, EXECUTIVE_VERBS[command])
    commands = draft.ports(owner, "commands")
    if command not in commands:
        return [Problem("verb", label, "target", _no_port((owner, command), "command", commands))]
    if commands[command] is ANY:
        return []
    return _check_fields(row, label, bad, {field.name for field in msgspec.structs.fields(commands[command])})


def _check_fields(row: VerbRow, label: str, bad: AbstractSet[str], fields: AbstractSet[str]) -> list[Problem]:
    there = ", ".join(sorted(fields)) or "none"
    return [
        Problem("verb", label, column, f"{row.target} has no field '{name}'; it has {there}")
        for column, used in (("pattern", _FIELD.findall(row.pattern)), ("payload", row.payload or {}))
        for name in used
        if column not in bad and name not in fields
    ]
