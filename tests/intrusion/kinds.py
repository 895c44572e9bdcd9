"""A11: rows that would have the robot load what it should not, and files that others may change."""

import json
import os
import sqlite3
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path

from tests.support.bench import temporary_home
from tests.support.figures import Results
from tests.support.robot import lbr

CANARY = "import pathlib; pathlib.Path({mark!r}).touch(); KIND = None\n"
NAMES = (
    "os", "subprocess", "builtins", "sys", "importlib", "os.system", "canary_module", "canary_module:KIND", "canary_point",
    "canary_group", "lbr.drivers.roboteq", "lbr.capability.program:KIND", "../canary_module", "./canary_module",
    "capabilities/../../canary_module", "/tmp/canary_module", "..", ".", "", " roboteq", "roboteq ", "Roboteq", "ROBOTEQ",
    "r\u043eboteq", "\uff52oboteq", "roboteq\u200b", "roboteq\x00", "canary_module\x00.py", "roboteq\n", "roboteq;id",
    "__import__", "__import__('canary_module')", "exec('import canary_module')", "{canary_module}", "%s", "a" * 41, "lambda",
    "none", "null", "capabilities", "canary_module.py", "file:///tmp/canary_module.py", "~/canary_module", "$HOME", "nul",
)  # fmt: skip
REFUSED = 2


def kinds(results: Results, names: tuple[str, ...] = NAMES) -> None:
    """Name everything but a kind."""
    with temporary_home() as home:
        mark = home / "canary"
        with _bait(home, mark):
            for name in names:
                with _edited(home, "UPDATE capability SET kind = ? WHERE name = 'ranges'", name):
                    results.check("A11", _refused(home, mark, f"kind {name!r}"))
            for settings in ({"device": "../x"}, {"device": "range_board", "__class__": "os"}):
                with _edited(home, "UPDATE capability SET settings = ? WHERE name = 'ranges'", json.dumps(settings)):
                    results.check("A11", _refused(home, mark, f"settings {settings}"))


def places(results: Results) -> None:
    """Let others write to what the robot trusts."""
    with temporary_home() as home:
        mark = home / "canary"
        with _bait(home, mark):
            for what, trap in _traps(home):
                with trap:
                    results.check("A11", _refused(home, mark, what))


@contextmanager
def _bait(home: Path, mark: Path) -> Iterator[None]:
    """Put a module that leaves a mark wherever a careless loader would find it."""
    site = home / "site"
    point = site / "canary-1.0.dist-info"
    point.mkdir(parents=True)
    text = CANARY.format(mark=str(mark))
    for place in (site, home, home / "run"):
        place.mkdir(exist_ok=True)
        (place / "canary_module.py").write_text(text)
    (point / "METADATA").write_text("Metadata-Version: 2.1\nName: canary\nVersion: 1.0\n")
    (point / "entry_points.txt").write_text(
        "[console_scripts]\ncanary_point = canary_module:KIND\n[lbr.components.more]\ncanary_group = canary_module:KIND\n"
    )
    before = os.environ.get("PYTHONPATH")
    os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, (str(site), before)))
    try:
        yield
    finally:
        os.environ.pop("PYTHONPATH")
        if before is not None:
            os.environ["PYTHONPATH"] = before


def _traps(home: Path) -> Iterator[tuple[str, AbstractContextManager[None]]]:
    """Yield what is writable by others, each for as long as its `with` lasts."""
    own = home / "capabilities"
    kind = own / "mine.py"
    kind.write_text((home / "canary_module.py").read_text())
    kind.chmod(0o600)
    named = "UPDATE capability SET kind = 'mine' WHERE name = 'ranges'"
    for path, mode in ((kind, 0o622), (kind, 0o620), (own, 0o722), (own, 0o720)):
        yield f"{path.name} of mode {mode:o}", _with(home, named, path, mode)
    kind.unlink()
    loose = home / "loose"
    loose.mkdir()
    (loose / "mine.py").write_text((home / "canary_module.py").read_text())
    (loose / "mine.py").chmod(0o600)
    kind.symlink_to(loose / "mine.py")
    yield "a link into a folder that others may change", _with(home, named, loose, 0o777)
    kind.unlink()
    kind.mkdir()
    yield "a folder instead of a file", _with(home, named, home, 0o700)
    kind.rmdir()
    for mode in (0o666, 0o620, 0o602):
        yield f"a database of mode {mode:o}", _with(home, "SELECT 1", home / "robot.db", mode)
    yield "a home that anybody may change", _with(home, "SELECT 1", home, 0o777)


@contextmanager
def _with(home: Path, sql: str, path: Path, mode: int) -> Iterator[None]:
    before = path.stat().st_mode & 0o7777
    with _edited(home, sql):
        path.chmod(mode)
        try:
            yield
        finally:
            path.chmod(before)


@contextmanager
def _edited(home: Path, sql: str, *values: str) -> Iterator[None]:
    """Change a row as somebody who minds no check of the schema, and put it back."""
    _write(home, sql, *values)
    try:
        yield
    finally:
        _write(
            home,
            "UPDATE capability SET kind = 'ultrasonic_ring', settings = '{\"device\": \"range_board\"}' WHERE name = 'ranges'",
        )


def _write(home: Path, sql: str, *values: str) -> None:
    with sqlite3.connect(home / "robot.db") as database:
        database.execute("PRAGMA ignore_check_constraints = ON")
        database.execute(sql, values)
    database.close()


def _refused(home: Path, mark: Path, what: str) -> list[str]:
    done = lbr(home, "run", "lbr-sim", "--no-console")
    found = [f"{what}: it was imported"] if mark.exists() else []
    mark.unlink(missing_ok=True)
    if done.returncode != REFUSED:
        found.append(f"{what}: exit code {done.returncode}: {done.stderr[-300:]}")
    if "Traceback" in done.stderr:
        found.append(f"{what}: a traceback: {done.stderr[-300:]}")
    return found
