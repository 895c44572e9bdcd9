"""D1: writers of the database killed at any moment; what was acknowledged is there, and the file is whole."""

import random
import sqlite3
import subprocess
import sys
import tempfile
import time
from contextlib import closing
from pathlib import Path

from lbr.database.store import Database, create
from tests.support import programs
from tests.support.figures import Results

LONGEST_S = 0.03
OWN_SHARE = 0.1
"""Every tenth writer is lbr itself, because it takes so much longer to start."""

PLAIN = """
import sqlite3, sys
c = sqlite3.connect(sys.argv[1], isolation_level=None)
c.execute("PRAGMA foreign_keys = ON")
c.execute("PRAGMA busy_timeout = 2000")
n = int(sys.argv[2])
while True:
    n += 1
    c.execute("BEGIN IMMEDIATE")
    c.execute("UPDATE robot SET owner = ?", (str(n),))
    c.execute("INSERT OR REPLACE INTO phrase (name, language, text) VALUES ('count', 'en', ?)", (str(n),))
    c.execute("COMMIT")
    sys.stdout.write(f"{n}\\n")
    sys.stdout.flush()
"""

OWN = """
import contextlib, pathlib, sys
from lbr.database.rows import AuditRow, TokenRow
from lbr.database.store import Database
from lbr.errors import InputError
n = int(sys.argv[2])
with Database.open(pathlib.Path(sys.argv[1])) as database:
    while True:
        n += 1
        if n % 7 == 0:
            with contextlib.suppress(InputError):  # written before a kill that came before the rest
                database.add_token(TokenRow(name=f"t{n}", role="view", hash="h" * 64, created_at="2026-01-01T00:00:00Z"))
        database.append_events((), (AuditRow(wall_ns=1, kind="count", subject="", source="bench", text=str(n)),))
        database.set_estop("lbr", engaged=bool(n % 2), reason=str(n))
        sys.stdout.write(f"{n}\\n")
        sys.stdout.flush()
"""


def kills(results: Results, n: int, dice: random.Random) -> None:
    """D1: `n` kills of a plain SQLite client, and some of lbr's own writing."""
    with tempfile.TemporaryDirectory(prefix="lbr-") as place:
        path = Path(place) / "robot.db"
        create(path)
        plain, own = 0, 0
        for _ in range(n):
            plain = _killed(PLAIN, path, plain, dice)
            results.check("D1", [*_faults(path), *_less(_plain_count(path), plain, "edit")])
            plain = _plain_count(path)
        for _ in range(max(1, round(n * OWN_SHARE))):
            own = _killed(OWN, path, own, dice)
            results.check("D1", [*_faults(path), *_own_faults(path, own)])
            own = _own_count(path)


def _killed(program: str, path: Path, since: int, dice: random.Random) -> int:
    """Let a writer begin, kill it a moment later; return what it acknowledged last."""
    with programs.start(
        [sys.executable, "-c", program, str(path), str(since)], stdout=subprocess.PIPE, text=True
    ) as writer:
        assert writer.stdout is not None
        first = writer.stdout.readline()
        assert first, "the writer ended by itself"
        time.sleep(dice.uniform(0.0, LONGEST_S))
        writer.kill()
        said = [first, *writer.stdout.read().splitlines(keepends=True)]
    return int([line for line in said if line.endswith("\n")][-1])


def _faults(path: Path) -> list[str]:
    with closing(sqlite3.connect(path)) as connection:
        broken = [text for (text,) in connection.execute("PRAGMA integrity_check") if text != "ok"]
        dangling = connection.execute("PRAGMA foreign_key_check").fetchall()
    return [*broken, *(f"dangling: {row}" for row in dangling)]


def _plain_count(path: Path) -> int:
    with closing(sqlite3.connect(path)) as connection:
        (owner,) = connection.execute("SELECT owner FROM robot").fetchone()
        spoken = connection.execute("SELECT text FROM phrase WHERE name = 'count'").fetchone()
    assert spoken is None or spoken[0] == owner, f"half a transaction: {owner} and {spoken}"
    return int(owner or 0)


def _own_count(path: Path) -> int:
    with Database.open(path) as database:
        return int(database.audit(1)[-1].text)


def _own_faults(path: Path, acknowledged: int) -> list[str]:
    with Database.open(path) as database:
        robot, names = database.load("lbr").robot, {token.name for token in database.tokens()}
        trail = database.audit_fault()
        counted = int(database.audit(1)[-1].text)
    wanted = {f"t{n}" for n in range(7, acknowledged + 1, 7)}
    return [
        *([trail] if trail else []),
        *_less(counted, acknowledged, "audit entry"),
        *_less(int(robot.estop_reason or 0), acknowledged, "latch"),
        *(f"token {name} is lost" for name in wanted - names),
    ]


def _less(found: int, acknowledged: int, what: str) -> list[str]:
    return [] if found >= acknowledged else [f"{what} {acknowledged} was acknowledged, {found} is there"]
