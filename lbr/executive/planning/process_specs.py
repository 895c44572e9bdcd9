"""From a row to the document of its process: settings, wiring, devices, connections to the bus. Pure."""

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Literal

import msgspec
from msgspec import Struct
from msgspec.structs import asdict, replace

from lbr.bus import keys
from lbr.bus.access import Credentials, Rights
from lbr.bus.door import LanConfig, LanGuest, LanUser, TokenRight
from lbr.capability import registry
from lbr.capability.config import DeviceConfig, InputWire, OutputWire, ProcessConfig
from lbr.capability.kind import Kind
from lbr.capability.kind import Rows as Read
from lbr.capability.program import ProgramSettings
from lbr.database.rows import CapabilityRow, ChannelRow, RobotRows
from lbr.executive.planning import sharing
from lbr.executive.planning.credentials import token_secret
from lbr.executive.planning.devices import device_address
from lbr.executive.planning.profile import Profile
from lbr.executive.planning.run_identity import RunIdentity
from lbr.executive.planning.sharing import LAN
from lbr.executive.planning.wiring import EXECUTIVE
from lbr.messages.calibration import CalibrationValue
from lbr.messages.rows import Row, RowSet, row_set, with_rows


class ProcessSpec(Struct, frozen=True, kw_only=True):
    """One process of the plan; two equal specs need no restart. Only the door to other machines uses `lan`."""

    name: str
    kind: str
    family: str
    moves: bool
    serves: bool = False
    serves_people: bool = False
    records: bool = False
    restart: str
    needs: tuple[str, ...]
    config: ProcessConfig
    fingerprint: str = ""
    program: ProgramSettings | None = None
    lan: LanConfig | None = None

    @property
    def process(self) -> str:
        """Return the name of its process: a shared one, or its own."""
        return self.config.process or self.name

    @property
    def log(self) -> str:
        """Return the name of its log, which is that of its process."""
        return f"{self.config.robot}-{self.process}.log"

    @property
    def guarded(self) -> bool:
        """Return whether it may leave a guard behind, which sends the last command on its line."""
        return self.family == "driver" and self.program is None


def unit(
    row: CapabilityRow,
    kinds: Mapping[str, Kind],
    settings: Struct,
    rows: RobotRows,
    channels: list[ChannelRow],
    profile: Profile,
    site: RunIdentity,
    running: set[str],
) -> ProcessSpec:
    """Return the process of a capability row, wired by `channels` to the capabilities that run."""
    kind = kinds[row.name]
    robot, host = rows.robot.name, profile.host_of(row.name)
    process = "" if host else row.process
    devices = tuple(
        DeviceConfig(
            name=d.name,
            type=d.type,
            address=device_address(d, kinds.values(), profile, site, robot),
            settings=d.settings,
        )
        for d in rows.devices
        if kind.family == "simulation" or (kind.device and d.name == getattr(settings, "device", None))
    )
    device = getattr(settings, "device", "") if kind.device else ""
    ports = settings if isinstance(settings, ProgramSettings) else kind
    config = ProcessConfig(
        robot=robot,
        name=row.name,
        kind=row.kind,
        settings=_compact(row.settings),
        simulated=profile.simulate,
        endpoints=() if host else site.endpoints,
        credentials=_guest(host, row.name, rows, site) if host else site.credentials(sharing.user(row.name, process)),
        home="" if host else site.home,
        host=host,
        source="" if host else registry.source(row.kind),
        process=process,
        device=device,
        devices=devices,
        wiring=_wiring(row.name, kinds, channels, site, robot),
        outputs={name: _outputs(row.name, name, kinds, channels, site, robot) for name in ports.outputs},
        requests=_requests(row.name, kinds, channels, robot),
        rows={read.row.TABLE: _read(read, settings, rows, site, profile) for read in kind.reads},
        release_key=site.seal(keys.estop_release(robot, row.name)),
    )
    return ProcessSpec(
        name=row.name,
        kind=row.kind,
        family=kind.family,
        moves=kind.moves,
        serves=kind.rights.serves,
        serves_people=kind.rights.people and not host,
        records=kind.rights.records and not host,
        restart=row.restart,
        needs=tuple(need for need in row.needs if need in running),
        config=config,
        fingerprint=registry.fingerprint(row.kind, Path(site.home)),
        program=settings if isinstance(settings, ProgramSettings) else None,
    )


def with_lan(
    unit: ProcessSpec,
    units: Mapping[str, ProcessSpec],
    kinds: Mapping[str, Kind],
    rows: RobotRows,
    site: RunIdentity,
    rights: Mapping[str, Rights],
) -> ProcessSpec:
    """Return the unit; the door to other machines receives its users and their rights.

    `rights` are those of the processes on other machines.
    """
    if unit.kind != LAN:
        return unit
    robot = rows.robot.name
    peers = [peer for peer in units.values() if peer.name != unit.name]
    local_commands, remote_commands = (
        {
            keys.port(robot, peer.name, command): kinds[peer.name].role(command)
            for peer in peers
            if bool(peer.config.host) is elsewhere
            for command in commands_of(peer, kinds[peer.name])
        }
        for elsewhere in (False, True)
    )
    folder = Path(site.home) / "credentials"
    config = LanConfig(
        listen=tuple(asdict(kinds[unit.name].parse(bytes(unit.config.settings)))["listen"]),
        link=site.credentials(f"@{unit.name}"),
        users=_users(rows, site, "bus"),
        streams=streams_of(robot, peers),
        subscribed=tuple(sorted({key for _unit, key in _put(peers)})),
        stops=tuple(key for key, role in (local_commands | remote_commands).items() if role == "view"),
        commands={key: role for key, role in local_commands.items() if role != "view"},
        guests=tuple(
            LanGuest(credentials=peer.config.credentials, rights=rights[peer.name])
            for peer in peers
            if peer.config.host and peer.config.credentials is not None
        ),
        theirs={key: role for key, role in remote_commands.items() if role != "view"},
        private_key=str(folder / "bus.key"),
        certificate=str(folder / "bus.crt"),
    )
    return replace(unit, lan=config)


def with_learnt(unit: ProcessSpec, rows: Mapping[str, msgspec.Raw]) -> ProcessSpec:
    """Return a process that already has these rows, by table, if it reads such tables."""
    return replace(unit, config=replace(unit.config, rows=with_rows(unit.config.rows, rows)))


def read_by(read: Read, settings: Struct, rows: Iterable[Row]) -> tuple[Row, ...]:
    """Return the rows of a table that a kind receives with such settings."""
    wanted = {column: getattr(settings, setting) for column, setting in read.where.items()}
    return tuple(row for row in rows if all(_fits(getattr(row, column), value) for column, value in wanted.items()))


def _fits(column: object, setting: object) -> bool:
    return column == setting or "" in (column, setting)


def commands_of(unit: ProcessSpec, kind: Kind) -> tuple[str, ...]:
    """Return the commands that a process accepts."""
    return tuple(unit.program.commands if unit.program is not None else kind.commands)


def streams_of(robot: str, units: Iterable[ProcessSpec]) -> tuple[str, ...]:
    """Return the keys of the streams that units publish under their own names."""
    return tuple(sorted({key for unit, key in _put(units) if key.startswith(f"{robot}/{unit.name}/")}))


def _put(units: Iterable[ProcessSpec]) -> Iterator[tuple[ProcessSpec, str]]:
    """Yield every key to which processes publish: streams, and setpoints for others."""
    return ((unit, wire.key) for unit in units for wires in unit.config.outputs.values() for wire in wires)


def _read(read: Read, settings: Struct, rows: RobotRows, site: RunIdentity, profile: Profile) -> RowSet:
    """Return the rows of a table that a kind reads: users with the secrets of their tokens, rights without."""
    if read.row is LanUser:
        return row_set(read.row, _users(rows, site, "web"))
    if read.row is TokenRight:
        return row_set(read.row, read_by(read, settings, (TokenRight(name=t.name, role=t.role) for t in rows.tokens)))
    if read.row is CalibrationValue:
        return row_set(read.row, read_by(read, settings, _calibration(rows.of(CalibrationValue), profile)))
    return row_set(read.row, read_by(read, settings, rows.of(read.row)))


def _calibration(rows: Iterable[CalibrationValue], profile: Profile) -> tuple[CalibrationValue, ...]:
    """Return the calibration in the rows, and the profile's for devices without such rows."""
    known = tuple(rows)
    measured = {row.device for row in known}
    return known + tuple(
        CalibrationValue(device=device, name=name, value=value, measured_at="")
        for device, found in profile.calibration.items()
        if device not in measured
        for name, value in found.items()
    )


def _users(rows: RobotRows, site: RunIdentity, door: Literal["bus", "web"]) -> tuple[LanUser, ...]:
    """Return the tokens that are valid for a door; it does not even learn about those for the other door."""
    return tuple(
        LanUser(name=t.name, role=t.role, hash=t.hash, secret=token_secret(site.token_key, t.name, t.created_at))
        for t in rows.tokens
        if t.lets_in(door)
    )


def _guest(host: str, name: str, rows: RobotRows, site: RunIdentity) -> Credentials | None:
    """Return the credentials of a process on another machine, which become invalid with its host's token."""
    token = next((one for one in rows.tokens if one.name == host and one.role == "host" and one.lets_in("bus")), None)
    if token is None:
        return None
    password = site.seal(f"password of {name} on {host} since {token.created_at}")
    return Credentials(user=f"{host}.{name}", password=password)  # no token's name has a dot


def _compact(settings: str) -> msgspec.Raw:
    """Return the settings without white space: the document is one line, and white space restarts nothing."""
    return msgspec.Raw(msgspec.json.encode(msgspec.json.decode(settings)))


def _is_setpoint(target: tuple[str, str], kinds: Mapping[str, Kind]) -> bool:
    return target[1] in kinds[target[0]].setpoints


def _wiring(
    name: str, kinds: Mapping[str, Kind], channels: list[ChannelRow], site: RunIdentity, robot: str
) -> dict[str, tuple[InputWire, ...]]:
    wires: dict[str, tuple[InputWire, ...]] = {}
    for channel in channels:
        (source, output), (target, port) = channel.source_end, channel.target_end
        if target != name or output in kinds[source].requests:
            continue
        addressed = _is_setpoint((target, port), kinds)
        key = keys.port(robot, target, port) if addressed else keys.port(robot, source, output)
        wire = InputWire(
            key=key,
            source=source,
            rate_hz=channel.rate_hz,
            history=channel.history,
            seal=site.seal(key) if kinds[source].family != "program" else "",
        )
        wires[port] = (*wires.get(port, ()), wire)
    return wires


def _outputs(
    name: str, output: str, kinds: Mapping[str, Kind], channels: list[ChannelRow], site: RunIdentity, robot: str
) -> tuple[OutputWire, ...]:
    setpoints = [
        keys.port(robot, *channel.target_end)
        for channel in channels
        if channel.source_end == (name, output) and _is_setpoint(channel.target_end, kinds)
    ]
    if setpoints:
        return tuple(OutputWire(key=key, seal=site.seal(key)) for key in setpoints)
    own = keys.port(robot, name, output)
    return (OutputWire(key=own, seal="" if kinds[name].family == "program" else site.seal(own)),)


def _requests(
    name: str, kinds: Mapping[str, Kind], channels: list[ChannelRow], robot: str
) -> dict[str, dict[str, str]]:
    asked: dict[str, dict[str, str]] = {}
    for channel in channels:
        (source, request), (target, command) = channel.source_end, channel.target_end
        if source == name and request in kinds[source].requests:
            own = _of_executive(robot) if target == EXECUTIVE else {}
            asked.setdefault(request, {})[target] = own.get(command, keys.port(robot, target, command))
    return asked | ({"pair": {EXECUTIVE: keys.pair(robot)}} if kinds[name].rights.pairs else {})


def _of_executive(robot: str) -> dict[str, str]:
    """Return the keys of the executive's commands for capabilities, and of lines with the role `operate`."""
    return {"edit": keys.edit(robot), "estop_reset": keys.estop_reset(robot), "line": keys.console(robot)}
