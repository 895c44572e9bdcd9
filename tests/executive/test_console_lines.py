"""Lines that a row has a capability say are looked at before anything runs, and are said with the rights of who operates."""

import pytest

from lbr.executive.planning import rights
from tests.support.planning import planned, problems, shipped

ON = "UPDATE capability SET enabled = 1, settings = json_set('{{}}', '$.lines', json('{}')) WHERE name = 'teleop'"
PAD = (
    "INSERT INTO device (robot, name, type, address) VALUES ('lbr', 'pad', 'gamepad', '/dev/input/by-id/usb-pad')",
    "INSERT INTO capability (robot, name, kind, settings) VALUES ('lbr', 'gamepad', 'gamepad', '{\"device\": \"pad\"}')",
)


def rows(lines: str, *edits: str):
    """Return the rows of lbr with a gamepad whose buttons say these lines."""
    return shipped("lbr", *PAD, *edits, ON.format(lines))


def test_lines_that_the_robot_understands_are_said_on_the_console_s_key():
    plan = planned(rows('{"y": "/s/hello", "x": "s", "a": "/r/0.2/0"}'))
    assert plan.units["teleop"].config.requests["say"] == {"executive": "lbr/@console"}
    assert "lbr/@console" in rights.of_unit(plan, plan.units["teleop"])["teleop"].ask
    assert "lbr/@console" not in rights.of_unit(plan, plan.units["gamepad"])["gamepad"].ask


@pytest.mark.parametrize(
    ("lines", "fault"),
    [
        ('{"y": "/sya/hello"}', "lines.y: '/sya' is not a word of this robot"),
        ('{"y": "/r/7/0"}', "lines.y: power"),
        ('{"y": "!print(1)"}', "lines.y: it has no line, or it has Python"),
        ('{"y": "Shutdown"}', "lines.y: 'Shutdown' needs the role admin"),
    ],
)
def test_a_line_that_cannot_be_said_is_refused_with_its_button(lines, fault):
    (problem,) = problems(rows(lines))
    assert fault in str(problem)
    assert "lbr/teleop" in str(problem)


def test_lines_need_a_channel_row_to_the_executive():
    cut = "DELETE FROM channel WHERE source = 'teleop.say'"
    (problem,) = problems(rows('{"y": "/s/hello"}', cut))
    assert "a channel row from teleop.say to executive.line is needed" in str(problem)
    assert "teleop" in planned(rows("{}", cut)).units
