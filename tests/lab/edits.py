"""Edits of rows and of the emergency stop's latch, one after the other, each told once it is written; and whether all are there.

In the machine `python -m tests.lab.edits` makes them; outside `damage` looks at what the disk has after its power was cut.
"""

import os
import sqlite3
from contextlib import closing
from pathlib import Path

from lbr.database.store import Database
from lbr.executive.service.latch import Latch

HOME = Path("/var/lib/lbr")
ROBOT = "lbr"
LATCH = f"run/{ROBOT}.estop"
FILES = ("robot.db", "robot.db-wal", LATCH)
ENGAGES, RELEASES, TURN = 3, 8, 10
"""Of each ten edits the fourth comes with a stop, the ninth with its release."""


def main() -> None:
    """Edit until the power goes."""
    os.umask(0o077)
    path = HOME / "robot.db"
    (HOME / LATCH).parent.mkdir(exist_ok=True)
    latch = Latch(HOME / LATCH, Database.open(path), ROBOT, lambda: None)
    with closing(sqlite3.connect(path, isolation_level=None, timeout=10.0)) as client:
        for number in range(1, 1_000_000):
            client.execute("UPDATE capability SET help = ? WHERE robot = ? AND name = 'motors'", (str(number), ROBOT))
            if number % TURN in {ENGAGES, RELEASES}:
                latch.persist(number % TURN == ENGAGES, f"edit {number}")
            print(number, flush=True)


def damage(folder: Path, told: int) -> str:
    """Return what is lost or broken in the files of a folder after edit `told` was told as written, or nothing."""
    with closing(sqlite3.connect(folder / "robot.db")) as database:
        (said,) = database.execute("PRAGMA integrity_check").fetchone()
        if said != "ok":
            return str(said)
        (help_,) = database.execute("SELECT help FROM capability WHERE name = 'motors'").fetchone()
        (engaged,) = database.execute("SELECT estop_engaged FROM robot WHERE name = ?", (ROBOT,)).fetchone()
    reached = int(help_) if help_.isdigit() else 0
    if reached < told:
        return f"edit {told} was told as written, the disk has {reached}"
    latched = bool(engaged) or (folder / Path(LATCH).name).exists()
    if ENGAGES < reached % TURN < RELEASES and not latched:
        return f"edit {reached} is there, and the stop before it is lost"
    if not ENGAGES <= reached % TURN <= RELEASES and latched:
        return f"edit {reached} is there, and the release before it is lost"
    return ""


if __name__ == "__main__":
    main()
