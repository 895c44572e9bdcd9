"""D2: databases with values, rows and tables that nobody should have written; refused by name, or as meant."""

import math
import random
import re
import sqlite3
import tempfile
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

from lbr.database.store import create
from tests.scenarios.data_check import TABLES, Checked, checked
from tests.support.figures import Results

Value = Any

HOSTILE: tuple[Value, ...] = (
    None, -1, 0, 1, 2, 65, 2**63 - 1, -(2**63), 0.5, 1e308, math.inf, -math.inf, b"", b"\xff\xfe", b"motors",
    "", " ", "0", "1", "x", "yes", "motors", "m\u043etors", "Motors", "motors ", "motors\n", "os.system", "../../etc",
    "'; DROP TABLE robot; --", "a\0b", "\U0001f600", "\u202eevil", "x" * 41, "x" * 1_000_000, "\x1b[31mred",
    "{}", "[]", "null", "true", "1e999", '{"a": NaN}', '{"a": 1, "a": 2}', "[" * 50_000, '{"device": "nowhere"}',
    '{"max_power": 2}', '{"max_power": "much"}', '{"no_such": 1}', '["nowhere"]', "[1]", '["motors", "motors"]',
    "drive.setpoint", "nowhere.setpoint", "drive.", ".", "/r/{power}", "/r/{power}/{power}", "/r", "r", "/x/{a...}/{b}",
    "nobody", "admin", "root", "never", "always", "on-failure", "en", "EN", "roboteq", "no_such_kind",
)  # fmt: skip


def _text(value: Value) -> bool:
    return isinstance(value, str) and "\0" not in value and len(value) <= 100_000


def _flag(value: Value) -> bool:
    return isinstance(value, int) and value in (0, 1)


def _never(_value: Value) -> bool:
    return False


def _full(pattern: str) -> Callable[[Value], bool]:
    return lambda value: isinstance(value, str) and re.fullmatch(pattern, value) is not None


def _one_of(*allowed: Value) -> Callable[[Value], bool]:
    return lambda value: value in allowed and not isinstance(value, float)


def _positive(value: Value) -> bool:
    return value is None or (isinstance(value, int | float) and 0 < value <= 1_000_000)


NAME = r"[a-z][a-z0-9_]{0,39}"
LEGAL: dict[tuple[str, str], Callable[[Value], bool]] = {
    **{("robot", name): _text for name in ("model", "description", "owner", "estop_reason")},
    **{("robot", name): lambda v: v is None or _text(v) for name in ("last_start", "last_shutdown")},
    ("robot", "estop_engaged"): _flag,
    ("robot", "listen"): _one_of("[]"),
    ("capability", "enabled"): _flag,
    ("capability", "settings"): _one_of("{}"),
    ("capability", "restart"): _one_of("never", "on-failure", "always"),
    ("capability", "needs"): _one_of("[]", '["motors", "motors"]'),
    ("capability", "help"): _text,
    ("capability", "process"): _full(NAME),
    ("channel", "rate_hz"): _positive,
    ("channel", "history"): lambda v: isinstance(v, int) and 1 <= v <= 64,
    ("channel", "enabled"): _flag,
    ("device", "address"): lambda v: _text(v) and v.isprintable() and v.strip() != "" and len(v) <= 500,
    ("device", "settings"): _one_of("{}"),
    ("verb", "payload"): _one_of(None, "{}"),
    ("verb", "role"): _one_of("view", "operate", "admin"),
    ("verb", "help"): _text,
    ("external_command", "name"): _full(NAME),
    ("external_command", "argv"): _one_of('["nowhere"]', '["motors", "motors"]'),
    ("external_command", "blocking"): _flag,
    ("external_command", "enabled"): _flag,
    ("external_command", "help"): _text,
    ("phrase", "name"): _full(NAME),
    ("phrase", "language"): _full(r"[a-z]{2}[a-z0-9-]{0,18}"),
    ("phrase", "text"): lambda v: _text(v) and v.strip() != "",
    ("calibration", "name"): _full(NAME),
    ("calibration", "value"): lambda v: isinstance(v, int | float) and math.isfinite(v),
    ("calibration", "measured_at"): _text,
}
"""What a column may be changed to, by another reading of robot.db.sql than lbr's own; for the rest, to nothing."""

UNREFERENCED: dict[tuple[str, str, Value], tuple[str, ...]] = {
    ("capability", "name", "lan"): (
        "x",
        "r",
        "yes",
        "nobody",
        "admin",
        "root",
        "never",
        "always",
        "en",
        "null",
        "true",
    ),
    ("verb", "pattern", "/r/{power}/{angle_deg}"): ("/r/{power}",),
}
"""And what single rows may be changed to, because nothing refers to them and the rest has defaults."""

STRUCTURAL: tuple[tuple[str, str], ...] = (
    ("UPDATE capability SET needs = '[\"drive\"]' WHERE name = 'motors'", "capability"),
    ("UPDATE capability SET needs = '[\"motors\"]' WHERE name = 'motors'", "capability"),
    ("DELETE FROM robot", "robot"),
    ("DELETE FROM device WHERE name = 'motor_controller'", "capability"),
    ("DELETE FROM capability WHERE name = 'motors'", "channel"),
    ("DELETE FROM capability WHERE name = 'drive'", "verb"),
    ("DELETE FROM channel WHERE target = 'motors.setpoint'", ""),
    ("DROP TABLE verb", "verb"),
    ("DROP TABLE phrase", "phrase"),
    ("DROP TABLE audit", "audit"),
    ("DROP TABLE revision", "revision"),
    ("ALTER TABLE device ADD COLUMN colour TEXT", "device"),
    ("ALTER TABLE phrase RENAME COLUMN text TO words", "phrase"),
    ("ALTER TABLE joint RENAME TO joints", ""),
    ("UPDATE alembic_version SET version_num = '9999'", "schema"),
    ("DELETE FROM alembic_version", "schema"),
    ("PRAGMA application_id = 7", ""),
    ("INSERT INTO channel (robot, source, target) VALUES ('lbr', 'drive.setpoint', 'ranges.setpoint')", "channel"),
    ("INSERT INTO channel (robot, source, target) VALUES ('lbr', 'ranges.readings', 'motors.setpoint')", "channel"),
    ("INSERT INTO channel (robot, source, target) VALUES ('nobody', 'ranges.readings', 'drive.ranges')", "channel"),
    ("INSERT INTO capability (robot, name, kind) VALUES ('lbr', 'second', 'roboteq')", "capability"),
)
"""Edits of more than a value, and what the refusal must name; nothing: it may be accepted."""


def mutations(results: Results, n: int, dice: random.Random) -> None:
    """D2: `n` mutated databases, one in twenty of them by its structure."""
    with tempfile.TemporaryDirectory(prefix="lbr-") as place:
        path = Path(place) / "robot.db"
        loose = _loose(path)
        for number in range(n):
            path.write_bytes(loose)
            if number % 20 == 0:
                _structure(results, path, *STRUCTURAL[number // 20 % len(STRUCTURAL)])
            else:
                _value(results, path, dice)


def _loose(path: Path) -> bytes:
    """Return the shipped database with columns that take any value, so that even this can be tried."""
    create(path)
    with closing(sqlite3.connect(path, isolation_level=None)) as connection:
        connection.execute("PRAGMA journal_mode = DELETE")
        connection.execute(
            "INSERT INTO calibration (robot, device, name, value) VALUES ('lbr', 'range_board', 'offset_cm', 1.5)"
        )
        connection.execute("PRAGMA writable_schema = ON")
        for table in TABLES:
            (sql,) = connection.execute("SELECT sql FROM sqlite_schema WHERE name = ?", (table,)).fetchone()
            loose = re.sub(r"\b(TEXT|REAL|INTEGER)\b( +NOT NULL)?", "", sql).replace(") STRICT", ")")
            connection.execute("UPDATE sqlite_schema SET sql = ? WHERE name = ?", (loose, table))
    return path.read_bytes()


def _value(results: Results, path: Path, dice: random.Random) -> None:
    table = dice.choice(TABLES)
    value = dice.choice(HOSTILE)
    with closing(_open(path)) as connection:
        columns = [name for _, name, *_ in connection.execute(f"PRAGMA table_info({table})")]
        column = dice.choice(columns)
        rows = connection.execute(f"SELECT rowid, {column} FROM {table}").fetchall()
        rowid, before = dice.choice(rows)
        try:
            connection.execute(f"UPDATE {table} SET {column} = ? WHERE rowid = ?", (value, rowid))
        except sqlite3.Error:  # a doubled key
            return
    done = checked(path)
    how = f"{table}.{column} = {str(value)[:40]!r}"
    wrong = done.complaints(how)
    same = value == before and type(value) is type(before)
    legal = value in UNREFERENCED.get((table, column, before), ()) or LEGAL.get((table, column), _never)(value)
    if done.code == 0 and not same and not legal:
        wrong.append(f"{how} (was {str(before)[:60]!r}) is accepted")
    if done.code == 2 and not _named(done, table, column):
        wrong.append(f"{how}: the refusal does not name it: {done.text[:300]!r}")
    _judge(results, done, wrong)


def _structure(results: Results, path: Path, statement: str, named: str) -> None:
    with closing(_open(path)) as connection:
        connection.execute(statement)
    done = checked(path)
    wrong = done.complaints(statement)
    if named and (done.code != 2 or named not in done.text):
        wrong.append(f"{statement}: {done.code} {done.text[:300]!r}")
    _judge(results, done, wrong)


def _judge(results: Results, done: Checked, wrong: list[str]) -> None:
    results.sample("D2 time", done.took_ms)
    results.check("D2", wrong)


def _named(done: Checked, table: str, column: str) -> bool:
    """Say whether a refusal names table and column, or the row's table where its key was what changed."""
    told = any(f"{table} " in line and f", {column}: " in line for line in done.text.splitlines())
    return told or column in {"robot", "name", "kind", "device", "type", "source", "target", "word", "pattern"}


def _open(path: Path) -> sqlite3.Connection:
    connection = sqlite3.connect(path, isolation_level=None)
    connection.execute("PRAGMA ignore_check_constraints = ON")
    connection.execute("PRAGMA foreign_keys = OFF")
    return connection
