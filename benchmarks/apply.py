"""The end of rows that are applied to a running robot: `lbr db apply --within` with good and bad ones, and with kills
of the executive.

`python -m benchmarks apply --n 100`. A third of the rounds kill the executive, at a random moment. The rows must then
be the old or the new ones, complete, and all parts ready. The time is from the write, or from the next start after a
kill.
"""

import argparse
import os
import random
import signal
import sqlite3
import subprocess
import time
from collections.abc import Iterator
from contextlib import closing, suppress
from pathlib import Path

from benchmarks import Measured
from lbr.database import changes
from lbr.database.reading import RawTables
from lbr.database.sources import wanted
from lbr.database.store import Database
from tests.support import programs
from tests.support.bench import temporary_home
from tests.support.figures import Promise, Results
from tests.support.robot import LBR, Robot, environment, start
from tests.support.waiting import until

SMOKE = "--n 3"

WITHIN_S = 1.5
LATEST_KILL_S = 1.2
"""After the write: while the rows are on trial, and after it; in every third kill, after the command began."""
BACK_S = 20.0
LOOK_S = 0.01
SLOWEST = 5
PROMISES = {
    "H1": Promise(
        what="applied rows end as the old or the new ones, whole, with everything ready; a third of the executives killed"
    ),
    "H2": Promise(what="applied rows, from written to kept or taken back, and all ready", target=3000, statistic="max"),
    "H3": Promise(what="a start after a kill in an apply, until all is ready again", target=3000, statistic="max"),
}
KIND = """
import sys, time
from msgspec import Struct
from lbr.capability import Capability, Kind

class Settings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    how: str = "well"

class Tried(Capability[Settings]):
    def open(self) -> None:
        if self.ctx.settings.how == "never":
            time.sleep(60.0)
        if self.ctx.settings.how == "crash":
            sys.exit(1)

    def step(self) -> None:
        if self.ctx.settings.how == "later":
            sys.exit(1)

KIND = Kind(name="tried", summary="runs, or does not", family="app", entry=Tried, settings=Settings)
"""
GOOD = (
    "UPDATE capability SET settings = json_set(settings, '$.max_power', {x}) WHERE robot = 'lbr' AND name = 'drive';",
    "UPDATE robot SET owner = 'owner {x}' WHERE name = 'lbr';",
    "INSERT OR REPLACE INTO phrase VALUES ('tried', 'en', 'Number {x}.');",
    (
        "UPDATE capability SET restart = CASE restart WHEN 'always' THEN 'on-failure' ELSE 'always' END"
        " WHERE robot = 'lbr' AND name = 'ranges';"
    ),
    (
        "DELETE FROM capability WHERE robot = 'lbr' AND name = 'tried';"
        " INSERT INTO capability (robot, name, kind, help) VALUES ('lbr', 'tried', 'tried', '{x}');"
    ),
)
TRIED = (
    "DELETE FROM capability WHERE robot = 'lbr' AND name = 'tried';"
    " INSERT INTO capability (robot, name, kind, settings) VALUES ('lbr', 'tried', 'tried', '{{\"how\": \"HOW\"}}');"
)
BAD = (
    *(TRIED.replace("HOW", how) for how in ("never", "crash", "later")),
    "UPDATE capability SET kind = 'no_such' WHERE robot = 'lbr' AND name = 'drive';",
    "DELETE FROM capability WHERE robot = 'lbr' AND name = 'motors';",
)


def options(parser: argparse.ArgumentParser) -> None:
    """Add the amount."""
    parser.add_argument("--n", type=int, default=100, help="rounds (default %(default)s)")
    parser.add_argument("--seed", type=int, default=1, help="of chance (default %(default)s)")


def measure(given: argparse.Namespace) -> Measured:
    """Apply rows, and check the end."""
    results, dice = Results(PROMISES), random.Random(given.seed)
    ends: dict[str, int] = {}
    slow: list[tuple[float, str]] = []
    with temporary_home() as home:
        (home / "capabilities" / "tried.py").write_text(KIND)
        (home / "capabilities" / "tried.py").chmod(0o600)
        robot = start(home)
        try:
            for number in range(given.n):
                kill = number % 3 == 2
                good = dice.random() < 0.5
                script = dice.choice(GOOD if good else BAD).format(x=round(dice.uniform(0.2, 0.9), 3))
                kill_after_s = dice.uniform(0.0, LATEST_KILL_S) if kill else None
                end, took_ms, robot = _round(robot, script, results, kill_after_s, early=number % 9 == 2)
                name = f"{'good' if good else 'bad'}{', killed' if kill else ''}: {end}"
                ends[name] = ends.get(name, 0) + 1
                slow.append((round(took_ms), f"{name}: {script}"))
        finally:
            robot.close()
    told = "\n".join(f"{count:5} {name}" for name, count in sorted(ends.items()))
    return Measured(
        results=results.ordered(), figures={"ends": ends, "slowest": sorted(slow, reverse=True)[:SLOWEST]}, text=told
    )


def _round(
    robot: Robot, script: str, results: Results, kill_after_s: float | None, *, early: bool
) -> tuple[str, float, Robot]:
    """Apply once; return the resulting rows, the time, and the running robot."""
    home = robot.home
    (home / "edit.sql").write_text(script)
    old, new, trials = _rows(home), _wanted(home), _trials(home)
    command = programs.start(
        [*LBR, "db", "apply", str(home / "edit.sql"), "--within", str(WITHIN_S)],
        env=environment(home),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )
    since = time.monotonic()
    while command.poll() is None and _trials(home) == trials and not early:
        time.sleep(LOOK_S)
        since = time.monotonic()
    if kill_after_s is None:
        command.wait(timeout=BACK_S)
        until(lambda: _judged(home), limit_s=BACK_S, what="a trial that is judged")
        tried = _trials(home) != trials
    else:
        time.sleep(kill_after_s)  # a random moment
        os.kill(robot.ready["pid"], signal.SIGKILL)
        command.wait(timeout=BACK_S)
        robot.close()
        since, tried = time.monotonic(), False
        robot = start(home)
    faults = list(_not_ready(robot))
    with suppress(AssertionError):
        until(lambda: not list(_not_ready(robot)), limit_s=BACK_S)
        faults = []
    took_ms = (time.monotonic() - since) * 1000
    now = _rows(home)
    end = "old" if _same(home, now, old) else "new" if _same(home, now, new) else "neither"
    results.check(
        "H1", [*faults, *([f"the rows are neither the old nor the new ones: {script}"] if end == "neither" else [])]
    )
    if kill_after_s is not None:
        results.sample("H3", took_ms)
    elif tried:
        results.sample("H2", took_ms)
    assert command.stderr is not None
    command.stderr.close()
    return end, took_ms, robot


def _not_ready(robot: Robot) -> Iterator[str]:
    status = robot.status()
    yield from status["problems"]
    yield from (f"{one['name']} is {one['phase']}" for one in status["capabilities"] if one["phase"] != "ready")


def _rows(home: Path) -> RawTables:
    with Database.open(home / "robot.db") as database:
        return database.tables()[0]


def _wanted(home: Path) -> RawTables:
    with Database.open(home / "robot.db") as database:
        tables, schema = database.tables()
        return changes.applied(tables, schema, wanted(home / "edit.sql", database.path)(tables, schema))


def _same(home: Path, one: RawTables, other: RawTables) -> bool:
    with Database.open(home / "robot.db") as database:
        return not changes.between(one, other, database.tables()[1])


def _trials(home: Path) -> int:
    with closing(sqlite3.connect(home / "robot.db", timeout=5.0)) as client:
        return int(client.execute("SELECT coalesce(max(revision), 0) FROM trial").fetchone()[0])


def _judged(home: Path) -> bool:
    with closing(sqlite3.connect(home / "robot.db", timeout=5.0)) as client:
        return bool(client.execute("SELECT count(*) FROM trial WHERE state = 'running'").fetchone() == (0,))
