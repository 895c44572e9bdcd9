"""The golden file of sentences: what differs fails, and nothing in it is left of tests that are gone."""

import pytest

from tests.support.wording import Wording, read, stands


def test_each_entry_is_of_a_test_that_compares_it():
    assert not [(module, name) for module, tests in read().items() for name in tests if not stands(module, name)]


@pytest.mark.parametrize("golden", [[], ["a robot"], ["another"], ["a robot", "another"]])
def test_a_sentence_that_is_not_the_next_one_of_the_file_fails(golden):
    found = Wording(golden, {})
    with pytest.raises(AssertionError):
        found("a robot", "stands")


def test_what_is_another_one_in_each_run_is_named_and_a_code_comes_first():
    found = Wording(["bad_value: home/a at (time)", "b"], {"/tmp/x1": "home"})
    error = ValueError("/tmp/x1/a at 2026-01-01T00:00:00.000Z\n\nb")
    error.code = "bad_value"
    found(error)
