"""From rows to what should run: pure, all problems at once, and the difference between two plans."""

from collections.abc import Iterable, Mapping
from hashlib import blake2b
from pathlib import Path
from typing import Any

import msgspec
from msgspec import Struct
from msgspec.structs import replace

from lbr.bus import keys
from lbr.bus.access import Credentials
from lbr.capability import registry
from lbr.capability.config import DeviceConfig, InputWire, LanConfig, LanUser, OutputWire, ProcessConfig
from lbr.capability.kind import Kind
from lbr.capability.program import ProgramSettings
from lbr.capability.registry import KindError
from lbr.database.rows import CapabilityRow, ChannelRow, Problem, RobotRows
from lbr.executive.credentials import token_secret
from lbr.executive.profile import Profile
from lbr.executive.wiring import check_channels, check_verbs

EXECUTIVE = "executive"
LAN = "lan"


class Unit(Struct, frozen=True, kw_only=True):
    """One process of the plan; two equal units need no restart."""

    name: str
    kind: str
    family: str
    moves: bool
    restart: str
    needs: tuple[str, ...]
    config: ProcessConfig
    fingerprint: str = ""
    program: ProgramSettings | None = None


class Plan(Struct, frozen=True, kw_only=True):
    """What should run, in start order, and the rows it came from."""

    robot: str
    units: dict[str, Unit]
    kinds: dict[str, Kind]
    rows: RobotRows

    def commands(self, name: str) -> tuple[str, ...]:
        """Return what a unit can be asked for."""
        return _commands(self.units[name], self.kinds[name])

    def streams(self) -> tuple[str, ...]:
        """Return the keys of all streams that units publish under their own names."""
        return _streams(self.robot, self.units.values())


class Change(Struct, frozen=True, kw_only=True):
    """What an edit of the rows does to the processes."""

    start: tuple[str, ...] = ()
    stop: tuple[str, ...] = ()
    restart: tuple[str, ...] = ()


class Site(Struct, frozen=True, kw_only=True):
    """What a plan needs to know of this run: where things are, and the secret its seals and passwords come from.

    `listen` are endpoints for other machines that were asked for at the command line.
    """

    home: str
    endpoints: tuple[str, ...]
    secret: bytes
    listen: tuple[str, ...] = ()
    token_key: bytes = b""

    def seal(self, key: str) -> str:
        """Return the key that seals a setpoint, the same for every plan of this run."""
        return blake2b(key.encode(), key=self.secret, digest_size=32).hexdigest()

    def router_id(self, name: str) -> str:
        """Return the session id of one of this run's routers, by which the others know it."""
        return f"1{self.seal(f'router {name}')[:15]}"  # one that begins with 0 is no id

    def credentials(self, user: str) -> Credentials:
        """Return how a process proves itself on the bus, the same for every plan of this run."""
        return Credentials(user=user, password=self.seal(f"password of {user}"))


def make(rows: RobotRows, profile: Profile, site: Site) -> tuple[Plan | None, tuple[Problem, ...]]:
    """Return the plan, or None and everything that is wrong with the rows."""
    rows = _listening(rows, (*rows.robot.listen, *profile.listen, *site.listen))
    problems = list(rows.problems)
    kinds: dict[str, Kind] = {}
    settings: dict[str, Any] = {}
    for row in rows.capabilities:
        kind, parsed, found = _understand(row, f"{rows.robot.name}/{row.name}", Path(site.home))
        problems += found
        if kind is not None:
            kinds[row.name] = kind
        if parsed is not None:
            settings[row.name] = parsed
    problems += check_channels(rows, kinds, settings)
    problems += check_verbs(rows, kinds, settings)
    chosen = [row for row in rows.capabilities if row.name in kinds and _runs(row, kinds[row.name], profile)]
    problems += _check_devices(rows, chosen, kinds, settings)
    problems += _check_device_settings(rows, kinds)
    problems += _check_profile(rows, profile)
    chosen = _after_the_world(chosen, kinds)
    if problems:
        return None, tuple(problems)
    order = _order(chosen)
    channels = [c for c in rows.channels if c.enabled and {c.source_end[0], c.target_end[0]} <= set(order)]
    by_name = {row.name: row for row in chosen}
    units = {
        name: _unit(by_name[name], kinds, settings[name], rows, channels, profile, site, set(order)) for name in order
    }
    units = {name: _with_lan(unit, units, kinds, rows, site) for name, unit in units.items()}
    return Plan(robot=rows.robot.name, units=units, kinds=kinds, rows=rows), ()


def _listening(rows: RobotRows, listen: tuple[str, ...]) -> RobotRows:
    """Return the rows with a door to other machines that listens as this run was told to."""
    if not listen:
        return rows
    settings = msgspec.json.encode({"listen": listen}).decode()
    door = CapabilityRow(name=LAN, kind=LAN, settings=settings)
    others = tuple(row for row in rows.capabilities if row.name != LAN)
    return replace(rows, capabilities=(*others, door))


def difference(old: Plan, new: Plan) -> Change:
    """Return what has to start, stop and restart to get from one plan to another, and nothing else."""
    return Change(
        start=tuple(name for name in new.units if name not in old.units),
        stop=tuple(name for name in old.units if name not in new.units),
        restart=tuple(name for name, unit in new.units.items() if name in old.units and unit != old.units[name]),
    )


def _understand(row: CapabilityRow, label: str, home: Path) -> tuple[Kind | None, Any, list[Problem]]:
    if row.name == EXECUTIVE:
        return (
            None,
            None,
            [Problem("capability", label, "name", "'executive' is the runtime itself; choose another")],
        )
    try:
        kind = registry.find(row.kind, home)
    except (KindError, OSError) as err:
        return None, None, [Problem("capability", label, "kind", str(err))]
    try:
        return kind, kind.parse(row.settings), []
    except Exception as err:  # noqa: BLE001 - a kind of somebody's own may check its settings in any way
        return kind, None, [Problem("capability", label, "settings", f"{err} (kind '{row.kind}')")]


def _runs(row: CapabilityRow, kind: Kind, profile: Profile) -> bool:
    if kind.family == "simulation" and not profile.simulate:
        return False
    wanted = profile.only is None or row.name in profile.only
    return row.enabled and wanted and row.name not in profile.without


def _check_profile(rows: RobotRows, profile: Profile) -> list[Problem]:
    names, devices = {row.name for row in rows.capabilities}, {row.name for row in rows.devices}
    bad_names = sorted({*(profile.only or ()), *profile.without} - names - {p.row for p in rows.problems})
    bad_devices = sorted(set(profile.devices) - devices)
    return [
        *(Problem("profile", profile.robot, "only/without", f"there is no capability '{name}'") for name in bad_names),
        *(Problem("profile", profile.robot, "devices", f"there is no device row '{name}'") for name in bad_devices),
    ]


def _check_device_settings(rows: RobotRows, kinds: Mapping[str, Kind]) -> list[Problem]:
    problems = []
    for device in rows.devices:
        for kind in kinds.values():
            try:
                msgspec.convert(device.settings, kind.device_settings.get(device.type, dict[str, Any]))
            except msgspec.ValidationError as err:
                text = f"{err} (for kind '{kind.name}')"
                problems.append(Problem("device", f"{rows.robot.name}/{device.name}", "settings", text))
    return problems


def _check_devices(
    rows: RobotRows, chosen: list[CapabilityRow], kinds: Mapping[str, Kind], settings: Mapping[str, Any]
) -> list[Problem]:
    problems = []
    devices = {device.name: device for device in rows.devices}
    owners: dict[str, str] = {}
    for row in chosen:
        wanted = kinds[row.name].device
        if not wanted or row.name not in settings:
            continue
        name = str(getattr(settings[row.name], "device", ""))
        device = devices.get(name)
        if device is None:
            continue
        if device.type != wanted:
            text = f"device '{name}' is of type '{device.type}', and this kind drives '{wanted}'"
        elif name in owners:
            text = f"device '{name}' already belongs to '{owners[name]}'; one capability owns a device"
        else:
            owners[name] = row.name
            continue
        problems.append(Problem("capability", f"{rows.robot.name}/{row.name}", "settings", f"device: {text}"))
    return problems


def _after_the_world(chosen: list[CapabilityRow], kinds: Mapping[str, Kind]) -> list[CapabilityRow]:
    """Let every driver need the simulation that emulates its device, where there is one."""
    worlds = tuple(row.name for row in chosen if kinds[row.name].family == "simulation")
    return [replace(row, needs=(*row.needs, *worlds)) if kinds[row.name].device else row for row in chosen]


def _order(chosen: Iterable[CapabilityRow]) -> list[str]:
    """Return the names so that everything comes after what it needs; the database refuses needs in a ring."""
    order: list[str] = []
    waiting = {row.name: row for row in chosen}
    while waiting:
        free = [name for name, row in waiting.items() if not (set(row.needs) & set(waiting))] or list(waiting)
        order += free
        for name in free:
            del waiting[name]
    return order


def _unit(
    row: CapabilityRow,
    kinds: Mapping[str, Kind],
    settings: Any,
    rows: RobotRows,
    channels: list[ChannelRow],
    profile: Profile,
    site: Site,
    running: set[str],
) -> Unit:
    kind = kinds[row.name]
    robot = rows.robot.name
    devices = tuple(
        DeviceConfig(
            name=d.name,
            type=d.type,
            address=device_address(d.name, d.address, profile, site, robot),
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
        endpoints=site.endpoints,
        credentials=site.credentials(row.name),
        home=site.home,
        device=device,
        devices=devices,
        wiring=_wiring(row.name, kinds, channels, site, robot),
        outputs={name: _outputs(row.name, name, kinds, channels, site, robot) for name in ports.outputs},
        requests=_requests(row.name, kinds, channels, robot),
        calibration={c.name: c.value for c in rows.calibrations if device and c.device == device},
        release_key=site.seal(keys.estop_release(robot, row.name)),
    )
    return Unit(
        name=row.name,
        kind=row.kind,
        family=kind.family,
        moves=kind.moves,
        restart=row.restart,
        needs=tuple(need for need in row.needs if need in running),
        config=config,
        fingerprint=registry.fingerprint(row.kind, Path(site.home)),
        program=settings if isinstance(settings, ProgramSettings) else None,
    )


def _with_lan(unit: Unit, units: Mapping[str, Unit], kinds: Mapping[str, Kind], rows: RobotRows, site: Site) -> Unit:
    if unit.kind != LAN:
        return unit
    robot = rows.robot.name
    others = [other for other in units.values() if other.name != unit.name]
    commands = {
        keys.port(robot, other.name, command): kinds[other.name].role(command)
        for other in others
        for command in _commands(other, kinds[other.name])
    }
    folder = Path(site.home) / "credentials"
    config = LanConfig(
        listen=tuple(kinds[unit.name].parse(bytes(unit.config.settings)).listen),
        link=site.credentials(f"@{unit.name}"),
        users=tuple(
            LanUser(name=t.name, role=t.role, hash=t.hash, secret=token_secret(site.token_key, t.name, t.created_at))
            for t in rows.tokens
        ),
        streams=_streams(robot, others),
        stops=tuple(key for key, role in commands.items() if role == "view"),
        commands={key: role for key, role in commands.items() if role != "view"},
        private_key=str(folder / "bus.key"),
        certificate=str(folder / "bus.crt"),
    )
    return replace(unit, config=replace(unit.config, lan=config))


def _commands(unit: Unit, kind: Kind) -> tuple[str, ...]:
    return tuple(unit.program.commands if unit.program is not None else kind.commands)


def _streams(robot: str, units: Iterable[Unit]) -> tuple[str, ...]:
    keyed = ((unit, wire.key) for unit in units for wires in unit.config.outputs.values() for wire in wires)
    return tuple(sorted({key for unit, key in keyed if key.startswith(f"{robot}/{unit.name}/")}))


def _compact(settings: str) -> msgspec.Raw:
    """Return the settings without white space: the document is one line, and spaces restart nothing."""
    return msgspec.Raw(msgspec.json.encode(msgspec.json.decode(settings)))


def device_address(name: str, address: str, profile: Profile, site: Site, robot: str) -> str:
    """Return where a device is in this run: its emulated twin's place, the profile's word, or the row's."""
    if profile.simulate:
        return str(Path(site.home) / "run" / f"{robot}-devices" / name)
    return profile.devices.get(name, address)


def _is_setpoint(target: tuple[str, str], kinds: Mapping[str, Kind]) -> bool:
    return target[1] in kinds[target[0]].setpoints


def _wiring(
    name: str, kinds: Mapping[str, Kind], channels: list[ChannelRow], site: Site, robot: str
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
    name: str, output: str, kinds: Mapping[str, Kind], channels: list[ChannelRow], site: Site, robot: str
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
            asked.setdefault(request, {})[target] = keys.port(robot, target, command)
    return asked
