"""The rules for sharing a process. Pure.

Capabilities of one process have the same rights on the bus, and end together when one fails. So a capability near a
motor shares only with others near a motor. The same holds for those that act in people's names, and for those that
record everything.
"""

from collections import Counter
from collections.abc import Iterator

from msgspec import Struct

from lbr.capability.kind import Kind
from lbr.capability.program import ProgramSettings
from lbr.database.reading import Problem
from lbr.database.rows import CapabilityRow
from lbr.executive.planning.draft import Draft

LAN = "lan"
"""The kind that is the door to other machines."""


def user(name: str, process: str) -> str:
    """Return a capability's name on the bus: its own, or that of its shared process, which contains a dot."""
    return f"process.{process}" if process else name


def problems(draft: Draft) -> Iterator[Problem]:
    """Yield the problems of shared processes among the chosen capabilities; other machines share none."""
    members: dict[str, list[str]] = {}
    for row in draft.chosen:
        if row.process and not draft.profile.host_of(row.name):
            members.setdefault(row.process, []).append(row.name)
    for process in sorted(members):
        for name, text in _conflicts(draft, process, members[process]):
            yield draft.problem(name, "process", text)


def _conflicts(draft: Draft, process: str, members: list[str]) -> Iterator[tuple[str, str]]:
    steering = frozenset(message for kind in draft.kinds.values() for message in kind.setpoints.values())
    near = {name: _near(draft.kinds[name], steering) for name in members}
    usual = Counter(near.values()).most_common(1)[0][0]
    like = next(name for name in members if near[name] == usual)
    for name in members:
        if process in draft.rows.names(CapabilityRow):
            yield name, f"'{process}' is a capability; choose another name for a process that several share"
        elif why := _why_alone(draft.kinds[name]):
            yield name, f"'{name}' has a process of its own: {why}; set it to ''"
        elif near[name] != usual:
            text = f"'{name}' {near[name]}, and '{like}' {usual}"
            yield name, f"{text}: they may not share the process '{process}'"


def _why_alone(kind: Kind) -> str:
    whys = {
        "it is a program": kind.settings is ProgramSettings,
        "it is a router of the bus": kind.name == LAN,
        "it is the world that the emulated devices are in": kind.family == "simulation",
    }
    return next((why for why, holds in whys.items() if holds), "")


def _near(kind: Kind, steering: frozenset[type[Struct]]) -> str:
    """Return the group within which a kind may share a process; `steering` are the messages that drive motors."""
    if kind.device or kind.setpoints or steering & set(kind.outputs.values()):
        return "is near a motor or a device"
    if kind.rights.people:
        return "acts in people's names"
    return "records everything" if kind.rights.records else "does nothing of that kind"
