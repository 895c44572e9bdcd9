"""The rules for sharing a process. Pure.

Capabilities of one process have the same rights on the bus, and end together when one fails. So a capability near a
motor shares only with others near a motor. The same holds for those that act in people's names, and for those that
record everything.
"""

from collections import Counter
from collections.abc import Collection, Iterator, Mapping
from itertools import groupby

from msgspec import Struct

from lbr.capability.kind import Kind
from lbr.capability.program import ProgramSettings
from lbr.database.reading import Problem
from lbr.database.rows import CapabilityRow, RobotRows
from lbr.executive.planning.profile import Profile

LAN = "lan"
"""The kind that is the door to other machines."""


def user(name: str, process: str) -> str:
    """Return a capability's name on the bus: its own, or that of its shared process, which contains a dot."""
    return f"process.{process}" if process else name


def problems(
    rows: RobotRows, chosen: Collection[CapabilityRow], kinds: Mapping[str, Kind], profile: Profile
) -> list[Problem]:
    """Return the problems of shared processes among the chosen capabilities; other machines share none."""
    names = rows.names("capability")
    steering = frozenset(message for kind in kinds.values() for message in kind.setpoints.values())
    near = {row.name: _near(kinds[row.name], steering) for row in chosen}
    sharing = sorted(
        (row for row in chosen if row.process and not profile.host_of(row.name)), key=lambda row: row.process
    )
    return [
        Problem("capability", f"{rows.robot.name}/{row.name}", "process", text)
        for process, members in groupby(sharing, key=lambda row: row.process)
        for row, text in _conflicts(process, list(members), names, kinds, near)
    ]


def _conflicts(
    process: str,
    members: list[CapabilityRow],
    names: Collection[str],
    kinds: Mapping[str, Kind],
    near: Mapping[str, str],
) -> Iterator[tuple[CapabilityRow, str]]:
    usual = Counter(near[row.name] for row in members).most_common(1)[0][0]
    like = next(row for row in members if near[row.name] == usual)
    for row in members:
        if process in names:
            yield row, f"'{process}' is a capability; choose another name for a process that several share"
        elif why := _why_alone(kinds[row.name]):
            yield row, f"'{row.name}' has a process of its own: {why}; set it to ''"
        elif near[row.name] != usual:
            text = f"'{row.name}' {near[row.name]}, and '{like.name}' {usual}"
            yield row, f"{text}: they may not share the process '{process}'"


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
