"""From rows to a plan of the processes. Pure; reports all problems at once."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from collections.abc import Set as AbstractSet
from functools import cache, partial
from pathlib import Path

import msgspec
from msgspec import Struct
from msgspec.structs import replace

from lbr.bus.door import LanUser, TokenRight
from lbr.capability import registry
from lbr.capability.kind import Kind, KindError, LackingError
from lbr.capability.program import ProgramSettings
from lbr.capability.settings import faults
from lbr.database.columns import json_strictly
from lbr.database.reading import Problem
from lbr.database.rows import CapabilityRow, DeviceRow, RobotRows, TokenRow
from lbr.executive.planning import console_lines, machine, placement, rights, sharing, words
from lbr.executive.planning.devices import check_device_settings, check_devices
from lbr.executive.planning.draft import Draft
from lbr.executive.planning.machine import Machine
from lbr.executive.planning.plan import Plan
from lbr.executive.planning.process_specs import ProcessSpec, Specs
from lbr.executive.planning.profile import Profile
from lbr.executive.planning.run_identity import RunIdentity
from lbr.executive.planning.sharing import LAN
from lbr.executive.planning.wiring import EXECUTIVE, by_themselves, check_channels, check_verbs
from lbr.messages.unreadable import UNREADABLE

Find = Callable[[str, Path], Kind]
"""Returns the kind of a name in a home, or raises KindError."""


def make(
    rows: RobotRows,
    profile: Profile,
    site: RunIdentity,
    on: Machine = machine.ANY,
    *,
    find: Find = registry.find,
    before: RobotRows | None = None,
) -> tuple[Plan | None, tuple[Problem, ...]]:
    """Return the plan, or None and all problems of the rows and of this machine.

    At a start, a capability is left out if its kind may belong to a broken component. Once rows `before` have run, only
    a capability in them may be left out: the kind of a new one must load.
    """
    known = cache(partial(_find, find, Path(site.home)))
    rows = _listening(rows, (*profile.listen, *site.listen))
    problems = list(rows.problems)
    kinds: dict[str, Kind] = {}
    settings: dict[str, Struct] = {}
    there = {(row.name, row.kind) for row in before.capabilities} if before is not None else set()
    for row, label, bad in rows.every(CapabilityRow):
        may_lack = before is None or (row.name, row.kind) in there
        kind, parsed, found = _understand(row, label, known, bad, may_lack=may_lack)
        problems += found
        if kind is not None and "name" not in bad and (parsed is not None or kind.settings is not ProgramSettings):
            kinds[row.name] = kind
        if parsed is not None and "name" not in bad:
            settings[row.name] = parsed
    chosen = [row for row in rows.capabilities if row.name in kinds and _runs(row, kinds[row.name], profile)]
    draft = Draft(rows=rows, profile=profile, kinds=kinds, settings=settings, chosen=_placed(chosen, kinds, profile))
    problems += [problem for check in CHECKS for problem in check(draft)]
    problems += machine.problems(draft, on)
    if problems:
        return None, tuple(problems)
    rows = replace(rows, verbs=words.words(rows, kinds))
    draft = replace(draft, rows=rows)
    whole = all(row.name in kinds for row in rows.capabilities)  # else a word's kind may be left out
    if whole and (wrong := tuple(console_lines.problems(draft))):
        return None, wrong
    order = _order(draft.chosen)
    channels = [c for c in rows.channels if c.enabled and {c.source_end[0], c.target_end[0]} <= {EXECUTIVE, *order}]
    channels += by_themselves(order, rows, kinds)
    specs = Specs(draft, channels, site)
    units = {name: specs.unit(name) for name in order}
    plan = Plan(robot=draft.robot, units=units, kinds=kinds, rows=rows)
    guests = {name: rights.of_process(plan, one) for name, one in units.items() if one.config.host}
    return replace(plan, units=specs.with_lan(units, guests)), ()


def with_tokens(
    plan: Plan, tokens: tuple[TokenRow, ...], profile: Profile, site: RunIdentity, on: Machine
) -> Plan | None:
    """Return the plan with new tokens and nothing else, even if the files of its kinds have changed."""
    kinds = {kind.name: kind for kind in plan.kinds.values()}

    def find(name: str, _home: Path) -> Kind:
        if name not in kinds:
            raise LackingError(f"there is no kind '{name}'")
        return kinds[name]

    made, _ = make(replace(plan.rows, tokens=tokens), profile, site, on, find=find)
    if made is None:
        return None
    units = {name: _of_the_same_file(one, plan.units[name]) for name, one in made.units.items()}
    return replace(made, units=units)


def _of_the_same_file(unit: ProcessSpec, before: ProcessSpec) -> ProcessSpec:
    config = replace(unit.config, source=before.config.source)
    return replace(unit, fingerprint=before.fingerprint, config=config)


def _listening(rows: RobotRows, listen: tuple[str, ...]) -> RobotRows:
    """Return the rows with a door to other machines that listens at the endpoints of this run."""
    if not listen:
        return rows
    settings = msgspec.json.encode({"listen": listen}).decode()
    door = CapabilityRow(name=LAN, kind=LAN, settings=settings)
    others = tuple(row for row in rows.capabilities if row.name != LAN)
    return replace(rows, capabilities=(*others, door))


def _find(find: Find, home: Path, kind: str) -> Kind | Exception:
    """Return a kind, or why it is unusable; the result is cached, as several rows may have one kind."""
    try:
        return find(kind, home)
    except (KindError, OSError) as err:
        return err


def _understand(
    row: CapabilityRow, label: str, known: Callable[[str], Kind | Exception], bad: AbstractSet[str], *, may_lack: bool
) -> tuple[Kind | None, Struct | None, list[Problem]]:
    """Return a capability's kind and settings, as far as its columns are valid, and the faults in them."""
    if row.name == EXECUTIVE and "name" not in bad:
        text = "'executive' is the runtime itself; choose another"
        return None, None, [Problem("capability", label, "name", text)]
    if "kind" in bad:
        return None, None, []
    kind = known(row.kind)
    if isinstance(kind, Exception):
        without = may_lack and isinstance(kind, LackingError)  # the robot runs without this capability
        return None, None, [] if without else [Problem("capability", label, "kind", str(kind))]
    if "settings" in bad:  # a device may be missing; report the other faults, too
        return kind, None, _more(row, kind, label)
    try:
        return kind, kind.parse(row.settings), []
    except UNREADABLE as err:
        told = _more(row, kind, label)
        return kind, None, told or [Problem("capability", label, "settings", f"{err} (kind '{row.kind}')")]


def _more(row: CapabilityRow, kind: Kind, label: str) -> list[Problem]:
    """Return all faults in the fields of settings, as long as these are JSON."""
    try:
        found = faults(kind.settings, json_strictly(row.settings))
    except (ValueError, *UNREADABLE):
        return []
    return [Problem("capability", label, "settings", f"{fault} (kind '{row.kind}')") for fault in found]


def _runs(row: CapabilityRow, kind: Kind, profile: Profile) -> bool:
    if kind.family == "simulation" and not profile.simulate:
        return False
    wanted = profile.only is None or row.name in profile.only
    return row.enabled and wanted and row.name not in profile.without


def _check_tables(draft: Draft) -> Iterator[Problem]:
    """Yield the faults in the rows that kinds read, each once."""
    rows, kinds = draft.rows, draft.kinds
    readers = {read.row: name for name, kind in kinds.items() for read in kind.reads}
    for row in sorted((registry.tables() | readers.keys()) - {LanUser, TokenRight}, key=lambda row: row.TABLE):
        if row.TABLE in rows.tables:
            yield from rows.tables.problems(row)
        elif name := readers.get(row, ""):
            text = (
                f"'{kinds[name].name}' reads the table '{row.TABLE}', which is not there, or has not the triggers that "
                f"keep its changes: `lbr db table {kinds[name].name}` prints the SQL that makes both"
            )
            yield draft.problem(name, "kind", text)


def _check_profile(draft: Draft) -> Iterator[Problem]:
    """Yield the names in the profile that no row has."""
    profile, devices = draft.profile, draft.rows.names(DeviceRow)
    for name in sorted({*(profile.only or ()), *profile.without, *profile.processes} - draft.rows.names(CapabilityRow)):
        yield Problem("profile", profile.robot, "only/without/processes", f"there is no capability '{name}'")
    there_are = f"(there is: {', '.join(sorted(devices))})"
    for field in ("devices", "calibration"):
        for name in sorted({*getattr(profile, field)} - devices):
            yield Problem("profile", profile.robot, field, f"there is no device row '{name}' {there_are}")


CHECKS = (
    check_channels,
    check_verbs,
    words.problems,
    _check_tables,
    check_devices,
    check_device_settings,
    _check_profile,
    placement.problems,
    sharing.problems,
)
"""The conditions for a plan on any machine."""


def _placed(chosen: list[CapabilityRow], kinds: Mapping[str, Kind], profile: Profile) -> tuple[CapabilityRow, ...]:
    """Return rows with their process by the profile; every driver needs the simulation that emulates its device."""
    worlds = tuple(row.name for row in chosen if kinds[row.name].family == "simulation")
    return tuple(
        replace(
            row,
            process=profile.processes.get(row.name, row.process),
            needs=(*row.needs, *worlds) if kinds[row.name].device else row.needs,
        )
        for row in chosen
    )


def _order(chosen: Iterable[CapabilityRow]) -> list[str]:
    """Return the names so that each follows its dependencies; the database refuses circular ones."""
    order: list[str] = []
    waiting = {row.name: row for row in chosen}
    while waiting:
        free = [name for name, row in waiting.items() if not (set(row.needs) & set(waiting))] or list(waiting)
        order += free
        for name in free:
            del waiting[name]
    return order
