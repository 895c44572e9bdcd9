"""Detects the content of a file: a motion, or data of a robot's former program."""

from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import NamedTuple

from lbr import plugins
from lbr.apps.motions.commands import motion_files
from lbr.apps.motions.commands.motion_files import MotionFile
from lbr.database import foreign_tables, given_files, identity
from lbr.database.columns import json_strictly
from lbr.errors import InputError
from lbr.robot import registry
from lbr.robot.motion_file import MakersMotion
from lbr.robot.old_data import ForeignTables, OldData, Source

LARGEST_BYTES = 16 << 20
"""The largest file: a hundred times the data of any of these programs."""
OWN = "motion"
"""The format of `lbr motion export`."""


class Given(NamedTuple):
    """A file and its content: motions, or a former program's data; neither for an unknown format (`why`)."""

    path: Path
    format: str
    motions: MakersMotion | MotionFile | None = None
    data: OldData | None = None
    why: str = ""


def formats() -> dict[str, str]:
    """Return the names of all formats, with their descriptions."""
    makers = {suffix.removeprefix("."): f"motions {one.summary}" for suffix, one in registry.motion_formats().items()}
    old = {name: one.summary for name, one in registry.old_formats().items()}
    return {OWN: "a motion that 'lbr motion export' wrote", **dict(sorted({**makers, **old}.items()))}


def understood(path: Path, wanted: str | None = None) -> Given:
    """Read a file; raise InputError for a fault in a known or the wanted format."""
    content = given_files.read(path, LARGEST_BYTES)
    makers, old_formats = registry.motion_formats(), registry.old_formats()
    if wanted is not None and wanted not in formats():
        raise InputError(f"there is no format '{wanted}': {', '.join(formats())}", "unknown_name")
    try:
        if f".{wanted}" in makers or (wanted is None and path.suffix.lower() in makers):
            suffix = f".{wanted}" if wanted is not None else path.suffix.lower()
            return Given(path, suffix.removeprefix("."), motion_files.read(content, suffix))
        if why := identity.own(path, content):
            return Given(path, "", why=why)
        source = _source(path, content)
        if wanted == OWN or (isinstance(source.json, dict) and source.json.get("format") == "lbr-motion"):
            return Given(path, OWN, motion_files.read(content))
        for name in [wanted] if wanted is not None else old_formats:
            read: Callable[[Source], OldData | None] = plugins.load(old_formats[name].read)
            if (data := read(source)) is not None:
                return Given(path, name, data=data)
        why = _unknown(source, wanted)
    except InputError as err:
        raise InputError(f"{path}: {err}") from err
    if wanted is not None:
        raise InputError(f"{path}: {why}")
    return Given(path, "", why=why)


def _unknown(source: Source, wanted: str | None) -> str:
    if wanted is not None:
        return f"it is not of the format {wanted} ({formats()[wanted]})"
    if (tables := source.tables()) is not None:
        names = ", ".join(sorted(tables)[:6]) or "none"
        return f"it is a database of a program that is not known here; its tables are {names}"
    if not source.content:
        return "it is empty"
    return f"it is of no format that is known: {', '.join(formats())}"


def _source(path: Path, content: bytes) -> Source:
    text = None if content.startswith(identity.MAGIC) else given_files.decoded(content)
    document = _json(text)

    @cache
    def tables() -> ForeignTables | None:
        if content.startswith(identity.MAGIC):
            return foreign_tables.of_database(content)
        if text is not None and document is None and "CREATE TABLE" in text.upper():
            return foreign_tables.of_sql(text)
        return None

    return Source(
        name=path.name.lower(),
        folder=str(path.absolute().parent),
        content=content,
        text=text,
        json=document,
        tables=tables,
    )


def _json(text: str | None) -> object:
    if text is None or text.lstrip()[:1] not in {"{", "["}:
        return None
    try:
        return json_strictly(text)
    except (ValueError, RecursionError):
        return None
