"""The plan of processes, the rows it came from, and the difference between two plans. Pure; `planner` makes one."""

from collections.abc import Container, Iterator, Mapping

import msgspec
from msgspec import Struct
from msgspec.structs import replace

from lbr.capability.config import DeviceConfig
from lbr.capability.kind import STOP, Kind
from lbr.database.rows import RobotRows
from lbr.executive.planning.process_specs import ProcessSpec, commands_of, streams_of, with_learnt
from lbr.executive.planning.wiring import EXECUTIVE
from lbr.messages import rows as row_sets
from lbr.messages.rows import RowsChanged


class Plan(Struct, frozen=True, kw_only=True):
    """The processes of a robot in start order, the rows they came from, and the verbs of their kinds."""

    robot: str
    units: dict[str, ProcessSpec]
    kinds: dict[str, Kind]
    rows: RobotRows

    @property
    def local_units(self) -> dict[str, ProcessSpec]:
        """Return the processes that run on the robot's own host."""
        return {name: unit for name, unit in self.units.items() if not unit.config.host}

    @property
    def lan(self) -> tuple[str, ...]:
        """Return the endpoints at which other machines connect."""
        return tuple(endpoint for unit in self.units.values() if unit.lan is not None for endpoint in unit.lan.listen)

    def log(self, name: str) -> str:
        """Return the log of a capability, an external command or the executive; empty for an unknown name."""
        if name in self.units:
            return self.units[name].log
        if name in self.kinds or name == EXECUTIVE:
            return f"{self.robot}-{name}.log"
        return f"{name}.log" if any(row.name == name for row in self.rows.external_commands) else ""

    def commands(self, name: str) -> tuple[str, ...]:
        """Return the commands that a process accepts."""
        return commands_of(self.units[name], self.kinds[name])

    def stoppable(self) -> tuple[str, ...]:
        """Return the processes that move something and accept a stop: movers, and programs with that command."""
        moving = (name for name, unit in self.units.items() if unit.moves or unit.program is not None)
        return tuple(name for name in moving if STOP in self.commands(name))

    def outputs(self) -> Iterator[tuple[str, str, str, type[Struct] | None]]:
        """Yield capability, port, key and message of each stream, also of setpoints; a program's has no message."""
        for unit in self.units.values():
            for port, wires in unit.config.outputs.items():
                yield from ((unit.name, port, one.key, self.kinds[unit.name].outputs.get(port)) for one in wires)

    def streams(self) -> tuple[str, ...]:
        """Return the keys of all streams that units publish under their own names."""
        return streams_of(self.robot, self.units.values())


class Change(Struct, frozen=True, kw_only=True):
    """The effect of an edit of the rows on the processes.

    A world that has to `plug` goes on, with more emulated devices; a process that is to `follow`, with other rows.
    """

    start: tuple[str, ...] = ()
    stop: tuple[str, ...] = ()
    restart: tuple[str, ...] = ()
    plug: tuple[str, ...] = ()
    follow: tuple[str, ...] = ()


def difference(before: Plan, after: Plan) -> Change:
    """Return the fewest starts, stops and restarts that lead from one plan to another."""
    changed = [name for name, unit in after.units.items() if name in before.units and unit != before.units[name]]
    plug = tuple(
        name
        for name in changed
        if after.kinds[name].rights.emulates and added_devices(before.units[name], after.units[name])
    )
    edits = {name: changed_rows(before.units[name], after.units[name]) for name in changed}
    followed = {name: {read.row.TABLE for read in after.kinds[name].reads if read.followed} for name in edits}
    follow = tuple(name for name, edit in edits.items() if edit and edit.rows.keys() <= followed[name])
    return Change(
        start=tuple(name for name in after.units if name not in before.units),
        stop=tuple(name for name in before.units if name not in after.units),
        restart=tuple(name for name in changed if name not in {*plug, *follow}),
        plug=plug,
        follow=follow,
    )


def changed_rows(before: ProcessSpec, after: ProcessSpec) -> RowsChanged | None:
    """Return the changes of the rows that a process reads; None if anything else has changed, or it runs elsewhere."""
    same = replace(after, config=replace(after.config, rows=before.config.rows)) == before
    return row_sets.changed(before.config.rows, after.config.rows) if same and not after.config.host else None


def added_devices(former: ProcessSpec, unit: ProcessSpec) -> tuple[DeviceConfig, ...]:
    """Return the devices added to a process on the robot's own host; empty if anything else has changed, too."""
    before = former.config.devices
    added = tuple(device for device in unit.config.devices if device not in before)
    kept = tuple(device for device in unit.config.devices if device in before)
    same = kept == before and replace(unit, config=replace(unit.config, devices=before)) == former
    return added if same and not unit.config.host else ()


def only(change: Change, names: Container[str]) -> Change:
    """Return the part of a change that concerns these processes."""
    start, stop, restart, plug, follow = (
        tuple(name for name in part if name in names)
        for part in (change.start, change.stop, change.restart, change.plug, change.follow)
    )
    return Change(start=start, stop=stop, restart=restart, plug=plug, follow=follow)


def learnt(plan: Plan, name: str, rows: Mapping[str, msgspec.Raw]) -> Plan:
    """Return the plan with learnt rows in a process, so that the same rows in the database do not restart it."""
    return replace(plan, units={**plan.units, name: with_learnt(plan.units[name], rows)})
