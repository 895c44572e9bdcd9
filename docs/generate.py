"""Write docs/reference/*.md, and the tables and triggers of robot.db.sql, from rows, kinds, messages, settings and commands.

`python docs/generate.py` writes what has changed; with `--check` it writes nothing and fails if a page is stale. Where tables
have changed, `--step NAME` writes the step, too, that brings an older database along.
"""

import ast
import re
import sqlite3
import sys
import tomllib
from collections.abc import Callable, Iterable, Mapping
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
from lbr.messages.rows import Row
from lbr.messages.system import Role, higher
from lbr.simulation import faults

ROOT = Path(__file__).resolve().parent.parent
PAGES = ROOT / "docs" / "reference"
NOWHERE = Path("/nowhere")
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
        "Every table of a robot database, as `robot.db.sql` makes them. How to edit them is in [the rows](../rows.md).\n",
    ]
    return "\n".join(parts + [_table_section(table) for table in tables().tables.values()])


def _table_section(table: Table) -> str:
    columns = [
        (f"`{one.name}`", str(one.type).lower(), _default(one), schema.comment(one), one.info.get("allowed", ""))
        for one in table.columns
    ]
    over = "; ".join(f"`{rule}`" for rule in schema.over_all(table))
    head = ("column", "type", "default", "meaning", "allowed")
    return f"## {table.name}\n\n{table.comment}\n\n{_table(head, columns)}\nOver all columns: {over}.\n{_users(table.name)}"


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
        "Every refusal, result, loss and event that tells a reason carries one of these as `code` beside its sentence; the "
        "result of a console line, whose `code` is the exit code, as `reason_code`. Where two things are told, `cause` is "
        "the second: of `dead_lease`, how that lease ended.\n\n"
        "A program reads the code, a person the sentence. A code keeps its meaning for ever, and new ones are added: treat "
        "one that you do not know like `refused`, or like `failed` if it tells how something ended.\n\n"
        + _table(("code", "meaning"), rows)
        + "\n## What the executive tells of\n\n"
        "By the kinds of its own events. Those of a process (`degraded`, `crashed`, `hung`, `failed`, `need_lost`) have the code "
        "that the process told, or `failed`, `timeout` and `unreachable`. In the status, each capability has the `code` of its "
        "`reason` and the `end_code` of its `last_end`, and `problem_codes` are those of the `problems`.\n\n"
        + _table(
            ("event", "code"),
            [(f"`{kind}`", f"`{code}`" if code else "none: it tells no why") for kind, code in CODES.items()],
        )
    )


# -- structs ----------------------------------------------------------------------------------------------------------


def struct_table(struct: type[Struct]) -> str:
    """Return a struct's fields as a table: name, type with bounds, default, meaning."""
    info = inspect.type_info(struct)
    assert isinstance(info, inspect.StructType)
    rows = []
    for field in info.fields:
        words, meaning = type_words(field.type)
        rows.append((f"`{field.encode_name}`", words, _field_default(field), meaning))
    return _table(("field", "type", "default", "meaning"), rows) if rows else "No fields.\n"


def type_words(kind: inspect.Type) -> tuple[str, str]:
    """Return a type in words, with its bounds, and its description."""
    if isinstance(kind, inspect.Metadata):
        words, _ = type_words(kind.type)
        return words, str((kind.extra_json_schema or {}).get("description", ""))
    if isinstance(kind, inspect.UnionType):
        parts = [type_words(one) for one in kind.types]
        return " or ".join(words for words, _ in parts), " ".join(text for _, text in parts if text)
    return _plain_words(kind), ""


def _plain_words(kind: inspect.Type) -> str:  # noqa: PLR0911 - a table of cases
    match kind:
        case inspect.FloatType() | inspect.IntType():
            return " ".join(["whole number" if isinstance(kind, inspect.IntType) else "number", *_bounds(kind)])
        case inspect.StrType():
            longest = f" of {kind.max_length} characters at most" if kind.max_length else ""
            return f"text{longest}" + (f" like `{_escape(kind.pattern)}`" if kind.pattern else "")
        case inspect.LiteralType():
            return ", ".join(f"`{msgspec.json.encode(value).decode()}`" for value in kind.values)
        case inspect.VarTupleType() | inspect.ListType():
            return f"list of {type_words(kind.item_type)[0]}"
        case inspect.DictType():
            return f"object: {type_words(kind.key_type)[0]} to {type_words(kind.value_type)[0]}"
        case inspect.StructType():
            return f"`{kind.cls.__name__}`"
        case inspect.BoolType():
            return "true or false"
        case inspect.NoneType():
            return "null"
        case _:
            return "anything"


def _bounds(kind: inspect.FloatType | inspect.IntType) -> list[str]:
    low = f"≥ {kind.ge:g}" if kind.ge is not None else f"> {kind.gt:g}" if kind.gt is not None else ""
    high = f"≤ {kind.le:g}" if kind.le is not None else f"< {kind.lt:g}" if kind.lt is not None else ""
    return [", ".join(filter(None, [low, high]))] if low or high else []


def _field_default(field: inspect.Field) -> str:
    if field.required:
        return "required"
    value = field.default if field.default_factory is msgspec.NODEFAULT else field.default_factory()
    shown = msgspec.json.encode(value).decode()
    return f"`{shown}`" if len(shown) <= 60 else "see the code"


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


def topics_page(known: list[Kind]) -> str:
    """Return the reference of keys and messages."""
    parts = [
        "# Topics and messages\n",
        (
            "Keys are `<robot>/<capability>/<name>`, and the middle part is the row's name, not the kind's. Payloads are "
            "JSON. Units are the suffixes of the field names: `_m` metres, `_cm` centimetres, `_deg` degrees, `_rad` "
            "radians, `_s` seconds, `_v` volts, `_a` amperes, `_mps` metres a second, `_rps` radians a second, `_c` "
            "degrees Celsius. How to use them is in [the bus](../bus.md).\n"
        ),
        "## System keys\n",
        _table(
            ("key", "how", "takes", "gives"),
            [(f"`{key}`", how, _link(takes), _link(gives)) for key, how, takes, gives in _SYSTEM],
        ),
        "## By kind\n",
    ]
    parts += [_kind_ports(kind) for kind in known]
    parts.append("## Messages\n")
    parts += [_message_section(message) for message in _messages(known)]
    return "\n".join(parts)


def _kind_ports(kind: Kind) -> str:
    rows = []
    for does, group in _PORTS:
        ports: Mapping[str, type[Struct]] = getattr(kind, group)
        for name, message in ports.items():
            rows.append((does, f"`{name}`", _link(message), _link(kind.replies.get(name))))
    table = _table(("", "name", "message", "reply"), rows) if rows else "Its ports are named in its settings.\n"
    return f"### Kind `{kind.name}`\n\n{_sentence(kind.summary)}\n\n{table}"


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


def _message_section(message: type[Struct]) -> str:
    return f"### {message.__name__}\n\n{_doc(message)}\n\n{struct_table(message)}"


def _link(message: type[Struct] | None) -> str:
    return f"[{message.__name__}](#{message.__name__.lower()})" if message is not None else ""


# -- settings ---------------------------------------------------------------------------------------------------------


def settings_page(known: list[Kind]) -> str:
    """Return the reference of what rows and launch profiles may set."""
    parts = [
        "# Settings\n",
        "What the column `settings` of a `capability` row may hold, by the row's kind. Unknown keys are refused.\n",
    ]
    for kind in known:
        parts.append(f"## Kind `{kind.name}`\n\n{_sentence(kind.summary)}\n")
        if kind.device:
            parts.append(f"Drives a device row of type `{kind.device_type}`, which its setting `device` names.\n")
        parts.append(f"{_doc(kind.settings)}\n\n{struct_table(kind.settings)}")
        parts += [f"### `{one.__name__}`\n\n{_doc(one)}\n\n{struct_table(one)}" for one in nested(kind.settings)]
    parts.append(
        "## Faults of emulated devices\n\nUnder a simulating profile the column `settings` of a `device` row says how "
        "its twin is built, and what is wrong with it; the command `fault` of the simulated world changes the faults "
        "while it runs. Any device can be unplugged.\n"
    )
    for device in own("twins"):
        found = twins.find(device)
        assert found is not None
        row = found.row
        parts.append(f"### Type `{device}`\n\n{_doc(row)}\n\n{struct_table(row)}")
        parts += [f"#### `{one.__name__}`\n\n{_doc_with_bases(one)}\n\n{struct_table(one)}" for one in nested(row)]
    parts.append(f"## Launch profiles\n\nA TOML file. {_doc(Profile)}\n\n{struct_table(Profile)}")
    return "\n".join(parts)


# -- console ----------------------------------------------------------------------------------------------------------


def console_page() -> str:
    """Return the reference of what can be said to the robots that come with lbr."""
    parts = [
        "# Words of the console\n",
        (
            "What can be said to the robots that come with lbr: the words that their capabilities' kinds bring, and the rows "
            "of the tables `verb` and `external_command`. A line that starts with a "
            "slash is taken apart at its slashes; doubled slashes count once. Bare words that have no exact match are "
            "looked up in small letters. What `executive` does by itself: "
            + ", ".join(f"`{name}`" for name in sorted(EXECUTIVE_VERBS))
            + f". Reports: {', '.join(f'`{name}`' for name in REPORTS)}.\n"
        ),
        "A word needs the role that its row or its kind names, or the one that the command needs, if that is higher.\n",
        "## Every robot\n",
        "These are there whatever the rows say, and no row may take one of them, in capital letters or small ones.\n",
        _table(
            ("say", "what it does", "least role"), [(f"`{row.pattern}`", row.help, row.role) for row in builtin.WORDS]
        ),
        "These are there, too, unless a row of the robot's says otherwise.\n",
        _words([words.as_row(EXECUTIVE, word) for word in words.OF_EVERY_ROBOT], least_roles({})),
        "## By kind\n",
        (
            "Every robot with a capability of the kind understands these; they ask for a command of that capability. A row "
            "of the same pattern takes the place of one.\n"
        ),
    ]
    for kind in kinds():
        if kind.words:
            rows = [words.as_row(kind.name, word) for word in kind.words]
            parts += [f"### Kind `{kind.name}`\n", _words(rows, least_roles({kind.name: kind}))]
            parts.append(_table(("field", "allowed"), _fields(rows, _messages_of({kind.name: kind}))))
    for name in ROBOTS:
        rows = check(shipped()[0], name)
        named = {row.name: registry.find(row.kind, NOWHERE) for row in rows.capabilities}
        Vocabulary(words.words(rows, named), rows.external_commands, _messages_of(named))  # refuses what cannot be said
        parts += [f"## Robot `{name}`\n", "Besides what its kinds bring:\n", _words(rows.verbs, least_roles(named))]
        fields = _fields(rows.verbs, _messages_of(named))
        parts += [_table(("field", "allowed"), fields)] if fields else []
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
            f"`{row.target}`",
            higher(row.role, needed.get(row.target, "view")),
            _payload(row),
        )
        for row in rows
    ]
    return _table(("say", "what it does", "asks", "least role", "fixed fields"), said) if said else "Nothing.\n"


def _messages_of(known: Mapping[str, Kind]) -> dict[str, type[Struct]]:
    return {f"{name}.{command}": message for name, kind in known.items() for command, message in kind.messages.items()}


def _fields(rows: Iterable[VerbRow], targets: Mapping[str, type[Struct]]) -> list[tuple[str, str]]:
    allowed: dict[str, str] = {}
    for row in rows:
        for name in re.findall(r"\{([a-z_]+)", row.pattern):
            allowed[name] = Message(targets.get(row.target)).field(name).allowed
    return [(f"`{name}`", words) for name, words in allowed.items()]


def _payload(row: VerbRow) -> str:
    return f"`{msgspec.json.encode(row.payload).decode()}`" if row.payload else ""


def _arguments(row: ExternalCommandRow) -> str:
    return ", then ".join(told(one) for one in row.arguments or ()) or "none"


def _waits(row: ExternalCommandRow) -> str:
    return "waits for its end" if row.blocking else f"goes on; `stop {row.name}` ends it"


# -- command line -----------------------------------------------------------------------------------------------------


def cli_page() -> str:
    """Return every command's help."""
    parts = ["# The command line\n", "What `--help` says, for every command.\n"]
    parts += [f"## `{path}`\n\n```text\n{text}\n```\n" for path, text in _helps(the_command_line(), "lbr", None)]
    return "\n".join(parts)


def the_command_line() -> click.Group:
    """Return lbr's own commands."""
    from lbr.cli import Commands, cli  # noqa: PLC0415 - only these pages need it

    Commands.others = False
    return cli


def _helps(command: click.Command, name: str, parent: click.Context | None) -> Iterable[tuple[str, str]]:
    settings = {"terminal_width": 100, "max_content_width": 100, **command.context_settings}
    with click.Context(command, info_name=name, parent=parent, **settings) as context:
        yield context.command_path, "\n".join(line.rstrip() for line in command.get_help(context).splitlines())
        if isinstance(command, click.Group):
            for child in command.list_commands(context):
                found = command.get_command(context, child)
                if found is not None and not found.hidden:
                    yield from _helps(found, child, context)


def man_page() -> str:
    """Return the same as a page of the manual, in the language of man (7)."""
    parts = ['.\\" Written by docs/generate.py; do not edit.', '.TH LBR 1 "" lbr "User commands"', ".SH NAME"]
    parts.append(r"lbr \- run a robot that is rows in a database, and talk to it")
    for path, text in _helps(the_command_line(), "lbr", None):
        parts += [f'.SH "{path.upper()}"', ".nf", *(_roff(line) for line in text.splitlines()), ".fi"]
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
    return "".join("| " + " | ".join(_cell(cell) for cell in line) + " |\n" for line in lines)


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
