"""A place of its own for each process that runs tests, time-outs that end one test alone, and whole robots.

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

from tests.support import machine, slots, sweep
from tests.support.robot import Robot, prepare, running
from tests.support.second_try import SecondTry

PLACE = sweep.enter()
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)  # a robot is ten processes, and each would compile all that it imports
sys.dont_write_bytecode = False
os.environ["DBUS_SYSTEM_BUS_ADDRESS"] = "unix:path=/nonexistent"  # no test may power this machine off
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell in the background has it ignored, in children too

NOTE, LEFT = "machine", "left"
ENDS_S = 2.0
"""What was told to end may take this long after the last test."""
AGAIN_S = 0.5
CACHES = {".cache", ".config"}
"""OpenGL keeps its shaders in the one, the sound server's library a link in the other."""

# How long an example takes is the machine's affair; in CI, too, examples are random. `--hypothesis-profile nightly` tries more.
for profile, examples in (("everyday", 30), ("nightly", 500)):
    settings.register_profile(
        profile, max_examples=examples, deadline=None, suppress_health_check=[HealthCheck.too_slow]
    )
settings.load_profile("everyday")

WAITERS = 1
"""Tests wait more than they compute, for lines, clocks and robots: this many more at a time than there are cores."""
ROBOTS = 0
"""This many more of them than there are cores have whole robots, or browsers, which draw without a graphics card. With one
more, on two cores, three of them at once went without the processor for longer than leases last."""

left_over = pytest.StashKey[list[str]]()


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_auto_num_workers() -> int:
    """Return what `-n auto` means here."""
    return len(os.sched_getaffinity(0)) + WAITERS


def pytest_configure(config: pytest.Config) -> None:
    config.stash[left_over] = []
    config.pluginmanager.register(SecondTry())
    if slots.PLACE not in os.environ:
        slots.make(PLACE, len(os.sched_getaffinity(0)) + ROBOTS)


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


@pytest.hookimpl(tryfirst=True, optionalhook=True)
def pytest_timeout_set_timer(item: Any, settings: Any) -> bool | None:
    """Fail the test alone when this machine has given it its time; `faulthandler_timeout` ends what hears no signal."""
    if settings.method != "signal":
        return None
    watch, waited_s = machine.Stopwatch(), slots.waited()

    def ring(*_: object) -> None:
        left_s = settings.timeout - watch.given_s + (slots.waited() - waited_s)
        if left_s > 0.0:
            signal.setitimer(signal.ITIMER_REAL, max(AGAIN_S, left_s))
        else:
            pytest.fail(f"not done within {settings.timeout:g} s ({watch})")

    def cancel() -> None:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, signal.SIG_DFL)

    item.cancel_timeout = cancel
    signal.signal(signal.SIGALRM, ring)
    signal.setitimer(signal.ITIMER_REAL, settings.timeout)
    return True


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item: pytest.Item) -> None:
    """Have what looks at pages wait for its turn: a browser takes as much of the machine as a robot does."""
    if hasattr(getattr(item, "module", None), "sync_playwright"):
        slots.take()


def pytest_runtest_logfinish() -> None:
    """Let another process have a robot, if this one has none any more."""
    slots.give_back()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport() -> Iterator[None]:
    """Send what is to be told at the end of the run along with the test's report."""
    report = yield
    report.user_properties += [(NOTE, text) for text in machine.notes]
    machine.notes.clear()
    return report


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
    reports = [report for group in terminalreporter.stats.values() for report in group]
    told = [
        (report.nodeid, text)
        for report in reports
        for name, text in getattr(report, "user_properties", ())
        if name == NOTE
    ]
    for title, lines in (
        ("measured more than once", [f"{where}: {text}" for where, text in dict.fromkeys(told)]),
        ("left behind by tests", config.stash[left_over]),
    ):
        if lines:
            terminalreporter.section(title)
            for line in lines:
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
