"""The rows with which a robot would use attached devices: device, capability, channels. Pure; nothing is written."""

from collections.abc import Collection, Iterator, Mapping

import msgspec
from msgspec import Struct

from lbr.capability.kind import Kind
from lbr.commands.recognised import Attached, node_of
from lbr.database.rows import CapabilityRow, ChannelRow, DeviceRow, RobotRows
from lbr.messages.manage import RowChange
from lbr.names import first_free


class Proposal(Struct, frozen=True, kw_only=True):
    """Changes of rows for one attached device, and their `text`; without changes, the rows are complete.

    The preview of the changes is their `differences` and `problems`.
    """

    address: str
    text: str
    changes: list[RowChange] = []
    differences: tuple[str, ...] = ()
    problems: tuple[str, ...] = ()


def propose(
    rows: RobotRows, kinds: Mapping[str, Kind], ends: Collection[Attached], present: Collection[str], called: str = ""
) -> tuple[list[Attached], list[Proposal]]:
    """Return the found devices with their existing rows, and a proposal for each device without one.

    `present` are the nodes that exist now: a device row with another node waits for its device. `called` is the device
    row to make or to move, if the user names one.
    """
    nodes = {node_of(row): row for row in rows.devices}
    known = [msgspec.structs.replace(end, row=_row_at(end, nodes)) for end in ends]
    waiting = [
        row
        for row in rows.devices
        if node_of(row) not in present and row.address.partition(":")[0] not in {"sim", "alsa"}
    ]
    names = set(rows.names(DeviceRow)), set(rows.names(CapabilityRow))
    proposals = []
    for end in known:
        if not end.type or end.row or end.held:
            continue
        alike = [twin for twin in known if twin.type == end.type and not twin.row]
        mine = [row for row in waiting if row.type == end.type]
        if called:
            mine = [row for row in rows.devices if row.name == called]
        if len(mine) == 1 and (len(alike) == 1 or called):
            proposals.append(_moved(end, mine[0]))
        elif mine and not called:
            rows_of = " and ".join(f"'{row.name}'" for row in mine)
            text = (
                f"{len(alike)} of type {end.type} are here, and {rows_of} waits for one: say which, by --port and --as"
            )
            proposals.append(Proposal(address=end.address, text=text))
        else:
            proposals.append(_added(end, rows, kinds, names, called))
            rows = _wired(rows, proposals[-1].changes)
    return known, proposals


def _row_at(one: Attached, nodes: Mapping[str, DeviceRow]) -> str:
    place = one.address if one.place == "i2c" else one.path
    row = nodes.get(place) or nodes.get(one.address)
    return row.name if row is not None else ""


def _moved(end: Attached, row: DeviceRow) -> Proposal:
    before = {"name": row.name, "address": row.address}
    after = {"name": row.name, "address": end.address}
    if row.type != end.type:
        return Proposal(
            address=end.address,
            text=f"device '{row.name}' is of type {row.type}, and this is a {end.type}: say another name",
        )
    text = f"device '{row.name}' waits for one at {row.address}: use this one"
    return Proposal(address=end.address, text=text, changes=[RowChange(table="device", before=before, after=after)])


def _added(
    end: Attached, rows: RobotRows, kinds: Mapping[str, Kind], names: tuple[set[str], set[str]], called: str
) -> Proposal:
    name = called or first_free(end.type, names[0].__contains__)
    names[0].add(name)
    device = RowChange(table="device", after={"name": name, "type": end.type, "address": end.address})
    kind = next((kind for kind in kinds.values() if kind.device_type == end.type), None)
    if kind is None:
        return Proposal(address=end.address, text=f"add it as device '{name}'", changes=[device])
    capability = first_free(called or kind.name, names[1].__contains__)
    names[1].add(capability)
    settings = {"device": name, **end.settings}
    row = RowChange(table="capability", after={"name": capability, "kind": kind.name, "settings": settings})
    channels = list(_channels(capability, kind, rows, kinds))
    waiting = list(_waiting(kind, rows, kinds))
    if channels:
        wired = f", wired by {len(channels)} channels"
    else:
        is_read = bool(waiting) or not kind.outputs
        wired = "" if is_read else ", which nothing reads yet: add rows of the table 'channel'"
    on = f"; switch on {' and '.join(waiting)}, for which it is" if waiting else ""
    return Proposal(
        address=end.address,
        text=f"add it as device '{name}', with the capability '{capability}' of kind '{kind.name}'{wired}{on}",
        changes=[*_needed(end, rows, kinds), device, row, *channels, *map(_switched_on, waiting)],
    )


def _waiting(kind: Kind, rows: RobotRows, kinds: Mapping[str, Kind]) -> Iterator[str]:
    """Yield the disabled capabilities whose rows need a capability of this kind."""
    for row in rows.capabilities:
        theirs = kinds.get(row.kind)
        if theirs is None or row.enabled:
            continue
        needed = (wire.to for port, wire in theirs.wires.items() if port not in theirs.optional)
        if any(to == f"{kind.name}.{output}" for to in needed for output in kind.outputs):
            yield row.name


def _switched_on(name: str) -> RowChange:
    before, after = ({"name": name, "enabled": value} for value in (False, True))
    return RowChange(table="capability", before=before, after=after)


def _needed(one: Attached, rows: RobotRows, kinds: Mapping[str, Kind]) -> Iterator[RowChange]:
    """Yield the rows that its driver reads and the robot lacks."""
    classes = {read.row.TABLE: read.row for kind in kinds.values() for read in kind.reads}
    for table, values in one.needs:
        row = classes.get(table)
        there = {getattr(found, "name", None) for found in rows.of(row)} if row is not None else set()
        if values["name"] not in there:
            yield RowChange(table=table, after=dict(values))


def _wired(rows: RobotRows, changes: Collection[RowChange]) -> RobotRows:
    """Return the rows with these channels, so that a later device does not feed the same port."""
    channels = (ChannelRow(**change.after) for change in changes if change.table == "channel" and change.after)
    return msgspec.structs.replace(rows, channels=(*rows.channels, *channels))


def _channels(name: str, kind: Kind, rows: RobotRows, kinds: Mapping[str, Kind]) -> Iterator[RowChange]:
    """Yield channels to the robot's unfed ports; ports that kinds wire by themselves need no row."""
    targets, sources = {row.target for row in rows.channels}, {row.source for row in rows.channels}
    for capability in rows.capabilities:
        theirs = kinds.get(capability.kind)
        if theirs is None:
            continue
        for output, message in kind.outputs.items():
            for port, taken in theirs.inputs.items():
                if taken is message and port not in theirs.wires and f"{capability.name}.{port}" not in targets:
                    yield _channel(f"{name}.{output}", f"{capability.name}.{port}")
        for port, message in kind.setpoints.items():
            for output, sent in theirs.outputs.items():
                if sent is message and f"{capability.name}.{output}" not in sources:
                    yield _channel(f"{capability.name}.{output}", f"{name}.{port}")


def _channel(source: str, target: str) -> RowChange:
    return RowChange(table="channel", after={"source": source, "target": target})
