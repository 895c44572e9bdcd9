"""A home for the rerun of a recorded robot: its rows then, without the parts for people or other machines."""

import shutil
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

import msgspec
from msgspec import Struct

from lbr import home
from lbr.apps.recorder.recording.recorded import RecordedRows
from lbr.capability import registry
from lbr.capability.kind import Emulation, Kind, KindError
from lbr.database import changes, proposals, store
from lbr.database.changes import Change
from lbr.database.reading import ROBOT, RawTables
from lbr.database.tables import Schema
from lbr.errors import InputError

OUTSIDE = frozenset({"call", "mqtt", "power", "registrar"})
"""Kinds that reach beyond the robot, to other machines or to this machine's switch."""


class Rerun(Struct, frozen=True, kw_only=True):
    """The place of the rerun: its home and launch profile, the capabilities that run, and why others do not."""

    home: Path
    profile: Path
    runs: Mapping[str, Kind]
    left_out: Mapping[str, str]
    devices: Mapping[str, str]
    """The address of each emulated device."""


def prepare(place: Path, robot: str, rows: RecordedRows, lines: Collection[str]) -> Rerun:
    """Make the home; raise InputError if these rows cannot run here."""
    database = place / "robot.db"
    own = home.home() / "capabilities"
    if own.is_dir():
        shutil.copytree(own, place / "capabilities")
    kinds, left_out = _running(rows, lines, place)
    store.create(database)
    with store.Database.open(database) as opened:
        proposals.command(
            opened, lambda tables, schema: _changes(tables, schema, robot, rows), lambda _rows: (), text="recorded"
        )
    devices = {}
    for row in rows.tables.get("device", []):
        if row["name"] in lines:
            kind = next((one for one in kinds.values() if one.device_type == row["type"]), None)
            emulated: Emulation = kind.device.emulated if kind is not None and kind.device is not None else "tty"
            path = str(place / "run" / f"{robot}-devices" / str(row["name"]))
            devices[str(row["name"])] = f"unix:{path}" if emulated == "socket" else path
    profile = place / "recorded.toml"
    profile.write_text(_profile(robot, left_out, devices))
    return Rerun(home=place, profile=profile, runs=kinds, left_out=left_out, devices=devices)


def _profile(robot: str, without: Collection[str], devices: Mapping[str, str]) -> str:
    """Return a launch profile without real devices; TOML writes lists and texts as JSON does."""
    document = {
        "robot": robot,
        "description": "a recorded robot, on emulated devices that say what was recorded",
        "simulate": True,
        "without": sorted(without),
    }
    lines = [f"{name} = {msgspec.json.encode(value).decode()}" for name, value in document.items()]
    lines += ["", "[devices]", *(f"{name} = {msgspec.json.encode(path).decode()}" for name, path in devices.items())]
    return "\n".join(lines) + "\n"


def _running(rows: RecordedRows, lines: Collection[str], place: Path) -> tuple[dict[str, Kind], dict[str, str]]:
    """Return the kinds of the capabilities that can run again, and the reasons of the others."""
    kinds: dict[str, Kind] = {}
    left_out: dict[str, str] = {}
    enabled = [row for row in rows.tables.get("capability", []) if row["enabled"]]
    for row in enabled:
        name = str(row["name"])
        try:
            kind = registry.find(str(row["kind"]), place, trial=False)
        except KindError as err:
            left_out[name] = str(err)
            continue
        if why := _why_not(kind, _decoded(row["settings"]), lines):
            left_out[name] = why
        else:
            kinds[name] = kind
    while gone := {str(row["name"]): lacks for row in enabled if (lacks := _lacks(row, kinds, left_out))}:
        for name, lacks in gone.items():
            del kinds[name]
            left_out[name] = f"it needs '{lacks}', which does not run here"
    return kinds, left_out


def _why_not(kind: Kind, settings: Mapping[str, object], lines: Collection[str]) -> str:
    if kind.family in {"simulation", "program"}:
        return "it is no part of the robot itself"
    if kind.rights.serves or kind.rights.people or kind.rights.records or kind.name in OUTSIDE:
        return "it is for people and other machines"
    if kind.device and str(settings.get("device", "")) not in lines:
        return "its device's bytes were not recorded"
    return ""


def _lacks(row: Mapping[str, object], kinds: Mapping[str, Kind], left_out: Mapping[str, str]) -> str:
    if str(row["name"]) not in kinds:
        return ""
    return next((str(one) for one in _decoded(row["needs"]) if one in left_out), "")


def _changes(tables: RawTables, schema: Schema, robot: str, rows: RecordedRows) -> tuple[Change, ...]:
    """Return the changes from the shipped rows to the recorded ones; raise InputError for rows of another version."""
    after = dict(tables)
    if not any(row["name"] == robot for row in tables[ROBOT]):
        like = tables[ROBOT][0]
        after[ROBOT] = [*tables[ROBOT], {**dict.fromkeys(like, ""), "name": robot, "estop_engaged": 0}]
    for table, recorded in rows.tables.items():
        if table not in schema:
            raise InputError(f"the recording has rows of a table '{table}', which this lbr does not have")
        known = set(after[table][0]) if after.get(table) else None
        for row in recorded:
            if known is not None and (strange := set(row) ^ known):
                names = ", ".join(sorted(strange))
                raise InputError(f"the recording's rows of '{table}' have other columns ({names}): another lbr made it")
        others = [row for row in after.get(table, []) if row.get("robot", robot) != robot]
        after[table] = [*others, *recorded]
    return changes.between(tables, after, schema)


def _decoded(text: object) -> Any:
    return msgspec.json.decode(text) if isinstance(text, str) else text
