"""The suite itself: what a test process started ends with it, a slow test fails alone, nothing is left unseen."""

import json
import os
import sys
from contextlib import suppress
from pathlib import Path

import psutil
import pytest

from tests.support import programs
from tests.support.waiting import until

pytestmark = pytest.mark.timeout(40)

ROOT = Path(__file__).parents[2]

DIES = """
import json, os, signal
from pathlib import Path
from tests.support import programs, sweep
from tests.support.robot import start

def test_is_killed(home):
    robot = start(home)
    programs.start(["/bin/sleep", "60"])
    place = Path(os.environ[sweep.MARK])
    Path(NOTE).write_text(json.dumps([str(place), *sweep.processes(place)]))
    os.kill(os.getpid(), signal.SIGKILL)
"""
SLOW = """
import select
import pytest

@pytest.mark.timeout(0.3)
def test_that_is_slow():
    select.select([], [], [], 60.0)

def test_after_it():
    pass
"""
STUCK = """
import pytest
import zenoh

@pytest.mark.timeout(0.3)
def test_that_waits_for_an_answer():
    config = zenoh.Config()
    config.insert_json5("scouting/multicast/enabled", "false")
    config.insert_json5("listen/endpoints", "[]")
    with zenoh.open(config) as bus:
        bus.declare_subscriber("a/b").recv()

def test_after_it():
    pass
"""
LEAVES = """
import os
from pathlib import Path

def test_leaves_a_process():
    os.posix_spawn("/bin/sleep", ["/bin/sleep", "60"], os.environ)

def test_leaves_a_file():
    (Path.home() / "left.txt").touch()

def test_leaves_nothing():
    assert not list(Path.home().iterdir())
"""


def run(tmp_path: Path, text: str, *arguments: str) -> tuple[int, str]:
    """Run a file of tests by a pytest of its own, with this suite's settings."""
    file = tmp_path / "test_it.py"
    file.write_text(text)
    settings = ["-p", "tests.conftest", "-c", str(ROOT / "pyproject.toml"), "-p", "no:cacheprovider"]
    argv = [sys.executable, "-m", "pytest", *settings, "--basetemp", str(tmp_path / "b"), *arguments, str(file)]
    done = programs.run(argv, cwd=ROOT, capture_output=True, text=True, check=False, timeout=150)
    return done.returncode, done.stdout + done.stderr


def running(pids: list[int]) -> list[str]:
    found = []
    for pid in pids:
        with suppress(psutil.Error):
            process = psutil.Process(pid)
            found += [] if process.status() == psutil.STATUS_ZOMBIE else [" ".join(process.cmdline())]
    return found


def test_nothing_of_a_killed_test_process_is_left(tmp_path):
    note = tmp_path / "note.json"
    code, said = run(tmp_path, f"NOTE = {str(note)!r}\n{DIES}")
    assert code == -9, said
    place, *pids = json.loads(note.read_text())
    assert len(pids) > (5 if os.geteuid() == 0 else 4)  # only root sees those that gave up being looked at
    until(lambda: not running(pids), what="by the kernel, before the sweeper")
    until(lambda: not Path(place).exists(), what="by the sweeper")


@pytest.mark.parametrize("text", [SLOW, STUCK])
def test_a_slow_test_fails_alone(tmp_path, text):
    code, said = run(tmp_path, text, "-n", "1")
    assert code == 1, said
    assert "1 failed, 1 passed" in said
    assert "Timeout (>0.3s)" in said
    assert "crashed" not in said


@pytest.mark.parametrize("arguments", [(), ("-n", "1")])
def test_what_a_test_leaves_behind_fails_the_run(tmp_path, arguments):
    code, said = run(tmp_path, LEAVES, *arguments)
    assert "3 passed, 1 error" in said
    assert code == 1
    assert "left behind by tests" in said
    assert "/bin/sleep 60" in said
    assert "ERROR ::test_leaves_a_file - Failed: written into the home" in said


def test_a_test_process_ends_without_a_word_and_its_place_with_it():
    line = "from tests.support import sweep; print(sweep.enter())"
    done = programs.run([sys.executable, "-W", "error", "-c", line], cwd=ROOT, capture_output=True, text=True)
    assert done.stderr == ""
    until(lambda: not Path(done.stdout.strip()).exists(), what="by the sweeper")
