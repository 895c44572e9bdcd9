"""Robots broken on purpose: what measures them must notice."""

import pytest

from benchmarks.bench import bench
from benchmarks.figures import Results
from benchmarks.promises import PROMISES
from benchmarks.scenarios import clients, kills
from tests.safety.limits import over_their_limit

pytestmark = pytest.mark.timeout(30)

DEAF = "UPDATE capability SET kind = 'deaf_motors' WHERE robot = 'lbr' AND name = 'motors'"
EAGER = "UPDATE capability SET kind = 'eager_drive' WHERE robot = 'lbr' AND name = 'drive'"
LONG_LEASE = """UPDATE capability SET settings = '{"ttl_s": 1.0}' WHERE robot = 'lbr' AND name = 'drive'"""
SUDDEN = """UPDATE capability SET settings = '{"accel_per_s": 40.0}' WHERE robot = 'lbr' AND name = 'drive'"""
STRAY = """INSERT INTO capability (robot, name, kind, settings, help) VALUES
    ('lbr', 'stray', 'exec', '{"argv": ["/bin/sh", "-c", "setsid sleep 20 & exec sleep 20"]}', 'Leaves a process')"""


@pytest.fixture
def results() -> Results:
    return Results(PROMISES)


def test_a_driver_that_ignores_its_leases_is_found_out(results: Results):
    with bench(results, "deaf_motors", edits=(DEAF,)) as under_test:
        kills.kill_process(under_test, "drive", "S3")
    assert any("still turn" in text for text in results.of("S3").violations)


def test_operations_that_go_on_after_their_death_are_found_out(results: Results):
    with bench(results, "eager_drive", edits=(EAGER,)) as under_test:
        kills.kill_process(under_test, "drive", "S3")
    assert any("after the stop" in text for text in results.of("S14").violations)


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
