"""P8: rows edited a hundred times a second, valid and invalid mixed, while the robot runs."""

import sqlite3
import time

from tests.scenarios.crashes import EDITS, VICTIMS
from tests.support.bench import Bench, bench
from tests.support.figures import Results

PER_S = 100
TOUCH_S = 2.0
UNTOUCHED = ("motors", "ranges", "drive", "world")
VALID = (
    "UPDATE verb SET help = 'edit {n}' WHERE robot = 'lbr' AND word = 'f'",
    "INSERT OR REPLACE INTO phrase (name, language, text) VALUES ('edit', 'en', 'number {n}')",
    "UPDATE capability SET help = 'edit {n}' WHERE robot = 'lbr' AND name = 'ranges'",
)
BREAK = """UPDATE capability SET settings = '{{"note": 1, "n": {n}}}' WHERE robot = 'lbr' AND name = 'app'"""
MEND = "UPDATE capability SET settings = '{}' WHERE robot = 'lbr' AND name = 'app'"
TOUCH = """UPDATE capability SET settings = '{{"note": "{n}"}}' WHERE robot = 'lbr' AND name = 'app'"""
NO_SUCH_KIND = "UPDATE capability SET kind = 'nothing_{n}' WHERE robot = 'lbr' AND name = 'app'"
KIND_AGAIN = "UPDATE capability SET kind = 'failing_app' WHERE robot = 'lbr' AND name = 'app'"


def edit_for(under_test: Bench, seconds: float) -> None:
    """Edit for this long; a third of the time the rows make no sense."""
    before = {name: under_test.pid(name) for name in UNTOUCHED}
    database = sqlite3.connect(under_test.robot.home / "robot.db", timeout=5.0, isolation_level=None)
    began = time.monotonic()
    edits = 0
    while time.monotonic() - began < seconds:
        for statement in _statements(edits):
            _edit(under_test, database, statement)
        edits += 1
        under_test.pass_time(began + edits / PER_S - time.monotonic())
    for statement in (MEND, KIND_AGAIN):
        _edit(under_test, database, statement)
    database.close()
    under_test.until(lambda: not under_test.robot.status()["problems"], 5.0, "no problem with the rows", every_s=0.1)
    changed = [f"{name} was restarted" for name, pid in before.items() if under_test.pid(name) != pid]
    under_test.results.check("P8", [*changed, *_locked(under_test)])


def edits(results: Results, n: int) -> None:
    """P8: for `n` seconds."""
    with bench(results, *VICTIMS, edits=EDITS) as under_test:
        edit_for(under_test, float(n))
        invalid_keeps_the_old(under_test)


def _statements(n: int) -> tuple[str, ...]:
    """One edit; now and then one that breaks or mends the rows beside it."""
    extra: tuple[str, ...] = ()
    match n % int(PER_S * TOUCH_S):
        case 30:
            extra = (BREAK.format(n=n),)
        case 80:
            extra = (MEND,)
        case 110:
            extra = (NO_SUCH_KIND.format(n=n),)
        case 140:
            extra = (KIND_AGAIN,)
        case 170:
            extra = (TOUCH.format(n=n),)
    return (VALID[n % len(VALID)].format(n=n), *extra)


def _edit(under_test: Bench, database: sqlite3.Connection, statement: str) -> None:
    started = time.monotonic()
    try:
        database.execute(statement)
    except sqlite3.OperationalError as err:
        under_test.results.check("P8", [f"{err}: {statement}"])
    under_test.results.sample("P8 edit", (time.monotonic() - started) * 1000)


def _locked(under_test: Bench) -> list[str]:
    logs = [under_test.robot.home / "stderr.txt", *(under_test.robot.home / "logs").glob("*.log")]
    return [
        f"{path.name}: {line}"
        for path in logs
        for line in path.read_text(errors="replace").splitlines()
        if "is locked" in line
    ]


def invalid_keeps_the_old(under_test: Bench) -> None:
    """Rows that do not validate are reported, and everything goes on as it was."""
    under_test.until(lambda: under_test.unit("app")["pid"] is not None, 4.0, "the app runs")  # it was mended just now
    under_test.all_ready()
    pid = under_test.pid("app")
    under_test.robot.edit(NO_SUCH_KIND.format(n=0))
    under_test.until(lambda: bool(under_test.robot.status()["problems"]), 4.0, "the problem told", every_s=0.1)
    wrong = [] if under_test.pid("app") == pid else ["an invalid edit restarted the app"]
    under_test.robot.edit(KIND_AGAIN)
    under_test.results.check("P8", wrong)
