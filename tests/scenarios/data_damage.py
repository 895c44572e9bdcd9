"""D4: a database cut, flipped, without its log, read-only; refused in one clear line, or the very same rows."""

import random
import re
import sqlite3
import tempfile
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path

from msgspec import Struct

from lbr.database import copies
from lbr.database.restore import restore
from lbr.database.store import Database, create
from tests.scenarios.data_check import checked, content
from tests.support.figures import Results

STEP_BYTES = 512
SAYS_WHAT_TO_DO = re.compile(
    r"`lbr db (restore|init)`|`chmod |name another|any edit approves|install a newer lbr|, \w+: "
)


class Victim(Struct, frozen=True):
    """A database whose rows ran and were copied; then a log with one more edit. `good` is all it may ever be read as."""

    path: Path
    whole: bytes
    log: bytes
    good: tuple[str, ...]


def damages(results: Results, n: int, dice: random.Random) -> None:
    """D4: `n` flips of the file, cuts at as many of its 512-byte steps, a tenth as many of its log, single cases."""
    with _victim() as victim:
        steps = range(0, len(victim.whole), STEP_BYTES)
        for size in sorted(dice.sample(steps, min(n, len(steps)))):
            _try(results, victim, victim.whole[:size], b"", f"cut to {size} bytes")
        for _ in range(n):
            at, bit = dice.randrange(len(victim.whole)), dice.randrange(8)
            _try(results, victim, _flipped(victim.whole, at, bit), b"", f"bit {bit} of byte {at} flipped")
        for _ in range(max(1, n // 10)):
            at, bit = dice.randrange(len(victim.log)), dice.randrange(8)
            _try(results, victim, victim.whole, _flipped(victim.log, at, bit), f"bit {bit} of byte {at} of the log")
            _try(results, victim, victim.whole, victim.log[:at], f"log cut to {at} bytes")
        _restored(results, victim)
        _without_log(results, victim)
        _read_only(results, victim)


@contextmanager
def _victim() -> Iterator[Victim]:
    with tempfile.TemporaryDirectory(prefix="lbr-") as place:
        path = Path(place) / "robot.db"
        create(path)
        _edit(path, "somebody")
        with Database.open(path) as database:
            rows = database.load("lbr")
            database.adopt(rows)
        copies.keep(path, rows.digest)
        whole, old = path.read_bytes(), content(path)
        with closing(sqlite3.connect(path, isolation_level=None)) as connection:
            connection.execute("UPDATE robot SET description = 'the newest edit'")
            log, new = _wal(path).read_bytes(), content(path)
        yield Victim(path, whole, log, (old, new))


def _try(results: Results, victim: Victim, data: bytes, log: bytes, how: str) -> None:
    """Put damaged bytes in the database's place, and judge what is said of them."""
    _place(victim.path, data, log)
    done = checked(victim.path)
    wrong = done.complaints(how)
    if done.code == 0 and content(victim.path) not in victim.good:
        wrong.append(f"{how}: accepted, but the rows are others")
    if done.code != 0 and not SAYS_WHAT_TO_DO.search(done.text):
        wrong.append(f"{how}: {done.text[:300]!r} does not say what to do")
    if done.code != 0 and not log and victim.path.read_bytes() != data:
        wrong.append(f"{how}: a file that was refused is another now")
    results.check("D4", wrong)


def _restored(results: Results, victim: Victim) -> None:
    for size in (0, 100, len(victim.whole) // 2):
        _place(victim.path, victim.whole[:size], b"")
        _, aside = restore(victim.path)
        wrong = [] if content(victim.path) == victim.good[0] else [f"restored from a cut at {size}: other rows"]
        wrong += [] if aside and aside.read_bytes() == victim.whole[:size] else ["the damaged file is not kept"]
        wrong += [] if checked(victim.path).code == 0 else ["the restored database is refused"]
        results.check("D4 restore", wrong)


def _without_log(results: Results, victim: Victim) -> None:
    """An edit that ran, and was copied, was in the log alone; the log is gone."""
    _place(victim.path, victim.whole, victim.log)
    with Database.open(victim.path) as database:
        digest = database.load("lbr").digest
    copies.keep(victim.path, digest)
    _place(victim.path, victim.whole, b"")
    done = checked(victim.path)
    told = done.code == 2 and "the newest edits are missing" in done.text
    results.check("D4", [] if told else [f"without its log: {done.code} {done.text!r}"])
    restore(victim.path)
    wrong = [] if content(victim.path) == victim.good[1] else ["restored after a lost log: other rows"]
    results.check("D4 restore", wrong)


def _read_only(results: Results, victim: Victim) -> None:
    _place(victim.path, victim.whole, b"")
    victim.path.chmod(0o400)
    done = checked(victim.path)
    told = done.code == 2 and "read-only" in done.text
    results.check("D4", [] if told else [f"read-only: {done.code} {done.text!r}"])


def _place(path: Path, data: bytes, log: bytes) -> None:
    for name in (path, _wal(path), path.with_name(f"{path.name}-shm")):
        name.unlink(missing_ok=True)
    path.touch(mode=0o600)
    path.write_bytes(data)
    if log:
        _wal(path).write_bytes(log)


def _edit(path: Path, owner: str) -> None:
    with closing(sqlite3.connect(path, isolation_level=None)) as connection:
        connection.execute("UPDATE robot SET owner = ?", (owner,))


def _wal(path: Path) -> Path:
    return path.with_name(f"{path.name}-wal")


def _flipped(data: bytes, at: int, bit: int) -> bytes:
    return data[:at] + bytes([data[at] ^ (1 << bit)]) + data[at + 1 :]
