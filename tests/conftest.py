"""A place of its own for each process that runs tests, and whole robots.

The heavy robot is shared by all tests of a module that leave it as it was.
"""

import gc
import importlib
import os
import shutil
import signal
import tempfile
import warnings
from collections.abc import Iterator
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, settings

from tests.support import needs, sweep
from tests.support.robot import Robot, prepare, running
from tests.support.wording import wording  # noqa: F401 - a fixture

PLACE = sweep.enter()
os.environ["DBUS_SYSTEM_BUS_ADDRESS"] = "unix:path=/nonexistent"  # no test may power this machine off
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell in the background has it ignored, in children too
signal.signal(signal.SIGHUP, signal.SIG_DFL)  # `nohup` has it ignored, in children too

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

gc.disable()
"""Collecting ten thousand tests leaves nothing behind, and each look at them takes longer than the last."""

TESTS = Path(__file__).parent
LISTS = {name: TESTS / f"{name}.txt" for name in ("nightly", "slow")}
"""Marks of tests, and the file that names for each which folders, modules and tests have it."""
SLOW_S = 2.0

left_over = pytest.StashKey[list[str]]()
nameless = pytest.StashKey[list[str]]()
"""The lines of a list that name no test, in a whole run."""


def pytest_configure(config: pytest.Config) -> None:
    config.stash[left_over], config.stash[nameless] = [], []


@pytest.hookimpl(tryfirst=True)
def pytest_collection(session: pytest.Session) -> None:
    """Share among the processes of a whole run what rewriting the tests' asserts takes.

    Each begins with another module, and finds compiled what others had first. What cannot be imported, or not without
    a warning, is left to the collection, which says so.
    """
    worker = getattr(session.config, "workerinput", None)
    if worker is None or not _is_whole(session.config):
        return
    found = sorted(path for path in TESTS.rglob("test_*.py") if not _is_left_out(path, session.config))
    modules = [".".join(path.relative_to(session.config.rootpath).with_suffix("").parts) for path in found]
    first = len(modules) * int(worker["workerid"].removeprefix("gw")) // worker["workercount"]
    for module in modules[first:] + modules[:first]:
        with warnings.catch_warnings(), suppress(Exception, pytest.skip.Exception):
            warnings.simplefilter("error")
            importlib.import_module(module)


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """Import no folder or module in README's run that all of it leaves to the night."""
    return _is_left_out(collection_path, config) or None


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Mark what the lists name; in a whole run note the lines that name nothing, for a test that fails by them."""
    for mark, path in LISTS.items():
        wanted = _lines(mark)
        named = {line for line in wanted if _is_left_out(TESTS / line, config) and (TESTS / line).exists()}
        for item in items:
            if names := wanted.intersection(_names(item.nodeid.removeprefix("tests/"))):
                item.add_marker(mark)
                named |= names
        if _is_whole(config):
            config.stash[nameless] += [f"{path.name}: {line}" for line in sorted(wanted - named)]


def pytest_collection_finish() -> None:
    """Let no later collection of garbage look again at the tests themselves."""
    gc.freeze()
    gc.enable()


@cache
def _lines(mark: str) -> frozenset[str]:
    return frozenset(line for line in LISTS[mark].read_text().splitlines() if line and not line.startswith("#"))


def _is_whole(config: pytest.Config) -> bool:
    return config.args == config.getini("testpaths")


def _is_left_out(path: Path, config: pytest.Config) -> bool:
    """Say whether a folder or module is left to the night by this run."""
    if not _is_whole(config) or config.option.markexpr != "not nightly" or not path.is_relative_to(TESTS):
        return False
    return not _lines("nightly").isdisjoint(map(str, (path.relative_to(TESTS), *path.relative_to(TESTS).parents)))


def _names(test: str) -> Iterator[str]:
    """Yield the test, the test without its parameter, its module and the folders of that."""
    path, _, name = test.partition("::")
    yield from (test, f"{path}::{name.partition('[')[0]}", *_places(path))


@cache
def _places(path: str) -> tuple[str, ...]:
    return path, *map(str, Path(path).parents)


@pytest.fixture(autouse=True, scope="module")
def _rank_of_its_own() -> Iterator[None]:
    """Fail a module that leaves its process another rank: what runs beside it would wait for it from then on."""
    before = os.getpriority(os.PRIO_PROCESS, 0)
    yield
    assert os.getpriority(os.PRIO_PROCESS, 0) == before, "its process has another niceness than before"


def pytest_xdist_auto_num_workers() -> int:
    """Return how many processes `-n auto` begins: three for two cores, as a test that has a robot waits half of its time.

    Two of them in CI, whose cores are others', too: a robot that is starved stops, as it has to.
    """
    cores = len(os.sched_getaffinity(0))
    return cores if needs.IN_CI else cores * 3 // 2


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
    passed = terminalreporter.stats.get("passed", ())
    if slow := [one for one in passed if one.duration > SLOW_S and not {"slow", "nightly"}.intersection(one.keywords)]:
        terminalreporter.section(f"took more than {SLOW_S:g} s, and {LISTS['slow'].name} says of no reason")
        for one in slow:
            terminalreporter.line(f"{one.duration:.1f} s {one.nodeid}")
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
