"""The executive's own words: those that rows may name are those that there are."""

from types import SimpleNamespace

import pytest

from lbr.console.verbs import Vocabulary
from lbr.database.rows import BUILT_IN_VERBS
from lbr.errors import InputError
from lbr.executive.planning.wiring import EXECUTIVE_ROLES, EXECUTIVE_VERBS
from lbr.executive.service.dispatch import Dispatcher


def test_every_word_that_a_row_may_name_exists():
    assert set(Dispatcher(None, None, {})._built_in) == set(EXECUTIVE_VERBS)


def test_a_robot_that_moves_nothing_says_so_when_it_is_stopped():
    plan = SimpleNamespace(robot="lamp", stoppable=tuple)
    words = Vocabulary([])
    dispatcher = Dispatcher(SimpleNamespace(plan=plan, vocabulary=words, record=lambda *_: None), None, {})
    for line in ("s", "S", "stop", "/stop"):
        result = dispatcher.execute(line, source="console", role="view")
        assert (result.code, result.text) == (
            0,
            "nothing of this robot moves by commands: there is nothing to stop",
        )


def test_each_has_a_least_role():
    assert set(EXECUTIVE_ROLES) == set(EXECUTIVE_VERBS)


def test_the_words_of_every_robot_have_the_roles_of_what_they_ask_for():
    assert all(row.role == EXECUTIVE_ROLES[row.target_end[1]] for row in BUILT_IN_VERBS)


def test_what_waits_for_a_machine_that_is_not_there_is_not_said_to_start_anew():
    away = SimpleNamespace(name="motions", host="operator", phase="waiting", reason="waits for host 'operator'")
    robot = SimpleNamespace(
        plan=SimpleNamespace(units={"motions": None}), status=lambda: SimpleNamespace(capabilities=(away,))
    )
    restart = Dispatcher(robot, None, {})._built_in["restart"]
    with pytest.raises(InputError, match="'motions' does not run: waits for host 'operator'"):
        restart(SimpleNamespace(payload={"name": "motions"}), "console")
