"""A place of its own for each process that runs tests, and whole robots.

The heavy robot is shared by all tests of a module that leave it as it was.
"""

import importlib
import os
import shutil
import signal
import sys
import tempfile
import warnings
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, settings

from tests.support import sweep
from tests.support.robot import Robot, prepare, running

PLACE = sweep.enter()
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)  # a robot is ten processes, and each would compile all that it imports
sys.dont_write_bytecode = False
os.environ["DBUS_SYSTEM_BUS_ADDRESS"] = "unix:path=/nonexistent"  # no test may power this machine off
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell in the background has it ignored, in children too

LEFT = "left"
ENDS_S = 2.0
"""What was told to end may take this long after the last test."""
CACHES = {".cache", ".config"}
"""OpenGL keeps its shaders in the one, the sound server's library a link in the other."""

# How long an example takes is the machine's affair; in CI, too, examples are random. `--hypothesis-profile nightly` tries more.
for profile, examples in (("everyday", 30), ("nightly", 500)):
    settings.register_profile(
        profile, max_examples=examples, deadline=None, suppress_health_check=[HealthCheck.too_slow]
    )
settings.load_profile("everyday")

NIGHTLY = (
    *("fuzzing", "intrusion", "kernel", "lab"),
    *("commands/test_every_command.py", "commands/test_new.py", "docs/test_pages.py", "docs/test_tour.py", "examples"),
    *("executive/test_captured_frames.py", "executive/test_many_rows.py", "executive/test_starving.py"),
    *(
        "lan/test_agent.py",
        "lan/test_agent_placement.py",
        "lan/test_found.py",
        "lan/test_lan_attempts.py",
        "lan/test_lan_cut.py",
    ),
    *("safety/test_behaviour.py", "safety/test_calibration_spin.py", "safety/test_dance.py", "safety/test_data.py"),
    *(
        "safety/test_following.py",
        "safety/test_gamepad.py",
        "safety/test_gamepad_humanoid.py",
        "safety/test_turning.py",
    ),
    *(
        "safety/test_humanoid_behaviours.py",
        "safety/test_life.py",
        "safety/test_power_cut.py",
        "safety/test_self_check.py",
    ),
    *(
        "web/test_behaviours_browser.py",
        "web/test_call_browser.py",
        "web/test_joints_browser.py",
        "web/test_page_drive.py",
    ),
    *("web/test_page_kept.py", "web/test_page_tasks.py", "web/test_page_tilt.py", "web/test_system_browser.py"),
    *(
        "apps/test_registry.py",
        "rerun/test_check.py",
        "robots/test_robot_packages.py",
        "operations/power/test_power_robot.py",
    ),
)
"""Folders and modules of tests that need root, a network of their own, or minutes."""

left_over = pytest.StashKey[list[str]]()


def pytest_configure(config: pytest.Config) -> None:
    config.stash[left_over] = []


@pytest.hookimpl(tryfirst=True)
def pytest_collection(session: pytest.Session) -> None:
    """Share among the processes of a whole run what rewriting the tests' asserts takes.

    Each begins with another module, and finds compiled what others had first. What cannot be imported, or not without
    a warning, is left to the collection, which says so.
    """
    worker = getattr(session.config, "workerinput", None)
    if worker is None or session.config.args != session.config.getini("testpaths"):
        return
    found = sorted((session.config.rootpath / "tests").rglob("test_*.py"))
    modules = [".".join(path.relative_to(session.config.rootpath).with_suffix("").parts) for path in found]
    first = len(modules) * int(worker["workerid"].removeprefix("gw")) // worker["workercount"]
    for module in modules[first:] + modules[:first]:
        with warnings.catch_warnings(), suppress(Exception, pytest.skip.Exception):
            warnings.simplefilter("error")
            importlib.import_module(module)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Leave what takes long to the nightly run."""
    places = [Path(__file__).parent / name for name in NIGHTLY]
    for item in items:
        if any(place in (item.path, *item.path.parents) for place in places):
            item.add_marker(pytest.mark.nightly)


@pytest.hookimpl(trylast=True)
def pytest_sessionfinish(session: pytest.Session) -> None:
    """Fail the run if something that a test has started still runs."""
    sweep.ended(PLACE, ENDS_S)
    left = [f"process {pid}: {argv}" for pid, argv in sweep.processes(PLACE).items()]
    left += [f"file in the home: {path}" for path in files_in_the_home()]
    sweep.kill(PLACE)
    session.config.stash[left_over] += left
    output = getattr(session.config, "workeroutput", None)
    if output is not None:
        output[LEFT] = left
    elif session.config.stash[left_over] and not session.exitstatus:
        session.exitstatus = pytest.ExitCode.TESTS_FAILED


@pytest.hookimpl(optionalhook=True)
def pytest_testnodedown(node: Any) -> None:
    """Take over what a worker has found left."""
    node.config.stash[left_over] += getattr(node, "workeroutput", {}).get(LEFT, [])


def pytest_terminal_summary(terminalreporter: Any, config: pytest.Config) -> None:
    if config.stash[left_over]:
        terminalreporter.section("left behind by tests")
        for line in config.stash[left_over]:
            terminalreporter.line(line)


@pytest.fixture(autouse=True)
def nothing_comes_into_the_home() -> Iterator[None]:
    """Fail what writes into the home of whoever runs the tests; here it is one that nobody needs."""
    yield
    if written := files_in_the_home():
        shutil.rmtree(Path.home())
        Path.home().mkdir()
        pytest.fail(f"written into the home, for want of a place of its own: {', '.join(map(str, written))}")


def files_in_the_home() -> list[Path]:
    home = Path.home()
    found = [path for entry in home.iterdir() if entry.name not in CACHES for path in (entry, *entry.rglob("*"))]
    return [path.relative_to(home) for path in found if not path.is_dir()]


@pytest.fixture
def home() -> Iterator[Path]:
    """A fresh `$LBR_HOME` with a short path, because sockets' names are bounded."""
    with tempfile.TemporaryDirectory(prefix="lbr-") as place:
        yield prepare(Path(place) / "h")


@pytest.fixture(scope="module")
def shared_home() -> Iterator[Path]:
    with tempfile.TemporaryDirectory(prefix="lbr-") as place:
        yield prepare(Path(place) / "h")


@pytest.fixture(scope="module")
def robot(shared_home: Path) -> Iterator[Robot]:
    """The simulated lbr robot, running; tests leave it standing and unlatched."""
    with running(shared_home) as started:
        yield started
