"""The executive's own words: those that rows may name are those that there are."""

from types import SimpleNamespace

import pytest

from lbr.errors import InputError
from lbr.executive.dispatch import Dispatcher
from lbr.executive.wiring import EXECUTIVE_VERBS


def test_every_word_that_a_row_may_name_exists():
    assert set(Dispatcher(None, None, {})._built_in) == set(EXECUTIVE_VERBS)


def test_what_waits_for_a_machine_that_is_not_there_is_not_said_to_start_anew():
    away = SimpleNamespace(name="motions", host="operator", phase="waiting", reason="waits for host 'operator'")
    robot = SimpleNamespace(
        plan=SimpleNamespace(units={"motions": None}), status=lambda: SimpleNamespace(capabilities=(away,))
    )
    restart = Dispatcher(robot, None, {})._built_in["restart"]
    with pytest.raises(InputError, match="'motions' does not run: waits for host 'operator'"):
        restart(SimpleNamespace(payload={"name": "motions"}), "console")
