"""Robots broken on purpose: what measures them must notice."""

import sys
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass

import pytest

from benchmarks.bench import VICTIMS, Bench, bench
from benchmarks.figures import Results
from benchmarks.promises import PROMISES
from benchmarks.scenarios import clients, estop, freezes, kills, load, resets, roles
from tests.safety.limits import over_their_limit

pytestmark = pytest.mark.timeout(30)

LONG_LEASE = """UPDATE capability SET settings = '{"ttl_s": 1.0}' WHERE robot = 'lbr' AND name = 'drive'"""
SUDDEN = """UPDATE capability SET settings = '{"accel_per_s": 40.0}' WHERE robot = 'lbr' AND name = 'drive'"""
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
        return f"UPDATE capability SET kind = '{self.victim}' WHERE robot = 'lbr' AND name = '{self.capability}'"


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


@pytest.mark.parametrize("broken", BROKEN, ids=lambda broken: broken.victim)
def test_a_robot_broken_on_purpose_is_found_out(results: Results, broken: Broken):
    with suppress(AssertionError), bench(results, broken.victim, edits=(broken.edit,)) as under_test:
        broken.scenario(under_test)  # which may find that it cannot go on, once it has measured
    assert any(broken.seen in text for text in results.of(broken.figure).violations)


def test_work_in_a_callback_beside_the_emergency_stop_is_found_out(results: Results):
    edit = "UPDATE capability SET kind = 'laborious_motors' WHERE robot = 'lbr' AND name = 'motors'"
    with (
        bench(results, "laborious_motors", edits=(edit,)) as under_test,
        load.floods(under_test.robot),
        pytest.raises(AssertionError, match=r"not within .* the emergency stop acknowledged|does not drive"),
    ):
        estop.by_put(under_test)


def test_a_bus_that_is_open_to_everybody_is_found_out(results: Results, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("tests.robot.LBR", [sys.executable, str(VICTIMS / "open_bus.py")])
    with suppress(AssertionError), bench(results) as under_test:
        roles.forbidden_keys(under_test)
    assert any("@console/admin at the local socket" in text for text in results.of("E5").violations)


def test_a_lease_that_lives_too_long_is_found_out(results: Results):
    with bench(results, edits=(LONG_LEASE,)) as under_test:
        clients.plain_client_killed(under_test)
    assert over_their_limit(results)
    assert results.of("S8").verdict == "broken"


def test_a_base_that_starts_too_suddenly_is_found_out(results: Results):
    with bench(results, edits=(SUDDEN,)) as under_test:
        under_test.drive().cease()
    assert any("faster than" in text for text in results.of("F6").violations)


def test_an_output_above_the_limit_is_found_out(results: Results):
    with bench(results) as under_test:
        under_test.drive().cease()
        under_test.check_limits(max_power=0.3)
    assert any("above 0.3" in text for text in results.of("F6").violations)


def test_a_process_that_is_left_behind_is_found_out(results: Results):
    with bench(results, edits=(STRAY,)) as under_test:
        fault_ns = under_test.kill(under_test.robot.popen.pid)
        left = kills.wait_until_gone(under_test, fault_ns, 2.0)
        under_test.robot.popen.wait(2.0)
    assert any("sleep" in name for name in left)
