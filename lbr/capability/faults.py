"""What is wrong with a kind as it was declared: everything at once, before anything of it is used."""

import re
from collections.abc import Collection, Iterator, Mapping
from typing import Any, get_args

import msgspec
from msgspec import Struct

from lbr.capability.kind import Command, Emulation, Family, Kind, Line, Rows, Wire
from lbr.capability.program import ProgramSettings
from lbr.capability.word import Word
from lbr.messages.rows import Row
from lbr.messages.system import Role

PORTS = ("inputs", "setpoints", "outputs", "commands", "replies", "requests")
FAMILIES = tuple(family for family in get_args(Family) if family != "program")
_NAME = re.compile(r"[a-z][a-z0-9_]{0,39}")
_ENTRY = re.compile(r"[A-Za-z_][\w.]*:[A-Za-z_]\w*")


def faults(kind: Kind) -> tuple[str, ...]:
    """Return a sentence for each thing that a kind must not say, whatever types its fields have."""
    return tuple(_found(kind))


def _found(kind: Kind) -> Iterator[str]:
    yield from _words(kind)
    yield from _entry(kind.entry)
    for group in PORTS:
        yield from _ports(group, getattr(kind, group))
    yield from _wires(kind.wires)
    yield from _optional(kind)
    yield from _choices(kind)
    yield from _settings(kind)
    yield from _pairing(kind)
    yield from _lets_in(kind)
    yield from _answers(kind)
    yield from _devices(kind)
    yield from _said(kind)


def _words(kind: Kind) -> Iterator[str]:
    for field in ("summary", "device", "extra", "package", "recognised", "says"):
        if not isinstance(getattr(kind, field), str):
            yield f"'{field}' is {_shown(getattr(kind, field))}, and must be a text"
    for field in ("moves", "serves", "serves_people", "records", "pairs", "emulates", "follows"):
        if not isinstance(getattr(kind, field), bool):
            yield f"'{field}' is {_shown(getattr(kind, field))}, and must be True or False"
    if kind.family not in FAMILIES and not _is_struct(kind.settings, ProgramSettings):
        yield f"'family' is {_shown(kind.family)}, and must be one of {', '.join(FAMILIES)}"
    if kind.emulated not in get_args(Emulation):
        yield f"'emulated' is {_shown(kind.emulated)}, and must be one of {', '.join(get_args(Emulation))}"
    if kind.line not in get_args(Line):
        yield f"'line' is {_shown(kind.line)}, and must be one of {', '.join(map(repr, get_args(Line)))}"
    yield from _rows(kind)


def _rows(kind: Kind) -> Iterator[str]:
    for field in ("rows", "learns", "edits"):
        if not isinstance(getattr(kind, field), tuple):
            yield f"'{field}' is {_shown(getattr(kind, field))}, and must be a tuple of Row classes"
            return
    for read in kind.reads:
        if fault := _no_table("rows", read.row):
            yield fault
        else:
            yield from _where(kind, read)
    for row in kind.edits:
        if fault := _no_table("edits", row):
            yield fault
    for row in kind.learns:
        if row not in [read.row for read in kind.reads]:
            yield f"'learns' names {_shown(row)}, which is not one of its rows"


def _lets_in(kind: Kind) -> Iterator[str]:
    named: Any = kind.lets_in
    if not isinstance(named, tuple):
        yield f"'lets_in' is {_shown(named)}, and must be a tuple of settings"
        return
    for name in named:
        if name != "enabled" and name not in getattr(kind.settings, "__struct_fields__", ()):
            yield f"'lets_in' names {_shown(name)}, which is neither a field of {_shown(kind.settings)} nor 'enabled'"


def _no_table(field: str, row: Any) -> str:
    """Return why what a field names is not the rows of a table, or nothing."""
    if not _is_struct(row, Row):
        return f"'{field}' names {_shown(row)}, which is not a Row: class NAME(Row, frozen=True, kw_only=True)"
    if fault := _unfit(row) or _row_fault(row):
        return f"'{field}' names {row.__name__}, which is not a table: {fault}"
    return ""


def _where(kind: Kind, read: Rows) -> Iterator[str]:
    where: Any = read.where
    if not isinstance(where, Mapping):
        yield f"'rows' looks in {read.row.__name__} by {_shown(where)}, and must by a dict of columns to settings"
        return
    for column, setting in where.items():
        if column not in read.row.__struct_fields__:
            yield f"'rows' looks for {_shown(column)} in {read.row.__name__}, which has no such column"
        if setting not in getattr(kind.settings, "__struct_fields__", ()):
            yield f"'rows' names the setting {_shown(setting)}, which is not a field of {_shown(kind.settings)}"


def _row_fault(row: type[Row]) -> str:
    """Return why a struct is not a table, or nothing."""
    if not (isinstance(row.TABLE, str) and _NAME.fullmatch(row.TABLE)):
        return f"its TABLE is {_shown(row.TABLE)}, and must be the name of one"
    key: Any = row.KEY
    if not isinstance(key, tuple) or not key or any(column not in row.__struct_fields__ for column in key):
        return f"its KEY is {_shown(row.KEY)}, and must be the columns that tell its rows apart"
    return ""


def _entry(entry: Any) -> Iterator[str]:
    if isinstance(entry, str):
        if not _ENTRY.fullmatch(entry):
            yield f"'entry' is {_shown(entry)}, and must be a class or \"module:Class\""
        return
    from lbr.capability.base import Capability  # noqa: PLC0415 - a caller with a class has imported it

    if not (isinstance(entry, type) and issubclass(entry, Capability)):
        yield f"'entry' is {_shown(entry)}, and must be a class that is a Capability, or \"module:Class\""


def _ports(group: str, ports: Any) -> Iterator[str]:
    if not isinstance(ports, Mapping):
        yield f"'{group}' is {_shown(ports)}, and must be a dict of names to message types"
        return
    for name, port in ports.items():
        message: Any = port.message if isinstance(port, Command) else port
        if not (isinstance(name, str) and _NAME.fullmatch(name)):
            yield f"'{group}' names a port {_shown(name)}: small letters, digits, underscores; at most 40"
        if not _is_struct(message, Struct):
            yield f"port {_shown(name)} must carry a msgspec Struct, not {_shown(message)}"
        elif not message.__struct_config__.frozen:
            yield f"port {_shown(name)} carries {message.__name__}, which must be frozen: class {message.__name__}(Struct, frozen=True)"
        elif fault := _unfit(message):
            yield f"port {_shown(name)} carries {message.__name__}, which is not JSON: {fault}"


def _wires(wires: Any) -> Iterator[str]:
    if not isinstance(wires, Mapping):
        yield f"'wires' is {_shown(wires)}, and must be a dict of ports to Wire"
        return
    for port, wire in wires.items():
        if not (isinstance(wire, Wire) and isinstance(wire.to, str) and isinstance(wire.history, int)):
            yield f"'wires' has {_shown(wire)} for {_shown(port)}, which is no Wire of a port's name and a number"


def _optional(kind: Kind) -> Iterator[str]:
    optional: Any = kind.optional
    if isinstance(optional, str) or not isinstance(optional, Collection):  # a text is a collection, of its letters
        yield f"'optional' is {_shown(optional)}, and must be a tuple of inputs"
        return
    for name in optional:
        if not (isinstance(name, str) and isinstance(kind.inputs, Mapping) and name in kind.inputs):
            yield f"'optional' names {_shown(name)}, which is not one of its inputs"


def _choices(kind: Kind) -> Iterator[str]:
    """Look whether what a command's fields may be is told for fields that there are, by something that can tell it."""
    for name, command in kind.commands.items() if isinstance(kind.commands, Mapping) else ():
        if not (isinstance(command, Command) and _is_struct(command.message, Struct)):
            continue
        choices: Any = command.choices
        if not isinstance(choices, Mapping):
            yield f"'choices' of {_shown(name)} is {_shown(choices)}, and must be a dict of fields to functions"
            continue
        for field, may_be in choices.items():
            if field not in command.message.__struct_fields__:
                yield f"'choices' of {_shown(name)} names {_shown(field)}, which is not a field of {command.message.__name__}"
            if not callable(may_be):
                yield f"'choices' of {_shown(name)} gives {_shown(field)} {_shown(may_be)}, and must give a function"


def _settings(kind: Kind) -> Iterator[str]:
    if not _is_struct(kind.settings, Struct):
        yield f"'settings' is {_shown(kind.settings)}, and must be a msgspec Struct"
        return
    config = kind.settings.__struct_config__
    if not (config.frozen and config.forbid_unknown_fields):
        need = "frozen=True, forbid_unknown_fields=True"
        yield f"'settings' is {kind.settings.__name__}, which must be declared with {need}"
    if fault := _unfit(kind.settings):
        yield f"'settings' is {kind.settings.__name__}, which is not JSON: {fault}"
    if kind.says and kind.says not in kind.settings.__struct_fields__:
        yield f"'says' names {_shown(kind.says)}, which is not a field of {kind.settings.__name__}"
    if kind.device and "device" not in kind.settings.__struct_fields__:
        yield f"'device' needs a field 'device' in {kind.settings.__name__}, which names the device row"


def _pairing(kind: Kind) -> Iterator[str]:
    if not kind.pairs:
        return
    if "host" not in getattr(kind.settings, "__struct_fields__", ()):
        yield "'pairs' needs a setting 'host', which the words `open` and `close` change"
    if not _has(kind.commands, "address") or not _has(kind.requests, "pair"):
        yield "'pairs' needs a command 'address', which says where it is, and a request 'pair'"


def _has(ports: object, name: str) -> bool:
    return isinstance(ports, Mapping) and name in ports


def _answers(kind: Kind) -> Iterator[str]:
    asked = {name for group in (kind.commands, kind.requests) if isinstance(group, Mapping) for name in group}
    for name in kind.replies if isinstance(kind.replies, Mapping) else ():
        if name not in asked:
            yield f"'replies' answers {_shown(name)}, which is neither of its commands nor of its requests"
    roles: Any = kind.roles
    if not isinstance(roles, Mapping):
        yield f"'roles' is {_shown(roles)}, and must be a dict of commands to roles"
        return
    for name, role in roles.items():
        if name not in asked:
            yield f"'roles' names {_shown(name)}, which is not one of its commands"
        if role not in get_args(Role):
            yield f"'roles' gives {_shown(name)} {_shown(role)}, and must give one of {', '.join(get_args(Role))}"


def _devices(kind: Kind) -> Iterator[str]:
    of_devices: Any = kind.device_settings
    if not isinstance(of_devices, Mapping):
        yield f"'device_settings' is {_shown(of_devices)}, and must be a dict of types to structs"
        return
    for name, settings in of_devices.items():
        if not _is_struct(settings, Struct):
            yield f"'device_settings' gives {_shown(name)} {_shown(settings)}, and must give a msgspec Struct"
        elif fault := _unfit(settings):
            yield f"'device_settings' gives {_shown(name)} {settings.__name__}, which is not JSON: {fault}"


def _said(kind: Kind) -> Iterator[str]:
    """Look whether the words are words; what their patterns and fields say, the plan of a robot checks."""
    words: Any = kind.words
    if not isinstance(words, tuple) or not all(isinstance(one, Word) for one in words):
        yield f"'words' is {_shown(words)}, and must be a tuple of Word(…)"
        return
    commands = tuple(kind.commands) if isinstance(kind.commands, Mapping) else ()
    for one in words:
        if not (isinstance(one.pattern, str) and isinstance(one.help, str) and isinstance(one.fixed, dict)):
            yield f"'words' has {_shown(one)}: its pattern and help must be texts, and 'fixed' a dict"
        elif not one.executive and one.command not in commands:
            yield f"'words' has {_shown(one.pattern)}, which asks for {_shown(one.command)}, none of its commands"
        elif one.role not in get_args(Role):
            yield f"'words' gives {_shown(one.pattern)} {_shown(one.role)}, and must give one of {', '.join(get_args(Role))}"


def _is_struct(value: Any, of: type[Struct]) -> bool:
    return isinstance(value, type) and issubclass(value, of)


def _unfit(message: type[Struct]) -> str:
    """Return why a type cannot be told or read as JSON."""
    try:
        msgspec.json.schema(message)
        msgspec.json.Decoder(message)
    except Exception as err:  # noqa: BLE001 - its annotations are evaluated here, and may be anything
        return f"{type(err).__name__}: {' '.join(str(err).split())[:200]}"
    return ""


def _shown(value: Any) -> str:
    """Return a foreign value as one short line; its `repr` may be anything."""
    try:
        text = value.__name__ if isinstance(value, type) else repr(value)
    except Exception:  # noqa: BLE001 - see above
        text = type(value).__name__
    return "".join(c if c.isprintable() else "?" for c in text[:60])
