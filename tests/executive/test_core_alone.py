"""The core without any component: a copy of the tree runs a robot from rows, and what is missing is told."""

import os
import re
import shutil
import sqlite3
import sys
from pathlib import Path

import pytest

from tests.support import programs
from tests.support.robot import prepare

ROOT = Path(__file__).parents[2]
COMPONENTS = ("apps", "robots", "simulation", "testing", "gym")
PROFILE = 'robot = "tiny"\ndescription = "two rows"\nsimulate = false\n'
ROWS = """
PRAGMA foreign_keys = ON;
DELETE FROM robot;
INSERT INTO robot (name, model, description) VALUES ('tiny', 'tiny', 'two rows');
"""
PROGRAM = """
INSERT INTO capability (robot, name, kind, settings, help)
VALUES ('tiny', 'ticker', 'exec', '{"argv": ["sleep", "1000"]}', 'A program');
"""
OWN_TESTS = ("bus", "leases", "messages", "operations")
"""Rooms whose tests need no robot; the core's other tests drive the simulated ones."""
BROUGHT = re.compile(r'^\w+ = "lbr\.(?:apps|robots|simulation)\b.*\n', re.MULTILINE)
"""The entry points of components."""


def copied(tree: Path, *without: str) -> None:
    """Copy lbr to a folder with what was compiled of it, without some of it."""
    shutil.copytree(ROOT / "lbr", tree / "lbr", ignore=shutil.ignore_patterns("node_modules", "*.pyc.*"))
    for name in without:
        place = tree / "lbr" / name
        shutil.rmtree(place) if place.is_dir() else place.unlink()
    for name in ("pyproject.toml", "robot.db.sql"):
        shutil.copy(ROOT / name, tree / name)
    (tree / "launch_profiles").mkdir()


def lbr(tree: Path, *words: str, lines: str = "") -> tuple[int, str, str]:
    """Run the command line of a copy; return its code and what it wrote."""
    environment = {**os.environ, "PYTHONPATH": str(tree), "LBR_HOME": str(tree / "home")}
    done = programs.run(
        [sys.executable, "-m", "lbr.start", *words],
        input=lines,
        capture_output=True,
        text=True,
        cwd=tree,
        env=environment,
        timeout=30,
    )
    return done.returncode, done.stdout, done.stderr


@pytest.fixture
def core(tmp_path: Path) -> Path:
    copied(tmp_path, *COMPONENTS)
    project = tmp_path / "pyproject.toml"
    project.write_text(BROUGHT.sub("", project.read_text()))
    home = tmp_path / "home"
    (home / "capabilities").mkdir(parents=True)
    shutil.copy(ROOT / "docs" / "examples" / "greetings.py", home / "capabilities")
    rows = sqlite3.connect(home / "robot.db")
    greetings = (ROOT / "docs" / "examples" / "greetings.sql").read_text().replace("'lbr'", "'tiny'")
    code, table, err = lbr(tmp_path, "db", "table", "greetings")
    assert code == 0, err
    rows.executescript((tmp_path / "robot.db.sql").read_text() + ROWS + table + greetings + PROGRAM)
    rows.close()
    (home / "robot.db").chmod(0o600)
    (tmp_path / "tiny.toml").write_text(PROFILE)
    return tmp_path


def test_a_robot_of_a_program_and_a_kind_from_a_file_runs_and_has_an_emergency_stop(core):
    code, out, err = lbr(core, "run", "tiny.toml", lines="/greet/ann\nestop\nstatus\nreset\n/greet/bob\nShutdown\n")
    assert code == 0, err
    said = out.splitlines()
    assert {"Good day, Ann.", "greetings: ready", "ticker: ready", "emergency stop: pressed"} <= set(said)
    assert "Hello Bob!" in said[said.index("emergency stop: pressed") :]


@pytest.fixture
def without_speech(tmp_path: Path) -> Path:
    copied(tmp_path, "apps/speech")
    shutil.copytree(ROOT / "launch_profiles", tmp_path / "launch_profiles", dirs_exist_ok=True)
    prepare(tmp_path / "home", "speech")
    return tmp_path


def test_a_robot_runs_without_a_component_that_is_gone_and_says_what_it_lacks(without_speech):
    code, out, err = lbr(without_speech, "run", "lbr-sim", lines="s\nstatus\nShutdown\n")
    assert code == 0, err
    assert "component 'speech'" in err
    assert {"world: ready", "drive: ready"} <= set(out.splitlines())
    assert "speech: " not in out
    code, out, _ = lbr(without_speech, "db", "check")
    assert code == 0
    assert "capability 'speech' is left out" in out


def reaches_a_component(module: Path) -> bool:
    """Say whether a test, or what it imports of the tests, imports a component."""
    waiting, known = [module], set()
    while waiting:
        path = waiting.pop()
        known.add(path)
        for found in re.findall(r"^\s*(?:from|import) (\S+)(?: import (\w+))?", path.read_text(), re.MULTILINE):
            name = ".".join(filter(None, found))
            if name.startswith(tuple(f"lbr.{part}." for part in ("apps", "robots", "simulation", "testing"))):
                return True
            places = (ROOT.joinpath(*one.split(".")).with_suffix(".py") for one in (found[0], name))
            waiting += [
                place for place in places if name.startswith("tests.") and place.is_file() and place not in known
            ]
    return False


@pytest.mark.timeout(400)
def test_the_cores_own_tests_pass_without_a_component(core):
    modules = [path for room in OWN_TESTS for path in sorted((ROOT / "tests" / room).rglob("test_*.py"))]
    alone = [str(path.relative_to(ROOT)) for path in modules if not reaches_a_component(path)]
    assert len(alone) > 40
    shutil.copytree(ROOT / "tests", core / "tests", ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copytree(ROOT / "lbr" / "testing", core / "lbr" / "testing")
    environment = {**os.environ, "PYTHONPATH": str(core)}
    command = [sys.executable, "-m", "pytest", "-q", "-n", "2", "-p", "no:cacheprovider", *alone]
    done = programs.run(command, capture_output=True, text=True, cwd=core, env=environment, timeout=300)
    assert done.returncode == 0, done.stdout[-3000:]
