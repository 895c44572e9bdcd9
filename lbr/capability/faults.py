"""Faults of a declared kind: values that do not fit their fields, then fields that contradict each other."""

import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import is_dataclass, replace
from itertools import chain
from types import NoneType, UnionType
from typing import Any, Literal, get_args, get_origin, get_type_hints

import msgspec
from msgspec import Struct

from lbr.capability.border import border
from lbr.capability.kind import Command, Kind
from lbr.capability.program import ProgramSettings
from lbr.errors import told
from lbr.messages.rows import Row

PORTS = ("inputs", "setpoints", "outputs", "commands", "replies", "requests")
_NAME = re.compile(r"[a-z][a-z0-9_]{0,39}")
_ENTRY = re.compile(r"[A-Za-z_][\w.]*:[A-Za-z_]\w*")
_SOUND = Kind(name="sound", summary="", family="app", entry="some:Class")
"""Supplies the substitutes for values that do not fit."""
_PLAIN = {str: "a text", bool: "True or False", int: "a number", NoneType: "None", type: "a class", dict: "a dict"}


def faults(kind: Kind) -> tuple[str, ...]:
    """Return one sentence for each fault in a kind, whatever types its fields have."""
    misfits = dict(_misfits(kind))
    sound = replace(kind, **{name: getattr(_SOUND, name) for name, texts in misfits.items() if texts})
    return (*chain.from_iterable(misfits.values()), *_contradictions(sound))


def _misfits(part: object) -> Iterator[tuple[str, tuple[str, ...]]]:
    """Yield the fields of a part, each with one sentence for each value that does not fit its annotation."""
    for name, hint in get_type_hints(type(part)).items():
        yield name, tuple(_misfit(f"'{name}'", getattr(part, name), hint))


def _misfit(where: str, value: Any, hint: Any) -> Iterator[str]:
    origin, options = get_origin(hint) or hint, get_args(hint)
    if origin is UnionType:
        if all(any(_misfit(where, value, option)) for option in options):
            if type(value) in options and is_dataclass(value):
                yield from _misfit(where, value, type(value))
            else:
                yield f"{where} is {_brief(value)}, and must be {' or '.join(map(_in_words, options))}"
    elif not _fits(value, origin, options):
        yield f"{where} is {_brief(value)}, and must be {_in_words(hint)}"
    elif origin is Mapping:
        for key, item in value.items():
            yield from _misfit(f"a name in {where}", key, options[0])
            yield from _misfit(f"{_brief(key)} in {where}", item, options[1])
    elif origin in {tuple, Collection}:
        for item in value:
            yield from _misfit(f"one of {where}", item, options[0])
    elif is_dataclass(origin):
        yield from chain.from_iterable(texts for _name, texts in _misfits(value))


def _fits(value: Any, origin: Any, options: tuple[Any, ...]) -> bool:
    """Return whether a value itself fits an annotation; its elements are not looked at."""
    if origin is Literal:
        return isinstance(value, str) and value in options
    if origin is type:
        return isinstance(value, type) and all(issubclass(value, option) for option in options)
    if origin is Callable:
        return callable(value)
    text = isinstance(value, str) and origin is Collection  # a string is a collection of its letters
    return origin is Any or (isinstance(value, origin) and not text)


def _in_words(hint: Any) -> str:
    origin, options = get_origin(hint) or hint, get_args(hint)
    if origin is Literal:
        return f"one of {', '.join(map(repr, options))}"
    if origin is type and options:
        return f"a class that is a {options[0].__name__}"
    names = {Mapping: "a dict", tuple: "a tuple", Collection: "a tuple", Callable: "a function"} | _PLAIN
    return names.get(origin) or f"{origin.__name__}(…)"


def _contradictions(kind: Kind) -> Iterator[str]:
    if kind.family == "program" and not issubclass(kind.settings, ProgramSettings):
        yield "'family' is 'program', which is for programs of the user's"
    yield from _entry(kind.entry)
    for group in PORTS:
        yield from _ports(group, getattr(kind, group))
    yield from _settings(kind)
    for read in kind.reads:
        yield from _table("rows", read.row)
        yield from _strangers("rows", read.where, read.row.__struct_fields__, f"a column of {read.row.__name__}")
        yield from _setting(kind, "rows", *read.where.values())
    for row in kind.rights.edits:
        yield from _table("edits", row)
    yield from _setting(kind, "lets_in", *(name for name in kind.rights.lets_in if name != "enabled"))
    yield from _strangers("optional", kind.optional, kind.inputs, "one of its inputs")
    yield from _strangers("replies", kind.replies, {**kind.commands, **kind.requests}, "what it answers or asks for")
    asked = [word.command for word in kind.words if not word.executive]
    yield from _strangers("words", asked, kind.commands, "one of its commands")
    for name in kind.commands:
        command = kind.command(name)
        fields = command.message.__struct_fields__
        yield from _strangers("choices", command.choices, fields, f"a field of {command.message.__name__}")
    if kind.rights.pairs and not ("address" in kind.commands and "pair" in kind.requests):
        yield "'pairs' needs a command 'address', which returns its address, and a request 'pair'"


def _strangers(field: str, names: Iterable[object], known: Collection[str], what: str) -> Iterator[str]:
    return (f"'{field}' names {_brief(name)}, which is not {what}" for name in names if name not in known)


def _setting(kind: Kind, field: str, *names: str) -> Iterator[str]:
    return _strangers(field, names, kind.settings.__struct_fields__, f"a field of {kind.settings.__name__}")


def _entry(entry: str | type) -> Iterator[str]:
    if isinstance(entry, str):
        if not _ENTRY.fullmatch(entry):
            yield f"'entry' is {_brief(entry)}, and must be a class or \"module:Class\""
        return
    from lbr.capability.base import Capability  # noqa: PLC0415 - a caller with a class has imported it

    if not issubclass(entry, Capability):
        yield f"'entry' is {_brief(entry)}, and must be a class that is a Capability, or \"module:Class\""


def _ports(group: str, ports: Mapping[str, type[Struct] | Command]) -> Iterator[str]:
    for name, port in ports.items():
        message = port.message if isinstance(port, Command) else port
        if not _NAME.fullmatch(name):
            yield f"'{group}' names a port {_brief(name)}: small letters, digits, underscores; at most 40"
        if not message.__struct_config__.frozen:
            frozen = f"class {message.__name__}(Struct, frozen=True)"
            yield f"port {_brief(name)} carries {message.__name__}, which must be frozen: {frozen}"
        elif fault := _unfit(message):
            yield f"port {_brief(name)} carries {message.__name__}, which is not JSON: {fault}"


def _settings(kind: Kind) -> Iterator[str]:
    config = kind.settings.__struct_config__
    if not (config.frozen and config.forbid_unknown_fields):
        need = "frozen=True, forbid_unknown_fields=True"
        yield f"'settings' is {kind.settings.__name__}, which must be declared with {need}"
    if fault := _unfit(kind.settings):
        yield f"'settings' is {kind.settings.__name__}, which is not JSON: {fault}"
    yield from _setting(kind, "says", *filter(None, (kind.says,)))
    if kind.device is not None and "device" not in kind.settings.__struct_fields__:
        yield f"'device' needs a field 'device' in {kind.settings.__name__}, which names the device row"
    if kind.rights.pairs and "host" not in kind.settings.__struct_fields__:
        yield "'pairs' needs a setting 'host', which the words `open` and `close` change"


def _table(field: str, row: type[Row]) -> Iterator[str]:
    """Yield why the row type in a field is no table's."""
    table, key, fault = getattr(row, "TABLE", None), getattr(row, "KEY", None), _unfit(row)
    if not fault and not (isinstance(table, str) and _NAME.fullmatch(table)):
        fault = f"its TABLE is {_brief(table)}, and must be the name of one"
    columns = row.__struct_fields__
    if not fault and not (isinstance(key, tuple) and key and all(column in columns for column in key)):
        fault = f"its KEY is {_brief(key)}, and must be the columns that identify a row"
    if fault:
        yield f"'{field}' names {row.__name__}, which is not a table: {fault}"


def _unfit(message: type[Struct]) -> str:
    """Return why a type cannot be encoded or decoded as JSON."""
    faults: list[Exception] = []
    with border(faults.append):  # its annotations are evaluated here, and may raise anything
        msgspec.json.schema(message)
        msgspec.json.Decoder(message)
    return "".join(map(told, faults))


def _brief(value: object) -> str:
    """Return a foreign value as one short line; its `repr` may raise anything."""
    text = type(value).__name__
    with suppress(Exception):
        text = value.__name__ if isinstance(value, type) else repr(value)
    return "".join(c if c.isprintable() else "?" for c in text[:60])
