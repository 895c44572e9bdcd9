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
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import closing
from functools import cache
from itertools import pairwise
from pathlib import Path
from types import ModuleType
from typing import Any, get_args

import click
import msgspec
from msgspec import Struct, inspect
from sqlalchemy import Column, MetaData, Table, sql
from sqlalchemy.dialects import sqlite
from sqlalchemy.schema import DropTable

from lbr import plugins
from lbr.bus import keys
from lbr.capability import registry, twins
from lbr.capability.kind import Kind
from lbr.capability.word import Word
from lbr.console.verbs import Vocabulary
from lbr.database import builtin, migrate, schema
from lbr.database.arguments import described
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
from lbr.messages.gamepad import Button
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
        print(f"tables that have changed: {', '.join(changed)}; python docs/generate.py --step NAME", file=sys.stderr)
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
            made = _rebuilt(table, kept) if old else text
            found[table.name] = made + ("" if table.name in books else f"\n{schema.revision_triggers(table)}")
        gone = before.keys() - tables().tables.keys() - {"sqlite_sequence"}
    return found | {name: f"DROP TABLE {name};\n" for name in gone}


def _rebuilt(table: Table, names: Sequence[str]) -> str:
    """Return the SQL that rebuilds a table with its values in these columns, without its triggers."""
    known = MetaData()
    replacement, former = (
        table.to_metadata(known, name=f"{table.name}_new"),
        sql.table(table.name, *map(sql.column, names)),
    )
    copied = sql.insert(replacement).from_select(list(names), sql.select(former), include_defaults=False)
    lines = [str(copied.compile(dialect=sqlite.dialect())), str(DropTable(table))]
    moved = f"ALTER TABLE {replacement.name} RENAME TO {table.name}"
    return schema.text(replacement) + "".join(f"{' '.join(line.split())};\n" for line in (*lines, moved))


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
            "robot. How to edit them: [the rows](../rows.md). A *name* has small letters, digits and underscores, at most 40. "
            "`?`: or NULL. A default shows the column's type; else it is named.\n"
        ),
    ]
    shapes = [_column(column) for table in tables().tables.values() for column in table.columns]
    common = {shape for shape, times in Counter(shapes).items() if times > 3}
    parts += [
        "The key is `robot` and `name`, unless a table has another. These columns are only named in the tables:\n",
        _table(COLUMN_HEAD, sorted(common)),
    ]
    return "\n".join(parts + [_table_section(table, common) for table in tables().tables.values()])


COLUMN_HEAD = ("column", "default", "meaning", "allowed")


def _column(column: Column[Any]) -> tuple[str, ...]:
    default = _default(column)
    shown = f"`{column.name}`" if re.match(r"`['\d-]", default) else f"`{column.name}` {str(column.type).lower()}"
    return shown, default, re.sub(r"^JSON (object|list): ", "", schema.comment(column)), _rule(column)


def _table_section(table: Table, common: set[tuple[str, ...]]) -> str:
    columns = [
        (shape[0].partition(" ")[0], "", "", "") if (shape := _column(column)) in common else shape
        for column in table.columns
    ]
    head = COLUMN_HEAD
    names = [column.name for column in table.primary_key]
    key = "" if names == ["robot", "name"] else f" Key: {', '.join(f'`{name}`' for name in names)}."
    return f"## {table.name}\n\n{table.comment}{key}\n\n{_table(head, columns)}{_users(table.name)}"


_RULES = {
    r"a JSON object like {.*?}": "JSON object",
    r"a JSON list like \[.*?\]": "JSON list",
    r"name, or empty for none": "name or empty",
    r"one of |of the form ": "",
    r"above (\S+) and at most (\S+\b)": r">\1≤\2",
    r"(?:from )?(\S+) to (\S+)(?= characters|$|,)": r"\1…\2",
    r"at least (?=\d)": "≥",
    r"at most (?=\d)": "≤",
    r", or NULL": "?",
}


def _rule(column: Column[Any]) -> str:
    """Return what a column may hold: the table that it refers to, or the words of its check."""
    refers = [f"a row of `{key.column.table.name}`" for key in column.foreign_keys]
    allowed = str(column.info.get("allowed", "")).replace(NAME_RULE, "name")
    for longer, shorter in _RULES.items():
        allowed = re.sub(longer, shorter, allowed)
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
        "sentence; the result of a console line calls it `reason_code`, its `code` is the exit code. A `cause` is a second code: "
        "how the lease of a `dead_lease` ended. Codes keep their meaning, and new ones are added: treat an unknown one like "
        "`refused`, or like `failed` at an end.\n\n"
        + _table(("code", "meaning"), rows)
        + "\n## Events of the executive\n\n"
        "Those of a process (`degraded`, `crashed`, `hung`, `failed`, `need_lost`) have the code of the process, or `failed`, "
        "`timeout` and `unreachable`. In the status, `end_code` belongs to `last_end`, and `problem_codes` to `problems`.\n\n"
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
_CODES = {"why, from the list of codes; empty: no reason": "a [code](codes.md)"}


def inline_fields(struct: type[Struct], common: Iterable[str] = ()) -> str:
    """Return a struct's fields as a line: name and default in one, then what neither of them says."""
    own = [field for field in _fields_of(struct) if _shape(field) not in common]
    shared = [f"`{field.encode_name}`" for field in _fields_of(struct) if _shape(field) in common]
    shown = [_inline(field, before) for field, before in zip(own, [None, *own], strict=False)]
    return ", ".join([*shown, *shared]) + "\n" if own or shared else ""


def _inline(field: inspect.Field, before: inspect.Field | None) -> str:
    default = "" if field.required or _field_default(field) == "…" else f"={_field_default(field)}"
    allowed = _allowed(field).removeprefix("text") if _allowed(field) in {"text", "text?"} else _allowed(field)
    meaning = _effect(field)
    told = f"({meaning})" if meaning and (before is None or meaning != _effect(before)) else ""
    return " ".join(
        filter(
            None,
            [
                f"`{field.encode_name}{default}`{allowed if allowed == '?' else ''}",
                allowed.strip("?") and allowed,
                told,
            ],
        )
    )


def _effect(field: inspect.Field) -> str:
    """Return what a field does, without the unit that its name ends with."""
    meaning = type_words(field.type)[1]
    if not _UNITS.search(field.encode_name):
        return _CODES.get(meaning, meaning)
    plain = re.sub(
        r"^(?:metres a second|radians a second|degrees|seconds|metres|centimetres)(?:$|, |; | (?=clockwise))",
        "",
        meaning,
    )
    return "" if meaning in UNITS else plain


def _allowed(field: inspect.Field) -> str:
    """Return the type and bounds of a field, without what its default or its unit says already."""
    words, _ = type_words(field.type)
    said = {"boolean"} if not field.required else set()
    if not field.required and _field_default(field) != "null":
        said |= {"number", "integer", "text"}
    if _field_default(field) == "null":
        words = words.removesuffix("?")
    if _UNITS.search(field.encode_name):
        said |= {"number", "integer"}
        words = re.sub(r"^(number|integer)(?= |\?$)", "", words).strip()
    elif not field.required and _field_default(field) != "null":
        words = re.sub(r"^(number|integer) (?=[≥>≤<0-9-])", "", words)
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
    table = _table(head, _without_repeats(map(_setting, own))) if own else ""
    return table + (f"\nCommon: {', '.join(shared)}.\n" if shared else "" if own else "No settings.\n")


def _without_repeats(rows: Iterable[tuple[str, ...]]) -> Iterator[tuple[str, ...]]:
    """Yield the rows of a table; a longer last cell is not repeated from one row to the next."""
    before = ""
    for *cells, last in rows:
        repeated = last == before and last.count(" ") > 1
        yield (*cells, "as above" if repeated else last)
        before = last


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
        words = " or ".join(words for words, _ in parts if words != "null")
        null = "?" if "null" in {words for words, _ in parts} else ""
        return words + null, " ".join(dict.fromkeys(text for _, text in parts if text))
    return _plain_words(kind), ""


def _plain_words(kind: inspect.Type) -> str:  # noqa: C901, PLR0911 - a table of cases
    match kind:
        case inspect.FloatType() | inspect.IntType():
            return " ".join(["integer" if isinstance(kind, inspect.IntType) else "number", *_bounds(kind)])
        case inspect.StrType(pattern=str(pattern)) if (named := _escape(pattern)) in {NAME, f"^$|{NAME}"}:
            return "name" if named == NAME else "name or empty"
        case inspect.StrType():
            longest = f"≤{kind.max_length}" if kind.max_length else ""
            return f"`{_escape(kind.pattern)}`" if kind.pattern else f"text{longest}"
        case inspect.LiteralType():
            return "*button*" if {*kind.values} == {*get_args(Button)} else _literals(kind.values)
        case inspect.VarTupleType() | inspect.ListType():
            return _list_of(type_words(kind.item_type)[0])
        case inspect.TupleType():
            items = [type_words(each)[0] for each in kind.item_types]
            return f"{len(items)}*{items[0]}" if len(set(items)) == 1 else f"[{', '.join(items)}]"
        case inspect.DictType():
            return f"{type_words(kind.key_type)[0]}→{type_words(kind.value_type)[0]}"
        case inspect.StructType():
            return f"[{kind.cls.__name__}](#{kind.cls.__name__.lower()})"
        case inspect.BoolType():
            return "boolean"
        case inspect.NoneType():
            return "null"
        case _:
            return "anything"


def _literals(values: Iterable[Any]) -> str:
    return "`" + ",".join(msgspec.json.encode(value).decode() for value in values) + "`"


def _list_of(item: str) -> str:
    """Return the words for a list: the plural of a plain type, with its bounds."""
    word, *bounds = item.split(" ")
    plain = all(re.match(r"[≥>≤<0-9-]", bound) for bound in bounds) and not item.endswith("?")
    return " ".join([f"{word}s", *bounds]) if plain and word in {"text", "number", "integer", "name"} else f"[{item}]"


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
    "halted_s": "commands typed or written before it begin nothing, but for the sender `halted_by`",
    "heard": "whether anything came since the line was opened; if not, the rest is what was sent",
    "stopped_s": "commands sent before it (monotonic) begin nothing; `stopped_by` is the sender of that stop, if it was one",
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
    common = {shape: field for shape, field in common_fields(messages, 2).items() if field.encode_name in _COMMON}
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
    usual = _usual_ports(known)
    parts += [
        "Ports of these names have the same message everywhere: "
        + ", ".join(f"`{name}` {link}" for name, link in usual.items())
        + ".\n"
    ]
    parts += [_kind_ports(kind, usual) for kind in known]
    parts.append("## Messages\n")
    parts.append(
        "A field is shown with its default; a field without default is required. A type is named where neither default nor "
        "unit shows it; without any of these it is a text. `?`: or null. `A→B`: an object, `A` its keys; `[A]`: a list. *name*: small "
        "letters, digits and underscores, at most 40. *button*: "
        f"{_literals(get_args(Button))}. Several fields in a row share the explanation of the first. These are explained once:\n"
    )
    shown = {field.encode_name: _allowed(field) for field in common.values()}
    parts.append(
        _table(("field", "type", "meaning"), [(f"`{each}`", shown[each], _COMMON[each]) for each in sorted(shown)])
    )
    parts += [_message_section(message, common) for message in messages]
    return "\n".join(parts)


def _ports(kind: Kind) -> Iterator[tuple[str, str, str]]:
    """Yield the ports of a kind: what it does there, the name, and the link to its message."""
    for does, group in _PORTS:
        ports: Mapping[str, type[Struct]] = getattr(kind, group)
        yield from ((does, name, f"{_link(message)}{_reply(kind, name)}") for name, message in ports.items())


def _usual_ports(known: list[Kind]) -> dict[str, str]:
    """Return the ports that several kinds have, all with the same message."""
    ports = [(name, link) for kind in known for _, name, link in _ports(kind)]
    links = {name: {link for other, link in ports if other == name} for name, _ in ports}
    times = Counter(name for name, _ in ports)
    return {name: link for name, link in sorted(set(ports)) if times[name] > 1 and len(links[name]) == 1}


def _kind_ports(kind: Kind, usual: Mapping[str, str]) -> str:
    lines = []
    for does, _ in _PORTS:
        named = [
            f"`{name}`{'' if name in usual else f' {link}'}" for doing, name, link in _ports(kind) if doing == does
        ]
        lines += [f"*{does}* {', '.join(named)}"] if named else []
    return f"### `{kind.name}`\n\n" + "\\\n".join(lines or ["Its settings name its ports."]) + "\n"


def _reply(kind: Kind, name: str) -> str:
    reply = kind.replies.get(name)
    return f"→{_link(reply)}" if reply not in {None, CommandReply} else ""


def _messages(known: Iterable[Kind]) -> list[type[Struct]]:
    named: list[type[Struct]] = [
        message for _, _, takes, gives in _SYSTEM for message in (takes, gives) if message is not None
    ]
    named += [system.Stamp, CommandReply]
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
            "refused. `lbr get PART` prints the settings of a part, `lbr set PART.SETTING VALUE` changes one.\n"
        ),
        (
            "*name*: small letters, digits and underscores, at most 40. *button*: one of a gamepad "
            "([list](topics.md#messages)). `?`: or null. `A→B`: an object, `A` its keys; `[A]`: a list. A setting `device` "
            "names a row of the table `device`, whose type is that of the kind. These settings mean the same in every kind:\n"
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
        "## Faults of emulated devices\n\nUnder a simulating profile the column `settings` of a `device` row describes its "
        "twin, and its faults. The simulated world's command `fault` changes them while it runs. A number 0…1 is how often a "
        "fault happens. Unless a device says otherwise, `unplug`: the cable is out, the device goes on; `silent`: it obeys "
        "without answers; `frozen`: the same values for ever; `garbage`: noise before an answer; `half`: an early end; "
        "`bit_flip`: a wrong bit; `stop_reading`: bytes pile up; `brown_out`: no supply, then a restart.\n"
    )
    twin = {device: row.row for device in own("twins") if (row := twins.find(device)) is not None}
    several = _faults_of_several(each for row in twin.values() for each in nested(row))
    parts += [" ".join(_doc(base).split()) + "\n" for base in several]
    for device, row in twin.items():
        new = [each for each in nested(row) if each not in shown]
        section = [f"### `{device}`\n\n{_doc(row)}\n\n{_faults(row)}"]
        section += [f"#### {each.__name__}\n\n{_doc_with_bases(each, several)}\n\n{_faults(each)}" for each in new]
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
    text = re.sub(r"^Settings of (a row of kind `\w+`|how [\w' ]+|a program)([.;:]) ?", "", _doc(settings))
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
    """Return a twin's fields: its faults have a section of their own, where numbers and lists need no bounds."""
    text = re.sub(r"^`faults` \[\w+\]\(#\w+\),? ?", "", inline_fields(struct)).replace(
        " (how often it happens, 0 never, 1 always)", ""
    )
    text = re.sub(r"=0\.0` 0…1(?=,|\n)", "=0.0`", text.replace("=[]` integers 0…253", "=[]`"))
    return text if text.strip() else ""


# -- console ----------------------------------------------------------------------------------------------------------


def console_page() -> str:
    """Return the reference of the words of the robots that come with lbr."""
    parts = [
        "# Words of the console\n",
        (
            "You find here the lines that the robots of lbr understand, by their capabilities' kinds and their rows. `help` at "
            "the console lists those of a robot.\n"
        ),
        (
            "A line that starts with a slash is split at its slashes; doubled slashes count once. Bare words without an exact "
            "match are looked up in small letters. A word needs the role that is shown, or a higher one. What `executive` does "
            "by itself: "
            + ", ".join(f"`{name}`" for name in sorted(EXECUTIVE_VERBS))
            + f". Reports: {', '.join(f'`{name}`' for name in REPORTS)}.\n"
        ),
        "## Every robot\n",
        "No row may replace one of these, in capital letters or small ones.\n",
        _table(
            ("say", "effect", "role"),
            _by_meaning((row.pattern, row.help, row.role) for row in builtin.WORDS),
        ),
        "A row of the robot may replace these.\n",
        _words([words.as_row(EXECUTIVE, word) for word in words.OF_EVERY_ROBOT], least_roles({})),
        "## By kind\n",
        (
            "Every robot with a capability of the kind understands these; they ask for a command of that capability, whose "
            "[message](topics.md#messages) bounds the fields. A row with the same pattern replaces one.\n"
        ),
    ]
    for named, rows in _words_by_kinds().items():
        parts += [f"### {' and '.join(f'`{name}`' for name in named)}\n"]
        parts += [
            _words(
                [words.as_row(named[0], word) for word in rows],
                least_roles({named[0]: registry.find(named[0], NOWHERE)}),
                asks=len(named) == 1,
            )
        ]
    for name in ROBOTS:
        rows = check(shipped()[0], name)
        named = {row.name: registry.find(row.kind, NOWHERE) for row in rows.capabilities}
        Vocabulary(words.words(rows, named), rows.external_commands, _messages_of(named))  # refuses what cannot be said
        parts += [f"## Robot `{name}`\n", _words(rows.verbs, least_roles(named))] if rows.verbs else []
        commands = [
            (f"`{row.name}`", row.help, _arguments(row), f"`{' '.join(row.argv)}`", row.role, _waits(row))
            for row in rows.external_commands
        ]
        head = ("say", "effect", "arguments", "runs", "role", "the console")
        parts += ["### External commands\n", _table(head, commands)] if commands else []
    return "\n".join(parts)


def _words_by_kinds() -> dict[tuple[str, ...], list[Word]]:
    """Return the words by the kinds that bring them; those that several kinds bring alike stand once."""
    bring: dict[str, list[tuple[str, Word]]] = {}
    for kind in kinds():
        for word in kind.words:
            bring.setdefault(repr(word), []).append((kind.name, word))
    found: dict[tuple[str, ...], list[Word]] = {}
    for several in bring.values():
        found.setdefault(tuple(name for name, _ in several), []).append(several[0][1])
    return found


def _words(rows: Iterable[VerbRow], needed: Mapping[str, Role], *, asks: bool = True) -> str:
    lines = []
    for row in rows:
        target = f"`{row.target if asks else row.target.partition('.')[2]}{_payload(row)}`"
        role = higher(row.role, needed.get(row.target, "view"))
        lines.append((row.pattern, row.help.removeprefix("Simulation: "), target, role))
    return _table(("say", "effect", "asks", "role"), _by_meaning(lines))


def _by_meaning(lines: Iterable[tuple[str, ...]]) -> list[tuple[str, ...]]:
    """Return the lines of a table of words; those that do the same are one line."""
    patterns: dict[tuple[str, ...], list[str]] = {}
    for pattern, *what in lines:
        patterns.setdefault(tuple(what), []).append(f"`{pattern}`")
    return [(", ".join(several), *what) for what, several in patterns.items()]


def _messages_of(known: Mapping[str, Kind]) -> dict[str, type[Struct]]:
    return {f"{name}.{command}": message for name, kind in known.items() for command, message in kind.messages.items()}


def _payload(row: VerbRow) -> str:
    return msgspec.json.encode(row.payload).decode() if row.payload else ""


def _arguments(row: ExternalCommandRow) -> str:
    return ", then ".join(described(one) for one in row.arguments or ()) or "none"


def _waits(row: ExternalCommandRow) -> str:
    return "waits for its end" if row.blocking else f"goes on; `stop {row.name}` ends it"


# -- command line -----------------------------------------------------------------------------------------------------


def cli_page() -> str:
    """Return every command: what it is for, and its own options."""
    common = ((f"`{option}`", meaning) for option, meaning in COMMON_OPTIONS.items())
    parts = [
        "# The command line\n",
        (
            "You find here every command and its options. `lbr COMMAND --help` and `man lbr` explain each option, its "
            "default and its bounds. The help shows, too, which of these a command has:\n"
        ),
        _table(("option", "meaning"), common),
    ]
    parts += map(_command_section, _commands(the_command_line(), "lbr", None))
    return re.sub(r"\n{3,}", "\n\n", "\n".join(parts))


COMMON_OPTIONS = {
    "--robot": "which robot; the only one that runs here if left out",
    "--connect": "reach a robot elsewhere, such as `tls/192.168.1.7:7447`",
    "--token-file": "the file with the token for `--connect`; else it is `LBR_TOKEN`, a saved one, or asked for",
    "--json": "print JSON, for programs",
    "--db": "the database; `$LBR_HOME/robot.db` if left out",
    "--dry-run": "show the effects, and write nothing",
    "--revision": "refuse if the rows have changed since this revision",
}


def _command_section(context: click.Context) -> str:
    """Return a command with its options, and the first sentence of its help; one below another as an item."""
    path = context.command_path
    usage = " ".join(context.command.collect_usage_pieces(context)).removeprefix("[OPTIONS]").strip()
    first = _first_sentence(_one_line((context.command.help or "").split("\n\n")[0]))
    options = " ".join(f"`{option}`" for option in _options(context))
    line = path if isinstance(context.command, click.Group) else f"{path} {usage}".strip()
    if context.parent is not None and context.parent.parent is not None:
        return " ".join(filter(None, [f"- `{line.removeprefix(f'{context.parent.command_path} ')}`", first, options]))
    shown = line.removeprefix(path).strip()
    return f"\n## `{path}`\n\n" + " ".join(filter(None, [f"`{shown}`" if shown else "", first, options])) + "\n"


def _options(context: click.Context) -> Iterator[str]:
    """Yield the options of a command as they are typed, with what they take."""
    for option in context.command.params:
        if (
            isinstance(option, click.Option)
            and not option.hidden
            and option.opts[0] not in {*COMMON_OPTIONS, "-h", "--help"}
        ):
            record = option.get_help_record(context)
            assert record is not None
            yield re.sub(r" (INTEGER|FLOAT)( RANGE)?$", " NUMBER", record[0])


def _first_sentence(text: str) -> str:
    """Return the first sentence; of a long one, its first clause."""
    sentence = re.split(r"(?<=[^.]\.) (?=[A-Z0-9'])", text)[0]
    return sentence if len(sentence.split()) <= MOST_WORDS else re.split(r"[;:] ", sentence)[0].rstrip(".") + "."


MOST_WORDS = 11


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


def _faults_of_several(structs: Iterable[type]) -> list[type]:
    """Return the classes of faults that more than one device has: they are explained once."""
    times = Counter(base for each in dict.fromkeys(structs) for base in each.__mro__[1:] if _are_faults(base))
    return [base for base, count in times.items() if count > 1]


def _are_faults(of: type) -> bool:
    return issubclass(of, faults.Faults) and of is not faults.Faults


def _doc_with_bases(of: type, several: list[type]) -> str:
    """Faults that another device has, too, are told where they are defined."""
    told = [base for base in of.__mro__ if _are_faults(base) and base not in several]
    return "\n\n".join(map(_doc, told or [of]))


def _doc(of: type) -> str:
    paragraphs = (of.__doc__ or "").strip().split("\n\n")
    return "\n\n".join(" ".join(line.strip() for line in paragraph.splitlines()) for paragraph in paragraphs)


def _sentence(text: str) -> str:
    return text[:1].upper() + text[1:] + "."


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
