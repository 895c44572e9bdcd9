"""What `lbr db check` says of a database, and what its rows are by plain SQLite; without a process for each look."""

import io
import sqlite3
import time
from contextlib import closing, redirect_stderr, redirect_stdout
from pathlib import Path

from msgspec import Struct

from lbr import cli

TABLES = ("robot", "capability", "channel", "device", "verb", "external_command", "phrase", "calibration")
WRITTEN_BY_LBR = ("last_start", "last_shutdown", "estop_engaged", "estop_reason")
LONGEST_LINE = 1200


class Checked(Struct, frozen=True):
    """The exit code, what stands on standard error, and how long it took."""

    code: int
    text: str
    took_ms: float

    def complaints(self, how: str) -> list[str]:
        """Return what no answer may be, whatever is in the file."""
        lines = self.text.splitlines()
        wrong = [
            (self.code not in {0, 2}, f"exit code {self.code}"),
            (self.code == 2 and not lines, "refused without a word"),
            ("Traceback" in self.text, "a traceback"),
            (any(len(line) > LONGEST_LINE or not line.isprintable() for line in lines), "a line that cannot be shown"),
        ]
        return [f"{how}: {what}: {self.text[:300]!r}" for is_so, what in wrong if is_so]


def checked(path: Path) -> Checked:
    """Run `lbr db check` in this process; an exception that gets out counts as a traceback."""
    errors, began = io.StringIO(), time.monotonic()
    with redirect_stderr(errors), redirect_stdout(io.StringIO()):
        try:
            code = cli.main(["db", "check", "--db", str(path)])
        except Exception as err:  # noqa: BLE001 - what got out is the finding
            code = -1
            errors.write(f"Traceback: {type(err).__name__}: {err}")
    return Checked(code, errors.getvalue(), (time.monotonic() - began) * 1000)


def content(path: Path) -> str:
    """Return the rows that make robots, as SQLite reads them, without what lbr itself writes into them."""
    with closing(sqlite3.connect(path)) as connection:
        connection.row_factory = sqlite3.Row
        return "\n".join(
            sorted(_row(table, row) for table in TABLES for row in connection.execute(f"SELECT * FROM {table}"))
        )


def _row(table: str, row: sqlite3.Row) -> str:
    return f"{table} {[row[name] for name in row.keys() if name not in WRITTEN_BY_LBR]}"  # noqa: SIM118 - a Row's own
