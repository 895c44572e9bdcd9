"""Rows, audit trail and latch under kills, damage, bad edits and a full disk; the benchmark does the same at length."""

import random
from collections.abc import Callable

import pytest

from tests.safety.limits import holds
from tests.scenarios import data_audit, data_damage, data_disk, data_kills, data_life, data_mutations
from tests.scenarios.data_promises import PROMISES
from tests.support.figures import Results
from tests.support.small_disk import can_mount

SEED = 1


@pytest.fixture(autouse=True)
def own_home(tmp_path, monkeypatch):
    monkeypatch.setenv("LBR_HOME", str(tmp_path / "home"))


def held(scenario: Callable[[Results], None]) -> Results:
    return holds(scenario, PROMISES)


def test_a_killed_writer_loses_nothing_that_was_acknowledged():
    assert held(lambda results: data_kills.kills(results, 12, random.Random(SEED))).of("D1").n == 13


def test_whatever_stands_in_the_rows_is_refused_by_name_or_as_meant():
    assert held(lambda results: data_mutations.mutations(results, 110, random.Random(SEED))).of("D2").n > 75


def test_a_damaged_database_is_refused_or_the_very_same():
    results = held(lambda results: data_damage.damages(results, 60, random.Random(SEED)))
    assert results.of("D4").n > 100
    assert results.of("D4 restore").n == 4


def test_the_audit_trail_of_a_killed_robot_is_whole():
    assert held(lambda results: data_audit.audits(results, 1, random.Random(SEED))).of("D6").n == 1


def test_a_database_that_breaks_under_a_robot_costs_neither_motion_nor_latch():
    assert held(data_life.broken_under_a_robot).of("E2").n == 1


def test_a_locked_database_holds_up_no_stop():
    assert held(data_disk.locked).of("E6 locked").n == 1


def test_a_full_disk_holds_up_no_stop_and_is_got_over():
    if not can_mount():
        pytest.skip("needs the right to mount a small disk")
    assert held(data_disk.full_disk).of("E6 full").n == 1
