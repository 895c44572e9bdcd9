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
from lbr.database.rows import ChannelRow
from lbr.executive.planning import sharing
from lbr.executive.planning.credentials import token_secret
from lbr.executive.planning.devices import device_address
from lbr.executive.planning.draft import Draft
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


class Specs:
    """Makes the specs of the processes of a draft, which `channels` wire to one another."""

    def __init__(self, draft: Draft, channels: Iterable[ChannelRow], site: RunIdentity) -> None:
        self._draft = draft
        self._channels = tuple(channels)
        self._site = site
        self._rows = {row.name: row for row in draft.chosen}

    def unit(self, name: str) -> ProcessSpec:
        """Return the process of a chosen capability."""
        row, kind, settings = self._rows[name], self._draft.kinds[name], self._draft.settings[name]
        robot, profile, site = self._draft.robot, self._draft.profile, self._site
        host = profile.host_of(name)
        process = "" if host else row.process
        device = getattr(settings, "device", "") if kind.device else ""
        program = settings if isinstance(settings, ProgramSettings) else None
        config = ProcessConfig(
            robot=robot,
            name=name,
            kind=row.kind,
            settings=_compact(row.settings),
            simulated=profile.simulate,
            endpoints=() if host else site.endpoints,
            credentials=self._guest(host, name) if host else site.credentials(sharing.user(name, process)),
            home="" if host else site.home,
            host=host,
            source="" if host else registry.source(row.kind),
            process=process,
            device=device,
            devices=self._devices(None if kind.family == "simulation" else device),
            wiring=self._wiring(name),
            outputs={output: self._outputs(name, output) for output in (program or kind).outputs},
            requests=self._requests(name),
            rows={read.row.TABLE: self._read(read, settings) for read in kind.reads},
            release_key=site.seal(keys.estop_release(robot, name)),
        )
        return ProcessSpec(
            name=name,
            kind=row.kind,
            family=kind.family,
            moves=kind.moves,
            serves=kind.rights.serves,
            serves_people=kind.rights.people and not host,
            records=kind.rights.records and not host,
            restart=row.restart,
            needs=tuple(need for need in row.needs if need in self._rows),
            config=config,
            fingerprint=registry.fingerprint(row.kind, Path(site.home)),
            program=program,
        )

    def with_lan(self, units: Mapping[str, ProcessSpec], rights: Mapping[str, Rights]) -> dict[str, ProcessSpec]:
        """Return the units; the door to other machines receives its users and their rights.

        `rights` are those of the processes on other machines.
        """
        return {
            name: replace(unit, lan=self._lan(unit, units, rights)) if unit.kind == LAN else unit
            for name, unit in units.items()
        }

    def _lan(self, unit: ProcessSpec, units: Mapping[str, ProcessSpec], rights: Mapping[str, Rights]) -> LanConfig:
        draft, site = self._draft, self._site
        peers = [peer for peer in units.values() if peer.name != unit.name]
        local_commands, remote_commands = (
            {
                keys.port(draft.robot, peer.name, command): draft.kinds[peer.name].role(command)
                for peer in peers
                if bool(peer.config.host) is elsewhere
                for command in commands_of(peer, draft.kinds[peer.name])
            }
            for elsewhere in (False, True)
        )
        folder = Path(site.home) / "credentials"
        return LanConfig(
            listen=tuple(asdict(draft.settings[unit.name])["listen"]),
            link=site.credentials(f"@{unit.name}"),
            users=self._users("bus"),
            streams=streams_of(draft.robot, peers),
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

    def _devices(self, name: str | None) -> tuple[DeviceConfig, ...]:
        """Return the device of this name with its address in this run; all for None, as for a simulated world."""
        draft = self._draft
        return tuple(
            DeviceConfig(
                name=row.name,
                type=row.type,
                address=device_address(row, draft.kinds.values(), draft.profile, self._site, draft.robot),
                settings=row.settings,
            )
            for row in draft.rows.devices
            if name is None or row.name == name
        )

    def _wiring(self, name: str) -> dict[str, tuple[InputWire, ...]]:
        wires: dict[str, tuple[InputWire, ...]] = {}
        for channel in self._channels:
            (source, output), (target, port) = channel.source_end, channel.target_end
            kind = self._draft.kinds[source]
            if target != name or output in kind.requests:
                continue
            key = keys.port(self._draft.robot, *(channel.target_end if self._drives(channel) else channel.source_end))
            wire = InputWire(
                key=key,
                source=source,
                rate_hz=channel.rate_hz,
                history=channel.history,
                seal=self._site.seal(key) if kind.family != "program" else "",
            )
            wires[port] = (*wires.get(port, ()), wire)
        return wires

    def _outputs(self, name: str, output: str) -> tuple[OutputWire, ...]:
        setpoints = [
            keys.port(self._draft.robot, *channel.target_end)
            for channel in self._channels
            if channel.source_end == (name, output) and self._drives(channel)
        ]
        if setpoints:
            return tuple(OutputWire(key=key, seal=self._site.seal(key)) for key in setpoints)
        own = keys.port(self._draft.robot, name, output)
        return (OutputWire(key=own, seal="" if self._draft.kinds[name].family == "program" else self._site.seal(own)),)

    def _requests(self, name: str) -> dict[str, dict[str, str]]:
        robot, kind = self._draft.robot, self._draft.kinds[name]
        asked: dict[str, dict[str, str]] = {}
        for channel in self._channels:
            (source, request), (target, command) = channel.source_end, channel.target_end
            if source == name and request in kind.requests:
                own = _of_executive(robot) if target == EXECUTIVE else {}
                asked.setdefault(request, {})[target] = own.get(command, keys.port(robot, target, command))
        return asked | ({"pair": {EXECUTIVE: keys.pair(robot)}} if kind.rights.pairs else {})

    def _drives(self, channel: ChannelRow) -> bool:
        """Return whether a channel feeds a setpoint, which has the key of its driver."""
        target, port = channel.target_end
        return port in self._draft.kinds[target].setpoints

    def _read(self, read: Read, settings: Struct) -> RowSet:
        """Return the rows of a table that a kind reads: users with the secrets of their tokens, rights without."""
        rows = self._draft.rows
        if read.row is LanUser:
            return row_set(read.row, self._users("web"))
        if read.row is TokenRight:
            return row_set(
                read.row, read_by(read, settings, (TokenRight(name=t.name, role=t.role) for t in rows.tokens))
            )
        if read.row is CalibrationValue:
            return row_set(read.row, read_by(read, settings, self._calibration()))
        return row_set(read.row, read_by(read, settings, rows.of(read.row)))

    def _calibration(self) -> tuple[CalibrationValue, ...]:
        """Return the calibration in the rows, and the profile's for devices without such rows."""
        known = self._draft.rows.of(CalibrationValue)
        measured = {row.device for row in known}
        return known + tuple(
            CalibrationValue(device=device, name=name, value=value, measured_at="")
            for device, found in self._draft.profile.calibration.items()
            if device not in measured
            for name, value in found.items()
        )

    def _users(self, door: Literal["bus", "web"]) -> tuple[LanUser, ...]:
        """Return the tokens that are valid for a door; it does not even learn about those for the other door."""
        key = self._site.token_key
        return tuple(
            LanUser(name=t.name, role=t.role, hash=t.hash, secret=token_secret(key, t.name, t.created_at))
            for t in self._draft.rows.tokens
            if t.lets_in(door)
        )

    def _guest(self, host: str, name: str) -> Credentials | None:
        """Return the credentials of a process on another machine, which become invalid with its host's token."""
        valid = (one for one in self._draft.rows.tokens if one.role == "host" and one.lets_in("bus"))
        token = next((one for one in valid if one.name == host), None)
        if token is None:
            return None
        password = self._site.seal(f"password of {name} on {host} since {token.created_at}")
        return Credentials(user=f"{host}.{name}", password=password)  # no token's name has a dot


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


def _compact(settings: str) -> msgspec.Raw:
    """Return the settings without white space: the document is one line, and white space restarts nothing."""
    return msgspec.Raw(msgspec.json.encode(msgspec.json.decode(settings)))


def _of_executive(robot: str) -> dict[str, str]:
    """Return the keys of the executive's commands for capabilities, and of lines with the role `operate`."""
    return {"edit": keys.edit(robot), "estop_reset": keys.estop_reset(robot), "line": keys.console(robot)}
