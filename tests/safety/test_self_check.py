"""Robots broken on purpose: what measures them must notice."""

import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass

import psutil
import pytest

from tests.scenarios import clients, estop, freezes, kills, load, resets, roles
from tests.scenarios.promises import PROMISES
from tests.support.bench import VICTIMS, Bench, bench, processes_of
from tests.support.figures import Results
from tests.support.waiting import HANG_S

SOON_S = 1.5

CARELESS = (
    """UPDATE capability SET settings = '{"ttl_s": 1.0, "accel_per_s": 40.0}' WHERE robot = 'lbr' AND name = 'drive'"""
)
STRAY = """INSERT INTO capability (robot, name, kind, settings, help) VALUES
    ('lbr', 'stray', 'exec', '{"argv": ["/bin/sh", "-c", "setsid sleep 20 & exec sleep 20"]}', 'Leaves a process')"""


@pytest.fixture
def results() -> Results:
    return Results(PROMISES)


@dataclass(frozen=True)
class Broken:
    """A capability whose kind is a victim's, the scenario meant for it, and how it is seen to fail."""

    capability: str
    victim: str
    scenario: Callable[[Bench], None]
    figure: str
    seen: str

    @property
    def edit(self) -> str:
        kind = f"kind = '{self.victim}', process = ''"  # of two that share a process, the guard ends both
        return f"UPDATE capability SET {kind} WHERE robot = 'lbr' AND name = '{self.capability}'"


def drive_killed(under_test: Bench) -> None:
    kills.kill_process(under_test, "drive", "S3")


def reset_under_stream(under_test: Bench) -> None:
    resets.reset_under_stream(under_test, "put")


BROKEN = (
    Broken("motors", "deaf_motors", drive_killed, "S3", "still turn"),
    Broken("drive", "eager_drive", drive_killed, "S14", "after the stop"),
    Broken("drive", "timeless_drive", clients.plain_client_killed, "S8", "still turn"),
    Broken("drive", "forgetful_drive", reset_under_stream, "E3", "moved the robot after the reset"),
    Broken("motors", "unwatched_motors", freezes.everything_frozen, "S11", "still turn"),
)


class FoundError(Exception):
    """What was to be seen has been seen: there is nothing to wait for any more."""


class Awaiting(Results):
    """Results that end a scenario with the finding that it is meant for."""

    def __init__(self, broken: Broken) -> None:
        super().__init__(PROMISES)
        self._broken = broken

    def check(self, figure: str, problems: Iterable[str] = ()) -> None:
        super().check(figure, problems)
        if any(self._broken.seen in text for text in self.of(self._broken.figure).violations):
            raise FoundError


@contextmanager
def doomed(results: Results, *victims: str, edits: tuple[str, ...] = ()) -> Iterator[Bench]:
    """Run a robot that is not worth an orderly shutdown."""
    with bench(results, *victims, edits=edits) as under_test:
        try:
            yield under_test
        finally:
            under_test.robot.popen.kill()


@pytest.mark.parametrize("broken", BROKEN, ids=lambda broken: broken.victim)
def test_a_robot_broken_on_purpose_is_found_out(broken: Broken):
    with (
        pytest.raises(FoundError),
        suppress(AssertionError),  # it may find that it cannot go on
        doomed(Awaiting(broken), broken.victim, edits=(broken.edit,)) as under_test,
    ):
        broken.scenario(under_test)


def test_work_in_a_callback_beside_the_emergency_stop_is_found_out(results: Results, monkeypatch: pytest.MonkeyPatch):
    patient = Bench.until
    monkeypatch.setattr(
        Bench, "until", lambda self, look, limit_s, what, **how: patient(self, look, min(limit_s, SOON_S), what, **how)
    )
    edit = "UPDATE capability SET kind = 'laborious_motors' WHERE robot = 'lbr' AND name = 'motors'"
    with (
        doomed(results, "laborious_motors", edits=(edit,)) as under_test,
        load.floods(under_test.robot),
        pytest.raises(AssertionError, match=r"not within .* the emergency stop acknowledged|does not drive"),
    ):
        estop.by_put(under_test)


def test_a_bus_that_is_open_to_everybody_is_found_out(results: Results, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("tests.support.robot.LBR", [sys.executable, str(VICTIMS / "open_bus.py")])
    with suppress(AssertionError), doomed(results) as under_test:
        roles.forbidden_keys(under_test)
    assert any("@console/admin at the local socket" in text for text in results.of("E5").violations)


@pytest.fixture(scope="module")
def careless() -> Iterator[Bench]:
    """A robot whose rows say what no robot should have; each test begins with results of its own."""
    with doomed(Results(PROMISES), edits=(CARELESS,)) as under_test:
        yield under_test


def drive(under_test: Bench, results: Results) -> None:
    under_test.results = results
    under_test.drive().cease()
    under_test.until(lambda: under_test.trace.now().zero, 3.0, "rest")


def test_a_lease_that_lives_too_long_is_found_out(careless: Bench, results: Results):
    careless.results = results
    clients.plain_client_killed(careless)
    assert results.of("S8").verdict == "broken"


def test_a_base_that_starts_too_suddenly_is_found_out(careless: Bench, results: Results):
    drive(careless, results)
    careless.check_limits()
    assert any("faster than" in text for text in results.of("F6").violations)


def test_an_output_above_the_limit_is_found_out(careless: Bench, results: Results):
    drive(careless, results)
    careless.check_limits(max_power=0.3)
    assert any("above 0.3" in text for text in results.of("F6").violations)


def has_a_stray(under_test: Bench) -> bool:
    """Say whether the stray capability has started its second process; a bench does not wait for that."""
    sleeps = 0
    for process in processes_of(under_test.robot.home):
        with suppress(psutil.Error):
            sleeps += process.cmdline()[:1] == ["sleep"]
    return sleeps > 1


def test_a_process_that_is_left_behind_is_found_out(results: Results):
    with bench(results, edits=(STRAY,)) as under_test:
        executive = psutil.Process(under_test.robot.popen.pid)
        under_test.until(lambda: has_a_stray(under_test), 5.0, "the process that will be left behind")
        reaper = next(child for child in executive.children() if any("reap.py" in word for word in child.cmdline()))
        executive.suspend()  # or it would start another
        reaper.kill()
        fault_ns = under_test.kill(executive.pid)
        left = kills.wait_until_gone(under_test, fault_ns, 2.0)
        under_test.robot.popen.wait(HANG_S)
    assert any("sleep" in name for name in left), left
