"""Oddities of rows that still run: inputs that nothing feeds, settings that a kind doubts, the user's own code."""

from collections.abc import Iterator
from pathlib import Path
from types import FunctionType

from lbr.capability import registry
from lbr.capability.kind import STOP, Kind, LackingError
from lbr.executive.planning.plan import Plan
from lbr.executive.planning.wiring import by_themselves
from lbr.messages.joints import MotionRow, MotionStep
from lbr.messages.sensing import Ranges, RangeSensor, Scan

FALLS = "humanoid_world"
"""A robot with a simulated body of this kind is a humanoid."""


def hints(plan: Plan, home: Path) -> tuple[str, ...]:
    """Return one sentence for each oddity, with its cure; none of them keeps the robot from starting."""
    return (*_lacking(plan, home), *_of_plan(plan, home), *_at_one_address(plan), *_unstable(plan))


def _of_plan(plan: Plan, home: Path) -> Iterator[str]:
    enabled = {row.name for row in plan.rows.capabilities if row.enabled}
    fed = {row.target for row in plan.rows.channels if row.enabled and row.source_end[0] in enabled}
    running = [name for name in plan.kinds if name in enabled]
    fed |= {row.target for row in by_themselves(running, plan.rows, plan.kinds)}
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
            do = "add a row for each, with its place and reach"
            yield f"'{row.name}.{distances[0]}' is fed, and range_sensor has no row of its sensors: {do}"
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


def _lacking(plan: Plan, home: Path) -> Iterator[str]:
    """Yield which capabilities are left out because the component that may have their kind is unusable."""
    for row in plan.rows.capabilities:
        if row.enabled and row.name not in plan.kinds:
            try:
                registry.find(row.kind, home)
            except LackingError as err:
                yield f"capability '{row.name}' is left out: {err}"


def _at_one_address(plan: Plan) -> Iterator[str]:
    """Yield which devices have the address of another one."""
    first: dict[str, str] = {}
    for row in plan.rows.devices:
        if (other := first.setdefault(row.address, row.name)) != row.name:
            yield f"devices '{other}' and '{row.name}' are both at {row.address}: correct one, or remove its row"


def _unstable(plan: Plan) -> Iterator[str]:
    """Yield which motions of a robot that can fall do not declare where it stands."""
    if not any(row.kind == FALLS for row in plan.rows.capabilities):
        return
    steps = plan.rows.of(MotionStep)
    known = {step.motion for step in steps if step.stable}
    legless = [row.name for row in plan.rows.of(MotionRow) if row.name not in known and row.slot is None]
    if legless and any(step.motion in legless for step in steps):
        some = ", ".join(f"'{name}'" for name in legless[:3]) + (" and others" if len(legless) > 3 else "")
        do = "lbr motion stable finds where it stands, in simulation"
        yield f"no key frame of {some} is stable: stopped on its way, the robot is held at once and may fall; {do}"


def _doubts(kind: Kind, settings: str) -> tuple[str, ...]:
    """Return the doubts of the settings about themselves; a user's own kind may have a field of that name instead."""
    doubts = getattr(kind.settings, "doubts", None)
    return tuple(doubts(kind.parse(settings))) if isinstance(doubts, FunctionType) else ()
