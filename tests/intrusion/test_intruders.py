"""Whoever wants more than they may: on the bus, at the console, in the rows, on the network. `python -m benchmarks security` does more."""

import pytest

from tests.intrusion import credentials, kinds, processes, programs, python_lines
from tests.intrusion.promises import PROMISES
from tests.support import needs
from tests.support.figures import Results


@pytest.fixture
def results():
    found = Results(PROMISES)
    yield found
    assert not found.violations()
    assert any(result.checks for result in found.by_figure.values())


def test_stolen_credentials_of_a_process_are_worth_its_wiring_and_no_more(results):
    credentials.credentials(results)


def test_python_runs_at_the_robots_own_terminal_and_is_audited(results):
    python_lines.python_lines(results)


def test_rows_that_name_code_import_nothing(results):
    kinds.kinds(results, ("os", "canary_module:KIND", "canary_point"))


def test_shell_signs_are_words_like_any_other(results):
    programs.programs(results, programs.WORDS[::3])


@needs.LOOKING_INSIDE
def test_processes_hold_no_privilege_and_nothing_that_is_anothers(results):
    processes.processes(results)
