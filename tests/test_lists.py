"""The lists that mark tests: nightly.txt and slow.txt."""

from tests.conftest import nameless


def test_each_line_of_the_lists_names_a_test(request):
    """In a whole run; the lists are read as the tests are collected."""
    assert request.config.stash[nameless] == []
