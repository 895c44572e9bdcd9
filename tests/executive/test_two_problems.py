"""Two problems of one row are told at once, the second not only after the first is mended."""

import pytest

from lbr.executive.planning.profile import Profile
from tests.support.planning import problems, shipped


def told(*edits: str, profile: Profile | None = None) -> list[str]:
    """Return what a start says of the shipped rows after these edits."""
    return problems(shipped("lbr", "PRAGMA ignore_check_constraints = ON", *edits), profile)


CAPABILITY = "INSERT INTO capability (robot, name, kind, settings, needs, restart) VALUES "
CHANNEL = "INSERT INTO channel (robot, source, target, history) VALUES "
VERB = "INSERT INTO verb (robot, word, pattern, target, payload, role) VALUES "

SETTINGS = '{"device": "motor_controller", "watchdog_ms": 900, "lefty": 3, "nonsense": 1}'


@pytest.mark.parametrize(
    "edit",
    [
        f"{CAPABILITY} ('lbr', 'two', 'roboteq', '{SETTINGS}', '[]', 'never')",
        f"{CAPABILITY} ('lbr', 'Two', 'roboteq', '{SETTINGS}', '[\"gone\"]', 'perhaps')",
        CAPABILITY + "('lbr', 'two', 'roboteq', '{\"device\": \"gone\", \"watchdog_ms\": 900}', '[]', 'never')",
        CAPABILITY + "('lbr', 'two', 'nothing_like_this', '{', '[]', 'never')",
        f"{CAPABILITY} ('lbr', 'two', 'roboteq', '{{}}', '[\"gone\"]', 'never')",
        f"{CHANNEL} ('lbr', 'gone.readings', 'drive.tail', 1)",
        f"{CHANNEL} ('lbr', 'ranges.reading', 'gone.ranges', 99)",
        f"{CHANNEL} ('lbr', 'ranges', 'drive.tail', 1)",
        f"{VERB} ('lbr', 'fly', '/fly/{{a}}/{{a}}', 'drive.fly', NULL, 'king')",
        f"{VERB} ('lbr', 'q!', '', 'executive.fly', NULL, 'view')",
        f"{VERB} ('lbr', 'fly', '/fly/{{height}}', 'drive.command', '{{\"width\": 1}}', 'king')",
        "INSERT INTO external_command (robot, name, argv, arguments) VALUES ('lbr', 'X', '[]', '[[]]')",
        "INSERT INTO joint (robot, name, device_id, lower_rad, upper_rad, speed_rps) VALUES ('lbr', 'X', 1, 2, 1, 0)",
    ],
)
def test_all_problems_of_one_row_are_told_at_once(edit, wording):
    wording(*told(edit))


def test_a_row_with_a_fault_is_there_for_those_who_name_it():
    joint = "INSERT INTO joint (robot, name, device_id, lower_rad, upper_rad, speed_rps) VALUES ('lbr', 'neck', 999, 0, 1, 1)"
    motion = "INSERT INTO motion (robot, name, limp) VALUES ('lbr', 'nod', 7)"
    step = "INSERT INTO motion_step (robot, motion, step, duration_s, positions) VALUES ('lbr', 'nod', 1, 1, '{\"neck\": 3}')"
    assert [problem.split(":")[0] for problem in told(joint, motion, step)] == [
        "joint 'lbr/neck', device_id",
        "motion 'lbr/nod', limp",
        "motion_step 'lbr/nod/1', positions",
    ]


def test_a_profile_may_name_a_capability_that_has_a_fault():
    edit = "UPDATE capability SET enabled = 7 WHERE robot = 'lbr' AND name = 'drive'"
    found = told(edit, profile=Profile(robot="lbr", simulate=True, without=("drive",), hosts={"pi": ("drive",)}))
    assert not [problem for problem in found if "there is no capability" in problem]


def test_a_program_whose_settings_are_wrong_is_not_told_of_its_ports_too():
    program = CAPABILITY + "('lbr', 'shell', 'exec', '{\"argv\": [], \"outputs\": [\"said\"]}', '[]', 'never')"
    (found,) = told(program, f"{CHANNEL} ('lbr', 'shell.said', 'drive.ranges', 1)")
    assert "settings: " in found
    assert "$.argv" in found
