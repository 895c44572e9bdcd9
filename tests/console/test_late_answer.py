"""A motion whose answer came long after it was asked for does not begin: what somebody wanted then may be wrong now."""

import threading

import pytest

from lbr.console import operator
from lbr.console.operator import BusOperator
from tests.console.fake_robot import ROBOT
from tests.support.waiting import until


@pytest.mark.parametrize(("late", "code"), [(True, 1), (False, 0)])
def test_a_motion_whose_answer_is_late_is_stopped_and_not_held(robot, client, monkeypatch, late, code):
    monkeypatch.setattr(operator, "LATE_ANSWER_S", 0.2 if late else 30.0)
    robot.moves("/r/0.2/0", "L1")
    robot.blocked["/r/0.2/0"] = gate = threading.Event()
    said = BusOperator(client, ROBOT, "console@here", listen=False)
    threading.Timer(0.4, gate.set).start()
    result = said.submit("/r/0.2/0")
    assert result.code == code
    if late:
        assert "say it again" in result.text
        assert (robot.stopped, robot.renewed) == (["the answer came too late"], [])
    else:
        until(lambda: robot.renewed)
    said.close()
