"""The executive's own words: those that rows may name are those that there are."""

from lbr.executive.dispatch import Dispatcher
from lbr.executive.wiring import EXECUTIVE_VERBS


def test_every_word_that_a_row_may_name_exists():
    assert set(Dispatcher(None, None, {})._built_in) == set(EXECUTIVE_VERBS)
