"""The rules for running a robot's processes on another machine: which a profile may place there. Pure."""

import re
from collections.abc import Iterator

from lbr.database.reading import Problem
from lbr.database.rows import CapabilityRow
from lbr.executive.planning.draft import Draft
from lbr.executive.planning.sharing import LAN
from lbr.executive.planning.wiring import EXECUTIVE

_NAME = re.compile(r"[a-z][a-z0-9_]{0,39}")


def problems(draft: Draft) -> Iterator[Problem]:
    """Yield the faults in the hosts of a profile."""
    for host, text in _misplaced(draft):
        yield Problem("profile", draft.profile.robot, f"hosts.{host}" if host else "plugged_in_elsewhere", text)


def _misplaced(draft: Draft) -> Iterator[tuple[str, str]]:
    known, profile = draft.rows.names(CapabilityRow), draft.profile
    placed: dict[str, str] = {}
    for host, names in profile.hosts.items():
        if _NAME.fullmatch(host) is None:
            yield host, f"'{host[:40]}' is not a host's name: small letters, digits and _, a letter first"
        for name in names:
            if name not in known:
                yield host, f"there is no capability '{name}'"
            elif name in placed:
                yield host, f"'{name}' is placed on '{placed[name]}' already"
            elif name in draft.kinds and (why := _why_it_stays(draft, name, host)):
                yield host, f"'{name}' stays on the robot's own host: {why}"
            placed.setdefault(name, host)
    for name in sorted(set(profile.plugged_in_elsewhere) - set(placed)):
        yield "", f"'{name}' is placed on no host"


def _why_it_stays(draft: Draft, name: str, host: str) -> str:
    kind, profile = draft.kinds[name], draft.profile
    targets = [row.target_end for row in draft.rows.channels if row.enabled and row.source_end[0] == name]
    fed = [target for target in targets if target[1] in getattr(draft.kinds.get(target[0]), "setpoints", ())]
    whys = {
        "it is the door that the host comes in by": kind.name == LAN,
        "it is the world that the emulated devices are in": kind.family == "simulation",
        f"it takes setpoints ({', '.join(sorted(kind.setpoints))}), and what drives a motor is where the motor is": (
            bool(kind.setpoints)
        ),
        "it may change rows or say lines, which only the robot's own processes may": EXECUTIVE
        in {target for target, _ in targets},
        f"it decides the setpoints of '{fed[0][0] if fed else ''}', and they cross no network": bool(fed),
        f"its device ({kind.device_type}) is emulated there": bool(kind.device_type) and profile.simulate,
        f"it owns a device ({kind.device_type}); if that is plugged in at '{host}', say so in the profile: "
        f'plugged_in_elsewhere = ["{name}"]': bool(kind.device_type) and name not in profile.plugged_in_elsewhere,
    }
    return next((why for why, holds in whys.items() if holds), "")
