"""What is odd in rows that run all the same: inputs that nothing feeds, settings that a kind doubts, code of one's own."""

from collections.abc import Iterator
from pathlib import Path
from types import FunctionType

from lbr.capability import registry
from lbr.capability.kind import STOP, Kind
from lbr.executive.planning.plan import Plan
from lbr.messages.sensing import Ranges, RangeSensor, Scan


def hints(plan: Plan, home: Path) -> tuple[str, ...]:
    """Return a sentence for each, with what to do; a robot starts with all of them."""
    return tuple(_found(plan, home))


def _found(plan: Plan, home: Path) -> Iterator[str]:
    enabled = {row.name for row in plan.rows.capabilities if row.enabled}
    fed = {row.target for row in plan.rows.channels if row.enabled and row.source_end[0] in enabled}
    for row in plan.rows.capabilities:
        if row.name not in enabled or row.name not in plan.kinds:
            continue
        kind = plan.kinds[row.name]
        for port in (*kind.inputs, *kind.setpoints):
            if f"{row.name}.{port}" not in fed and port not in kind.optional:
                do = f"add a channel whose target is '{row.name}.{port}', or enable its source"
                yield f"nothing feeds '{row.name}.{port}': {do}"
        distances = [
            port for port, message in kind.inputs.items() if message in {Ranges, Scan} and f"{row.name}.{port}" in fed
        ]
        if distances and RangeSensor in {read.row for read in kind.reads} and not plan.rows.of(RangeSensor):
            do = "add a row for each, with where it sits and what it sees"
            yield f"'{row.name}.{distances[0]}' is fed, and no row of range_sensor says which sensors those are: {do}"
        for doubt in _doubts(kind, row.settings):
            yield f"capability '{row.name}', settings: {doubt}"
        if kind.moves and STOP not in kind.commands and not kind.setpoints:
            do = f"give kind '{kind.name}' a command `stop`, or a setpoint that the drive feeds"
            yield f"capability '{row.name}' moves something, and `stop` does not reach it: {do}"
        if unused := registry.shadowed(row.kind, home):
            do = "rename the file and its KIND"
            yield f"capability '{row.name}' does not run {unused}: an installed kind has that name; {do}"
        if registry.fingerprint(row.kind, home):
            place = registry.user_directory(home) / f"{row.kind}.py"
            yield f"capability '{row.name}' runs code that did not ship with lbr: {place}"


def _doubts(kind: Kind, settings: str) -> tuple[str, ...]:
    """Return what the settings themselves find odd; those of a kind of the user's own may have a field of that name."""
    doubts = getattr(kind.settings, "doubts", None)
    return tuple(doubts(kind.parse(settings))) if isinstance(doubts, FunctionType) else ()
