"""The values of a field of a line on this robot, for completion: by its kind, out of its rows and files."""

from collections.abc import Iterable
from pathlib import Path
from typing import TypeVar, get_args

from lbr.database.rows import BUILT_IN_VERBS
from lbr.executive.planning.facts import facts
from lbr.executive.planning.plan import Plan
from lbr.messages.rows import Row
from lbr.messages.system import Role
from lbr.why import chain as why

R = TypeVar("R", bound=Row)
REPORTS = ("telemetry", "settings", "statistics", "health", "events", "wiring", "robot", "streams", "rows")


class _Known:
    """A robot's known values for the fields of one capability's commands."""

    def __init__(self, plan: Plan, home: Path, name: str) -> None:
        self.home = home
        self.devices = tuple(device.name for device in plan.rows.devices)
        self.wired = tuple(one.target_end[0] for one in plan.rows.channels if one.source_end[0] == name)
        self._plan = plan

    def rows(self, row: type[R]) -> tuple[R, ...]:
        """Return the rows of a table."""
        return self._plan.rows.of(row)


def choices(plan: Plan, home: Path) -> dict[str, Iterable[str]]:
    """Return the known values by `capability.command` for its first field, by `capability.command.field` for others."""
    values: dict[str, Iterable[str]] = {
        "executive.report": REPORTS,
        "executive.help": sorted({row.word for row in (*BUILT_IN_VERBS, *plan.rows.verbs)}),
        "executive.restart": tuple(plan.units),
        "executive.pair": get_args(Role),
        "executive.why": why.names(facts(plan)),
    }
    for name, kind in plan.kinds.items():
        known = _Known(plan, home, name)
        for command in kind.commands:
            for field, may_be in kind.command(command).choices.items():
                values[f"{name}.{command}.{field}"] = may_be(known)
    return values
