"""Write docs/reference/*.md, and the tables and triggers of robot.db.sql, from rows, kinds, messages, settings and commands.

`python docs/generate.py` writes what has changed; with `--check` it writes nothing and fails if a page is stale. Where tables
have changed, `--step NAME` writes the step, too, that brings an older database along.
"""

import ast
import re
import sqlite3
import sys
import tomllib
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import closing
from functools import cache
from itertools import pairwise
from pathlib import Path
from types import ModuleType
from typing import Any

import click
import msgspec
from msgspec import Struct, inspect
from sqlalchemy import Column, MetaData, Table

from lbr import plugins
from lbr.bus import keys
from lbr.capability import registry, twins
from lbr.capability.kind import Kind
from lbr.console.fields import Message
from lbr.console.verbs import Vocabulary
from lbr.database import builtin, migrate, schema
from lbr.database.arguments import told
from lbr.database.books import BOOKS
from lbr.database.checks import check
from lbr.database.rows import CORE, ExternalCommandRow, VerbRow
from lbr.database.shipped import shipped
from lbr.drivers.wheels import contract
from lbr.executive.planning import words
from lbr.executive.planning.profile import Profile
from lbr.executive.planning.wiring import EXECUTIVE, EXECUTIVE_VERBS, least_roles
from lbr.executive.service.completion_values import REPORTS
from lbr.executive.service.journal import CODES
from lbr.messages import codes, system
from lbr.messages.leases import CommandReply
from lbr.messages.rows import Row
from lbr.messages.system import Role, higher
from lbr.simulation import faults

ROOT = Path(__file__).resolve().parent.parent
PAGES = ROOT / "docs" / "reference"
NOWHERE = Path("/nowhere")
NAME_RULE = "a name (small letters, digits, underscores; at most 40)"
PAGE_HEAD = "<!-- Written by docs/generate.py; do not edit. -->\n\n"
ROBOTS = ("lbr", "bioloid", "uxa90")
FAMILIES = ("driver", "operation", "app", "program", "simulation")


def main(arguments: list[str]) -> int:
    """Write or check every page; return the exit code."""
    if missing := not_installed():
        print(f"not installed yet: {', '.join(missing)}; run pip install -e . first", file=sys.stderr)
        return 1
    named = arguments[arguments.index("--step") + 1 :] if "--step" in arguments else []
    if (changed := other_tables()) and not named:
        print(f"tables that are others now: {', '.join(changed)}; python docs/generate.py --step NAME", file=sys.stderr)
        return 1
    if changed:
        write_step(named[0], changed)
    stale = []
    for name, text in pages().items():
        path = ROOT / name
        if not path.exists() or path.read_text() != text:
            stale.append(name)
            if "--check" not in arguments:
                path.write_text(text)
    if stale and "--check" in arguments:
        print(f"stale: {', '.join(stale)}; run python docs/generate.py", file=sys.stderr)
        return 1
    return 0


def not_installed() -> list[str]:
    """Return the components that the project declares and this environment has not heard of: the pages would leave them out."""
    declared = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["entry-points"][plugins.GROUP]
    return sorted(declared.keys() - {one.name for one in plugins.entries() if one.ours})


def own(field: plugins.Field) -> list[str]:
    """Return the names that lbr itself brings; packages that share the environment have pages of their own."""
    return sorted(one.name for one in plugins.own(field))


def pages() -> dict[str, str]:
    """Return the text of every file that is written here, by its path."""
    sql = (ROOT / "robot.db.sql").read_text()
    references = {
        "rows.md": PAGE_HEAD + rows_page(),
        "topics.md": PAGE_HEAD + topics_page(kinds()),
        "console.md": PAGE_HEAD + console_page(),
        "settings.md": PAGE_HEAD + settings_page(kinds()),
        "cli.md": PAGE_HEAD + cli_page(),
        "codes.md": PAGE_HEAD + codes_page(),
        "lbr.1": man_page(),
    }
    written = {str((PAGES / name).relative_to(ROOT)): text for name, text in references.items()}
    drivers = with_contract((ROOT / "docs" / "drivers.md").read_text(), contract)
    return {**written, "docs/drivers.md": drivers, "robot.db.sql": with_schema(sql)}


def kinds() -> list[Kind]:
    """Return the installed kinds, by family and name."""
    found = [registry.find(name, NOWHERE) for name in own("kinds")]
    return sorted(found, key=lambda kind: (FAMILIES.index(kind.family), kind.name))


# -- tables -----------------------------------------------------------------------------------------------------------

_STAMP = re.compile(r"(INTO alembic_version \(version_num\) VALUES \()'\d+'")
SCHEMA_HEAD = "-- The tables, written by docs/generate.py from their declarations: each is a class of rows in lbr.\n\n"
_TABLES = re.compile(r"(?<=^BEGIN;\n\n).*?(?=^-- The revision of this schema)", re.MULTILINE | re.DOTALL)
_TRIGGERS = re.compile(r"^CREATE TRIGGER robot_insert .*?(?=^-- The audit trail)", re.MULTILINE | re.DOTALL)


@cache
def tables() -> MetaData:
    """Return every table: what every robot has, what kinds read, and the books of lbr."""
    books = {book.TABLE for book in BOOKS}
    read = {read.row for kind in kinds() for read in kind.reads if read.row.TABLE not in books}
    return schema.metadata((*CORE, *sorted(read, key=lambda row: (bool(row.whole()), row.TABLE)), *BOOKS))


def other_tables() -> dict[str, str]:
    """Return the SQL by which tables become what they are declared to be, of those that robot.db.sql has otherwise."""
    books = {book.TABLE for book in BOOKS}
    with closing(sqlite3.connect(":memory:")) as database:
        database.executescript((ROOT / "robot.db.sql").read_text())
        before = dict(database.execute("SELECT name, sql FROM sqlite_schema WHERE type = 'table'"))
        found = {}
        for table in tables().tables.values():
            text, old = schema.text(table), before.get(table.name, "")
            if _bare(text.partition("CREATE TABLE")[2]) == _bare(old.partition("CREATE TABLE")[2] + ";"):
                continue
            there = database.execute("SELECT name FROM pragma_table_info(?)", (table.name,)).fetchall()
            kept = [name for (name,) in there if name in table.columns]
            made = schema.rebuilt(table, kept) if old else text
            found[table.name] = made + ("" if table.name in books else f"\n{schema.revision_triggers(table)}")
        gone = before.keys() - tables().tables.keys() - {"sqlite_sequence"}
    return found | {name: f"DROP TABLE {name};\n" for name in gone}


def _bare(sql: str) -> str:
    """Return SQL without comments, and with single blanks."""
    return " ".join(re.sub(r"--.*", "", sql).replace(",", " , ").split())


def write_step(name: str, changed: Mapping[str, str]) -> None:
    """Write the step of an upgrade that has these tables become others; its number is the schema's."""
    before, migrate.HEAD = migrate.HEAD, f"{int(migrate.HEAD) + 1:04d}"
    path = ROOT / "lbr" / "database" / "migrations" / "versions" / f"v{migrate.HEAD}_{name.replace(' ', '_')}.py"
    script = "\n".join(changed.values())
    path.write_text(STEP.format(name=name, revision=migrate.HEAD, before=before, script=script))


STEP = '''"""The schema after: {name}."""

from lbr.database.migrate import run

revision = "{revision}"
down_revision = "{before}"
SCRIPT = r"""
{script}"""


def upgrade() -> None:
    """Change the schema, in the transaction of the caller."""
    run(SCRIPT)


def downgrade() -> None:
    """Change nothing: an older database is kept as a backup whenever one is upgraded."""
'''


def with_schema(sql: str) -> str:
    """Return robot.db.sql with its tables, and the triggers that keep the revisions, as they are declared."""
    books = {book.TABLE for book in BOOKS}
    every = [schema.text(table) for table in tables().tables.values()]
    triggers = [schema.revision_triggers(table) for table in tables().tables.values() if table.name not in books]
    sql = _TABLES.sub(lambda _: SCHEMA_HEAD + "\n".join(every) + "\n", sql)
    sql = _TRIGGERS.sub(lambda _: "\n".join(triggers) + "\n", sql)
    return _STAMP.sub(rf"\g<1>'{migrate.HEAD}'", sql)


# -- contracts --------------------------------------------------------------------------------------------------------


def with_contract(page: str, module: ModuleType) -> str:
    """Return a page with a table of the protocol's members between the comments that name it."""
    source = ast.parse(Path(str(module.__file__)).read_text())
    for of in (node for node in source.body if isinstance(node, ast.ClassDef)):
        begins, ends = f"<!-- {of.name}, by docs/generate.py -->\n", f"<!-- end of {of.name} -->\n"
        if begins in page:
            before, _, rest = page.partition(begins)
            after = rest.partition(ends)[2]
            page = f"{before}{begins}{_table(('member', 'what it is'), _members(of))}{ends}{after}"
    return page


def _members(of: ast.ClassDef) -> Iterable[tuple[str, str]]:
    """Yield the fields and methods of a class, as they are written, with what their source says of them."""
    for node, after in pairwise((*of.body, ast.Pass())):
        if isinstance(node, ast.AnnAssign) and isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant):
            yield f"`{ast.unparse(node)}`", _one_line(str(after.value.value))
        elif isinstance(node, ast.FunctionDef):
            given = ast.unparse(node.args).removeprefix("self").removeprefix(", ")
            call = "" if node.decorator_list else f"({given})"
            told = "" if (found := ast.unparse(node.returns or ast.Constant(None))) == "None" else f" -> {found}"
            yield f"`{node.name}{call}{told}`", _one_line(ast.get_docstring(node) or "")


def _one_line(text: str) -> str:
    return " ".join(text.split())


# -- rows -------------------------------------------------------------------------------------------------------------


def rows_page() -> str:
    """Return the reference of tables and columns."""
    parts = [
        "# The rows\n",
        (
            "You find here every table of a robot database, as `robot.db.sql` makes them; `lbr db tables` prints those of a "
            "robot. How to edit them: [the rows](../rows.md). A *name* has small letters, digits and underscores, at most 40.\n"
        ),
    ]
    return "\n".join(parts + [_table_section(table) for table in tables().tables.values()])


def _table_section(table: Table) -> str:
    columns = [
        (f"`{column.name}` {str(column.type).lower()}", _default(column), schema.comment(column), _rule(column))
        for column in table.columns
    ]
    head = ("column", "default", "meaning", "allowed")
    key = ", ".join(f"`{column.name}`" for column in table.primary_key)
    return f"## {table.name}\n\n{table.comment} Key: {key}.\n\n{_table(head, columns)}{_users(table.name)}"


def _rule(column: Column[Any]) -> str:
    """Return what a column may hold: the table that it refers to, or the words of its check."""
    refers = [f"a row of `{key.column.table.name}`" for key in column.foreign_keys]
    allowed = str(column.info.get("allowed", "")).replace(NAME_RULE, "name")
    return "; ".join(filter(None, [*refers, allowed]))


def _users(table: str) -> str:
    """Return which kinds read a table, and which of them write it."""
    said = []
    ways: dict[str, Callable[[Kind], Iterable[type[Row]]]] = {
        "Read by": lambda kind: (one.row for one in kind.reads),
        "Learnt by": lambda kind: kind.learns,
        "Edited by": lambda kind: kind.rights.edits,
    }
    for what, rows in ways.items():
        users = [kind.name for kind in kinds() if table in {row.TABLE for row in rows(kind)}]
        said += [f"{what} {', '.join(f'`{name}`' for name in users)}."] if users else []
    return f"\n{' '.join(said)}\n" if said else ""


def _default(column: Column[Any]) -> str:
    if column.server_default is None:
        return "`NULL`" if column.nullable else "given" if "counted" in column.info else "required"
    default = schema.default_of(column)
    return "now" if "strftime" in default else f"`{default}`"


# -- codes ------------------------------------------------------------------------------------------------------------


def codes_page() -> str:
    """Return the reference of why something is refused, ended or lost."""
    rows = [(f"`{code}`", meaning) for code, meaning in codes.MEANINGS.items()]
    return (
        "# Codes\n\n"
        "You find here why something is refused, ended or lost. Every refusal, result, loss and event has a `code` beside its "
        "sentence; the result of a console line has it as `reason_code`, because its `code` is the exit code. A `cause` is a "
        "second code: of `dead_lease`, how that lease ended.\n\n"
        "A program reads the code, a person the sentence. A code keeps its meaning for ever, and new ones are added: treat "
        "an unknown one like `refused`, or like `failed` at an end.\n\n"
        + _table(("code", "meaning"), rows)
        + "\n## Events of the executive\n\n"
        "Those of a process (`degraded`, `crashed`, `hung`, `failed`, `need_lost`) have the code of the process, or `failed`, "
        "`timeout` and `unreachable`. In the status, each capability has the `code` of its `reason` and the `end_code` of its "
        "`last_end`; `problem_codes` are those of the `problems`.\n\n"
        + _table(
            ("event", "code"),
            [(f"`{kind}`", f"`{code}`" if code else "none") for kind, code in CODES.items()],
        )
    )


# -- structs ----------------------------------------------------------------------------------------------------------

_UNITS = re.compile(r"_(m|cm|deg|rad|s|ms|us|v|a|c|hz|px|mps|rps|dps|mps2|nm|kg|ut|percent)$")
UNITS = {"metres", "degrees", "seconds", "microseconds", "volts", "microtesla", "amperes", "kilograms", "per cent"}
"""Names with a unit are numbers: the type says no more."""
NAME = "^[a-z][a-z0-9_]*$"


def inline_fields(struct: type[Struct], common: Iterable[str] = ()) -> str:
    """Return a struct's fields as a line: name and default in one, then what neither of them says."""
    own = [field for field in _fields_of(struct) if _shape(field) not in common]
    shared = [f"`{field.encode_name}`" for field in _fields_of(struct) if _shape(field) in common]
    lines = [", ".join(map(_inline, own))] if own else []
    lines += [f"Common: {', '.join(shared)}."] if shared else []
    return "\n\n".join(lines or ["No fields."]) + "\n"


def _inline(field: inspect.Field) -> str:
    default = "" if field.required or _field_default(field) == "…" else f"={_field_default(field)}"
    return " ".join(filter(None, [f"`{field.encode_name}{default}`", _allowed(field), _meaning(field)]))


def _meaning(field: inspect.Field) -> str:
    return f"({meaning})" if (meaning := _effect(field)) else ""


def _effect(field: inspect.Field) -> str:
    """Return what a field does, without the unit that its name ends with."""
    meaning = type_words(field.type)[1]
    return "" if meaning in UNITS and _UNITS.search(field.encode_name) else meaning


def _allowed(field: inspect.Field) -> str:
    """Return the type and bounds of a field, without what its default or its unit says already."""
    words, _ = type_words(field.type)
    said = {"true or false"} if not field.required else set()
    if not field.required and _field_default(field) != "null":
        said |= {"number", "whole number", "text"}
    if _UNITS.search(field.encode_name):
        said |= {"number", "whole number", "number or null"}
        words = re.sub(r"^(whole )?number ", "", words)
    elif not field.required and _field_default(field) != "null":
        words = re.sub(r"^(whole )?number (?=[≥>≤<0-9-])", "", words)
    if _field_default(field) == "null":
        words = words.removesuffix("or null").rstrip()
    return "" if words in said else words


def _fields_of(struct: type[Struct]) -> tuple[inspect.Field, ...]:
    info = inspect.type_info(struct)
    assert isinstance(info, inspect.StructType)
    return info.fields


def _shape(field: inspect.Field) -> str:
    return f"{field.encode_name}: {type_words(field.type)} = {_field_default(field)}"


def common_fields(structs: Iterable[type[Struct]], at_least: int) -> dict[str, inspect.Field]:
    """Return the fields that so many structs have alike, by their shape."""
    every = [field for struct in dict.fromkeys(structs) for field in _fields_of(struct)]
    times = Counter(map(_shape, every))
    return {shape: field for field in every if times[shape := _shape(field)] >= at_least}


def settings_table(struct: type[Struct], common: Iterable[str] = ()) -> str:
    """Return a struct's fields as a table of a line each, and the names of those that are common."""
    head = ("setting", "default", "allowed", "effect")
    own = [field for field in _fields_of(struct) if _shape(field) not in common]
    shared = [f"`{field.encode_name}`" for field in _fields_of(struct) if _shape(field) in common]
    table = _table(head, map(_setting, own)) if own else ""
    return table + (f"\nCommon: {', '.join(shared)}.\n" if shared else "" if own else "No settings.\n")


def _setting(field: inspect.Field) -> tuple[str, ...]:
    default = "required" if field.required else "" if _field_default(field) == "…" else f"`{_field_default(field)}`"
    return f"`{field.encode_name}`", default, _allowed(field), _effect(field)


def type_words(kind: inspect.Type) -> tuple[str, str]:
    """Return a type in words, with its bounds, and its description."""
    if isinstance(kind, inspect.Metadata):
        words, _ = type_words(kind.type)
        return words, str((kind.extra_json_schema or {}).get("description", ""))
    if isinstance(kind, inspect.UnionType):
        parts = [type_words(each) for each in kind.types]
        return " or ".join(words for words, _ in parts), " ".join(text for _, text in parts if text)
    return _plain_words(kind), ""


def _plain_words(kind: inspect.Type) -> str:  # noqa: C901, PLR0911 - a table of cases
    match kind:
        case inspect.FloatType() | inspect.IntType():
            return " ".join(["whole number" if isinstance(kind, inspect.IntType) else "number", *_bounds(kind)])
        case inspect.StrType(pattern=str(pattern)) if _escape(pattern) == NAME:
            return "name"
        case inspect.StrType():
            longest = f" ≤{kind.max_length}" if kind.max_length else ""
            return f"text{longest}" + (f" like `{_escape(kind.pattern)}`" if kind.pattern else "")
        case inspect.LiteralType():
            return "`" + ",".join(msgspec.json.encode(value).decode() for value in kind.values) + "`"
        case inspect.VarTupleType() | inspect.ListType():
            return f"list of {type_words(kind.item_type)[0]}"
        case inspect.TupleType():
            return "list of " + ", ".join(type_words(each)[0] for each in kind.item_types)
        case inspect.DictType():
            return f"object: {type_words(kind.key_type)[0]} to {type_words(kind.value_type)[0]}"
        case inspect.StructType():
            return f"[{kind.cls.__name__}](#{kind.cls.__name__.lower()})"
        case inspect.BoolType():
            return "true or false"
        case inspect.NoneType():
            return "null"
        case _:
            return "anything"


def _bounds(kind: inspect.FloatType | inspect.IntType) -> list[str]:
    if kind.ge is not None and kind.le is not None:
        return [f"{kind.ge:g}…{kind.le:g}"]
    low = f"≥{kind.ge:g}" if kind.ge is not None else f">{kind.gt:g}" if kind.gt is not None else ""
    high = f"≤{kind.le:g}" if kind.le is not None else f"<{kind.lt:g}" if kind.lt is not None else ""
    return [f"{low}{high}"] if low or high else []


def _field_default(field: inspect.Field) -> str:
    if field.required:
        return "required"
    value = field.default if field.default_factory is msgspec.NODEFAULT else field.default_factory()
    shown = msgspec.json.encode(value).decode()
    return shown if len(shown) <= 60 and not isinstance(value, Struct) else "…"


def nested(struct: type[Struct]) -> list[type[Struct]]:
    """Return the structs inside a struct's fields, depth first, each once."""
    found: list[type[Struct]] = []

    def walk(kind: Any) -> None:
        if isinstance(kind, inspect.StructType):
            if kind.cls is not struct and kind.cls not in found:
                found.append(kind.cls)
            for field in kind.fields:
                walk(field.type)
        for part in ("type", "item_type", "key_type", "value_type"):
            if hasattr(kind, part) and not isinstance(kind, inspect.StructType):
                walk(getattr(kind, part))
        for one in getattr(kind, "types", ()):
            walk(one)

    walk(inspect.type_info(struct))
    return found


# -- topics -----------------------------------------------------------------------------------------------------------

_PORTS = (
    ("publishes", "outputs"),
    ("takes", "inputs"),
    ("obeys", "setpoints"),
    ("answers", "messages"),
    ("asks", "requests"),
)
_SYSTEM = (
    (keys.console("ROBOT"), "query: a console line as text; the reply is its result", None, system.ConsoleResult),
    (keys.estop("ROBOT"), "put to latch; a get answers with the latch", system.EstopRequest, system.EstopState),
    (keys.estop_reset("ROBOT"), "query: releases the emergency stop, if every mover agrees", None, None),
    (keys.estop_acknowledgement("ROBOT", "CAPABILITY"), "stream: one mover's word", None, system.EstopAcknowledgement),
    (keys.status("ROBOT"), "query, and a stream at 1 Hz", None, system.Status),
    (keys.event("ROBOT"), "stream: what happened", None, system.Event),
    (keys.alive("ROBOT", "CAPABILITY"), "liveliness token of each process", None, None),
    (keys.schema("ROBOT", "CAPABILITY", "NAME"), "query: JSON Schema of a stream's or command's message", None, None),
)


_COMMON = {
    "accepted": "whether the robot does what was asked",
    "age_s": "how old it is",
    "cause": "a second [code](codes.md): of `dead_lease`, how that lease ended",
    "code": "the [code](codes.md) of `reason`, for programs",
    "lease": "the lease that this command renews or changes; empty: a new one",
    "reason": "a sentence for people: why it is refused, ended or not known; empty: nothing to explain",
    "take_over": "take the lease from its holder, where the role allows it",
    "temperature_c": "null: not measured",
    "ttl_s": "the command ends after this time, unless it is renewed",
    "valid": "false: do not use the rest",
}


def topics_page(known: list[Kind]) -> str:
    """Return the reference of keys and messages."""
    messages = _messages(known)
    common = {shape: field for shape, field in common_fields(messages, 4).items() if field.encode_name in _COMMON}
    parts = [
        "# Topics and messages\n",
        (
            "You find here each key on the bus and each message on it. A running robot prints the same: "
            "`lbr topic list`, `lbr topic info KEY`.\n"
        ),
        (
            "A key is `<robot>/<capability>/<name>`; the middle part is the row's name, not the kind's. Payloads are JSON. "
            "A unit ends the name of a number: `_m` metres, `_deg` degrees, `_rad` radians, `_s` seconds, `_v` volts, `_a` "
            "amperes, `_mps` metres a second, `_rps` radians a second, `_c` degrees Celsius. How to use them: "
            "[the bus](../bus.md).\n"
        ),
        "## System keys\n",
        _table(
            ("key", "how", "takes", "gives"),
            [(f"`{key}`", how, _link(takes), _link(gives)) for key, how, takes, gives in _SYSTEM],
        ),
        "## By kind\n",
        "A command is answered by a [CommandReply](#commandreply), unless `→` names another message.\n",
    ]
    parts += [_kind_ports(kind) for kind in known]
    parts.append("## Messages\n")
    parts.append(
        "A field is shown with its default; a field without default is required. The type is named where neither default nor "
        "unit shows it. *name*: small letters, digits and underscores, at most 40. Common fields are explained once:\n"
    )
    shown = {field.encode_name: _allowed(field) for field in common.values()}
    parts.append(
        _table(("field", "type", "meaning"), [(f"`{each}`", shown[each], _COMMON[each]) for each in sorted(shown)])
    )
    parts += [_message_section(message, common) for message in messages]
    return "\n".join(parts)


def _kind_ports(kind: Kind) -> str:
    lines = []
    for does, group in _PORTS:
        ports: Mapping[str, type[Struct]] = getattr(kind, group)
        named = [f"`{name}` {_link(message)}{_reply(kind, name)}" for name, message in ports.items()]
        lines += [f"- {does} {', '.join(named)}"] if named else []
    return f"### Kind `{kind.name}`\n\n" + "\n".join(lines or ["Its settings name its ports."]) + "\n"


def _reply(kind: Kind, name: str) -> str:
    reply = kind.replies.get(name)
    return f"→{_link(reply)}" if reply not in {None, CommandReply} else ""


def _messages(known: Iterable[Kind]) -> list[type[Struct]]:
    named: list[type[Struct]] = [
        message for _, _, takes, gives in _SYSTEM for message in (takes, gives) if message is not None
    ]
    named += [system.Stamp]
    for kind in known:
        for group in ("outputs", "inputs", "setpoints", "messages", "requests", "replies"):
            named += list(getattr(kind, group).values())
    whole = {one for message in named for one in (message, *nested(message))}
    found = sorted(whole, key=lambda message: message.__name__)
    for one, other in pairwise(found):
        if one.__name__ == other.__name__:
            raise ValueError(f"{one.__module__} and {other.__module__} have a message {one.__name__} each; rename one")
    return found


def _message_section(message: type[Struct], common: Iterable[str]) -> str:
    return f"### {message.__name__}\n\n{_doc(message)}\n\n{inline_fields(message, common)}"


def _link(message: type[Struct] | None) -> str:
    return f"[{message.__name__}](#{message.__name__.lower()})" if message is not None else ""


# -- settings ---------------------------------------------------------------------------------------------------------


def settings_page(known: list[Kind]) -> str:
    """Return the reference of what rows and launch profiles may set."""
    ours = [part for kind in known for part in (kind.settings, *nested(kind.settings))]
    common = {shape: field for shape, field in common_fields(ours, 2).items() if _effect(field)}
    common |= {shape: field for shape, field in common_fields(ours, 3).items() if field.encode_name in _SHARED}
    parts = [
        "# Settings\n",
        (
            "You find here what the column `settings` of a `capability` row may hold, by the row's kind. Unknown keys are "
            "refused. `lbr get NAME` prints the settings of a running robot's part, `lbr set NAME KEY=VALUE` changes one.\n"
        ),
        (
            "*name*: small letters, digits and underscores, at most 40. A setting `device` names a row of the table "
            "`device`, whose type is that of the kind. These settings mean the same in every kind:\n"
        ),
        _table(("setting", "default", "allowed", "effect"), sorted(map(_common_setting, common.values()))),
    ]
    shown: list[type[Struct]] = []
    for kind in known:
        new = [each for each in nested(kind.settings) if each not in shown]
        section = [f"## Kind `{kind.name}`\n\n{_sentence(kind.summary)}{_about(kind.settings)}\n"]
        section += [settings_table(kind.settings, common), *(_part(each, common) for each in new)]
        parts.append(_distinct("\n".join(section), kind.name, new, shown))
        shown += new
    parts.append(
        "## Faults of emulated devices\n\nUnder a simulating profile the column `settings` of a `device` row says how "
        "its twin is built, and what is wrong with it. The command `fault` of the simulated world changes the faults while "
        "it runs. `unplug` takes a device away; a number 0…1 is how often a fault happens; a list has the ids of servos.\n"
    )
    twin = {device: row.row for device in own("twins") if (row := twins.find(device)) is not None}
    for device, row in twin.items():
        new = [each for each in nested(row) if each not in shown]
        section = [f"### Type `{device}`\n\n{_doc(row)}\n\n{_faults(row)}"]
        section += [f"#### {each.__name__}\n\n{_doc_with_bases(each)}\n\n{_faults(each)}" for each in new]
        parts.append(_distinct("\n".join(section), device, new, shown))
        shown += new
    parts.append(f"## Launch profiles\n\nA TOML file. {_doc(Profile)}\n\n{settings_table(Profile)}")
    return "\n".join(parts)


_SHARED = {"device": "the row of its device", "setpoint_valid_s": "an older setpoint is not obeyed", "guard": ""}
_SHARED["guard"] = "a process of its own stops the device when the driver is gone"


def _common_setting(field: inspect.Field) -> tuple[str, ...]:
    name, default, allowed, effect = _setting(field)
    return name, default, allowed, effect or _SHARED[field.encode_name]


def _about(settings: type[Struct]) -> str:
    """Return what a settings class says beyond that it is one."""
    text = re.sub(r"^Settings of a row of kind `\w+`[.;] ?", "", _doc(settings))
    return text if text.startswith("\n") or not text else f" {text[:1].upper()}{text[1:]}"


def _part(struct: type[Struct], common: Iterable[str]) -> str:
    inherited = {_shape(field) for base in struct.__bases__ if base is not Struct for field in _fields_of(base)}
    return f"### {struct.__name__}\n\n{_doc(struct)}\n\n{settings_table(struct, {*common, *inherited})}"


def _distinct(text: str, of: str, new: Iterable[type[Struct]], shown: Iterable[type[Struct]]) -> str:
    """Return a section whose parts have headings of their own, also where another section has a part of that name."""
    taken = {each.__name__ for each in shown}
    for name in (each.__name__ for each in new if each.__name__ in taken):
        text = text.replace(f"### {name}\n", f"### {name} of {of}\n").replace(
            f"(#{name.lower()})", f"(#{name.lower()}-of-{of})"
        )
    return text


def _faults(struct: type[Struct]) -> str:
    text = inline_fields(struct).replace(" (how often it happens, 0 never, 1 always)", "")
    return text.replace("=[]` list of whole number 0…253", "=[]`").replace("=0.0` 0…1", "=0.0`")


# -- console ----------------------------------------------------------------------------------------------------------


def console_page() -> str:
    """Return the reference of what can be said to the robots that come with lbr."""
    parts = [
        "# Words of the console\n",
        (
            "You find here the lines that the robots of lbr understand at the console: those that their capabilities' kinds "
            "bring, and the rows of the tables `verb` and `external_command`. `help` at the console lists those of a robot.\n"
        ),
        (
            "A line that starts with a slash is split at its slashes; doubled slashes count once. Bare words without an exact "
            "match are looked up in small letters. A word needs the role that its row or kind names, or that of its command, "
            "if that is higher. What `executive` does by itself: "
            + ", ".join(f"`{name}`" for name in sorted(EXECUTIVE_VERBS))
            + f". Reports: {', '.join(f'`{name}`' for name in REPORTS)}.\n"
        ),
        "## Every robot\n",
        "No row may replace one of these, in capital letters or small ones.\n",
        _table(
            ("say", "what it does", "least role"), [(f"`{row.pattern}`", row.help, row.role) for row in builtin.WORDS]
        ),
        "A row of the robot may replace these.\n",
        _words([words.as_row(EXECUTIVE, word) for word in words.OF_EVERY_ROBOT], least_roles({})),
        "## By kind\n",
        (
            "Every robot with a capability of the kind understands these; they ask for a command of that capability. A row "
            "with the same pattern replaces one.\n"
        ),
    ]
    for kind in kinds():
        if kind.words:
            rows = [words.as_row(kind.name, word) for word in kind.words]
            parts += [f"### Kind `{kind.name}`\n", _words(rows, least_roles({kind.name: kind}))]
            parts += _fields(rows, _messages_of({kind.name: kind}))
    for name in ROBOTS:
        rows = check(shipped()[0], name)
        named = {row.name: registry.find(row.kind, NOWHERE) for row in rows.capabilities}
        Vocabulary(words.words(rows, named), rows.external_commands, _messages_of(named))  # refuses what cannot be said
        parts += [f"## Robot `{name}`\n", "Besides what its kinds bring:\n", _words(rows.verbs, least_roles(named))]
        parts += _fields(rows.verbs, _messages_of(named))
        commands = [
            (f"`{row.name}`", row.help, _arguments(row), f"`{' '.join(row.argv)}`", row.role, _waits(row))
            for row in rows.external_commands
        ]
        head = ("say", "what it does", "arguments", "runs", "least role", "the console")
        parts += ["### External commands\n", _table(head, commands)] if commands else []
    return "\n".join(parts)


def _words(rows: Iterable[VerbRow], needed: Mapping[str, Role]) -> str:
    said = [
        (
            f"`{row.pattern}`",
            row.help,
            f"`{row.target}{_payload(row)}`",
            higher(row.role, needed.get(row.target, "view")),
        )
        for row in rows
    ]
    return _table(("say", "what it does", "asks", "least role"), said) if said else "Nothing.\n"


def _messages_of(known: Mapping[str, Kind]) -> dict[str, type[Struct]]:
    return {f"{name}.{command}": message for name, kind in known.items() for command, message in kind.messages.items()}


def _fields(rows: Iterable[VerbRow], targets: Mapping[str, type[Struct]]) -> list[str]:
    allowed: dict[str, str] = {}
    for row in rows:
        for name in re.findall(r"\{([a-z_]+)", row.pattern):
            allowed[name] = Message(targets.get(row.target)).field(name).allowed
    return [f"Fields: {'; '.join(f'`{name}` {words}' for name, words in allowed.items())}.\n"] if allowed else []


def _payload(row: VerbRow) -> str:
    return msgspec.json.encode(row.payload).decode() if row.payload else ""


def _arguments(row: ExternalCommandRow) -> str:
    return ", then ".join(told(one) for one in row.arguments or ()) or "none"


def _waits(row: ExternalCommandRow) -> str:
    return "waits for its end" if row.blocking else f"goes on; `stop {row.name}` ends it"


# -- command line -----------------------------------------------------------------------------------------------------


def cli_page() -> str:
    """Return every command: what it is for, and its own options."""
    common = (f"|`{option}`|{meaning}|" for option, meaning in COMMON_OPTIONS.items())
    parts = [
        "# The command line\n",
        (
            "You find here every command and its options. `lbr COMMAND --help` and `man lbr` say more of each. "
            "Many commands have these options, named below without explanation:\n"
        ),
        "|option|meaning|\n|---|---|\n" + "\n".join(common) + "\n",
    ]
    parts += map(_command_section, _commands(the_command_line(), "lbr", None))
    return "\n".join(parts)


COMMON_OPTIONS = {
    "--robot": "which robot; the only one that runs here if left out",
    "--connect": "reach a robot elsewhere, such as `tls/192.168.1.7:7447`",
    "--token-file": "the file with the token for `--connect`; else it is `LBR_TOKEN`, a saved one, or asked for",
    "--json": "print JSON, for programs",
    "--db": "the database; `$LBR_HOME/robot.db` if left out",
}


def _command_section(context: click.Context) -> str:
    """Return a command's line, the first sentence of its help, and its options, of which some are only named."""
    usage = " ".join(context.command.collect_usage_pieces(context)).removeprefix("[OPTIONS]").strip()
    first = _one_line((context.command.help or "").split("\n\n")[0])
    options = [option for option in context.command.params if isinstance(option, click.Option) and not option.hidden]
    common = [option.opts[0] for option in options if option.opts[0] in COMMON_OPTIONS]
    own = [option.get_help_record(context) for option in options if option.opts[0] not in {*common, "--help", "-h"}]
    parts = [f"## `{context.command_path}`\n", f"`{usage}` {first}".removeprefix("`` ") + "\n"]
    parts += (
        ["\n".join(f"- `{option}` {_one_line(text)}" for option, text in filter(None, own)) + "\n"] if any(own) else []
    )
    parts += [f"Common: {', '.join(f'`{name}`' for name in common)}.\n"] if common else []
    return "\n".join(parts)


def the_command_line() -> click.Group:
    """Return lbr's own commands."""
    from lbr.cli import Commands, cli  # noqa: PLC0415 - only these pages need it

    Commands.others = False
    return cli


def _commands(command: click.Command, name: str, parent: click.Context | None) -> Iterator[click.Context]:
    settings = {"terminal_width": 100, "max_content_width": 100, **command.context_settings}
    with click.Context(command, info_name=name, parent=parent, **settings) as context:
        yield context
        if isinstance(command, click.Group):
            for child in command.list_commands(context):
                found = command.get_command(context, child)
                if found is not None and not found.hidden:
                    yield from _commands(found, child, context)


def man_page() -> str:
    """Return the same as a page of the manual, in the language of man (7)."""
    parts = ['.\\" Written by docs/generate.py; do not edit.', '.TH LBR 1 "" lbr "User commands"', ".SH NAME"]
    parts.append(r"lbr \- run a robot that is rows in a database, and talk to it")
    for context in _commands(the_command_line(), "lbr", None):
        lines = (line.rstrip() for line in context.command.get_help(context).splitlines())
        parts += [f'.SH "{context.command_path.upper()}"', ".nf", *map(_roff, lines), ".fi"]
    parts += [
        ".SH FILES",
        ".nf",
        r"~/.lbr/robot.db    what the robot is (LBR_HOME says where else)",
        r"~/.lbr/logs        what its parts write",
        ".fi",
    ]
    return "\n".join(parts) + "\n"


def _roff(line: str) -> str:
    """Return a line of plain text as man shows it: no command, no escape."""
    plain = line.replace("\\", r"\e").replace("-", r"\-")
    return rf"\&{plain}" if plain[:1] in {".", "'"} else plain


# -- Markdown ---------------------------------------------------------------------------------------------------------


def _table(head: tuple[str, ...], rows: Iterable[tuple[str, ...]]) -> str:
    lines = [head, tuple("---" for _ in head), *rows]
    return "".join("|" + "|".join(_cell(cell) for cell in line) + "|\n" for line in lines)


def _cell(text: str) -> str:
    return text.replace("\n", " ").replace("|", "\\|")


def _escape(pattern: str) -> str:
    return pattern.replace("\x00", "\\x00").replace("$(?!\\n)", "$")


def _doc_with_bases(of: type) -> str:
    """Faults that several devices have are told where they are defined."""
    told = [one for one in of.__mro__ if issubclass(one, faults.Faults) and one is not faults.Faults]
    return "\n\n".join(map(_doc, told or [of]))


def _doc(of: type) -> str:
    paragraphs = (of.__doc__ or "").strip().split("\n\n")
    return "\n\n".join(" ".join(line.strip() for line in paragraph.splitlines()) for paragraph in paragraphs)


def _sentence(text: str) -> str:
    return text[:1].upper() + text[1:] + "."


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
