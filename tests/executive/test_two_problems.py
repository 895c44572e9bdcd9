"""Two problems of one row are told at once, the second not only after the first is mended."""

import sqlite3
from contextlib import closing

import pytest

from lbr.database import store
from lbr.executive.planning import planner
from lbr.executive.planning.profile import Profile
from lbr.executive.planning.run_identity import RunIdentity
from tests.support import databases

SITE = RunIdentity(home="/nowhere", endpoints=("unixsock-stream//nowhere",), secret=b"s" * 32)


@pytest.fixture(scope="module")
def shipped(tmp_path_factory):
    path = tmp_path_factory.mktemp("database") / "robot.db"
    databases.fresh(path)
    return path


@pytest.fixture
def told(shipped, tmp_path):
    """Edit a copy of the shipped rows, and return what a start says of them."""
    path = tmp_path / "robot.db"
    path.write_bytes(shipped.read_bytes())
    path.chmod(0o600)

    def tell(*edits: str, profile: Profile | None = None) -> list[str]:
        with closing(sqlite3.connect(path)) as connection, connection:
            connection.execute("PRAGMA ignore_check_constraints = ON")
            for edit in edits:
                assert connection.execute(edit).rowcount == 1
        with store.Database.open(path) as database:
            rows = database.load("lbr")
        plan, found = planner.make(rows, profile or Profile(robot="lbr", simulate=True), SITE)
        assert plan is None
        return [str(one) for one in found]

    return tell


CAPABILITY = "INSERT INTO capability (robot, name, kind, settings, needs, restart) VALUES "
CHANNEL = "INSERT INTO channel (robot, source, target, history) VALUES "
VERB = "INSERT INTO verb (robot, word, pattern, target, payload, role) VALUES "

SETTINGS = '{"device": "motor_controller", "watchdog_ms": 900, "lefty": 3, "nonsense": 1}'
OF_SETTINGS = (
    "settings: watchdog_ms is at least 50 and at most 250, not 900 (kind 'roboteq')",
    "settings: Object contains unknown field `nonsense`, there is ",
    "settings: Object contains unknown field `lefty`, did you mean `left`?",
)


@pytest.mark.parametrize(
    ("edit", "label", "words"),
    [
        (f"{CAPABILITY} ('lbr', 'two', 'roboteq', '{SETTINGS}', '[]', 'never')", "capability 'lbr/two', ", OF_SETTINGS),
        (
            f"{CAPABILITY} ('lbr', 'Two', 'roboteq', '{SETTINGS}', '[\"gone\"]', 'perhaps')",
            "capability 'lbr/Two', ",
            (
                "name: 'Two' is not a name",
                "needs: there is no capability 'gone'",
                "restart: 'perhaps' is not one of",
                *OF_SETTINGS,
            ),
        ),
        (
            CAPABILITY + "('lbr', 'two', 'roboteq', '{\"device\": \"gone\", \"watchdog_ms\": 900}', '[]', 'never')",
            "capability 'lbr/two', ",
            ("settings: device: there is no device 'gone'", OF_SETTINGS[0]),
        ),
        (
            CAPABILITY + "('lbr', 'two', 'nothing_like_this', '{', '[]', 'never')",
            "capability 'lbr/two', ",
            ("settings: is not JSON", "kind: there is no kind 'nothing_like_this'"),
        ),
        (
            f"{CAPABILITY} ('lbr', 'two', 'roboteq', '{{}}', '[\"gone\"]', 'never')",
            "capability 'lbr/two', ",
            ("needs: there is no capability 'gone'", "settings: Object missing required field `device`"),
        ),
        (
            f"{CHANNEL} ('lbr', 'gone.readings', 'drive.tail', 1)",
            "channel 'lbr/gone.readings/drive.tail', ",
            ("source: there is no capability 'gone'", "target: 'drive' has no input 'tail'; it has "),
        ),
        (
            f"{CHANNEL} ('lbr', 'ranges.reading', 'gone.ranges', 99)",
            "channel 'lbr/ranges.reading/gone.ranges', ",
            (
                "source: 'ranges' has no output 'reading'; it has readings",
                "target: there is no capability 'gone'",
                "history: '99' is not a whole number from 1 to 64",
            ),
        ),
        (
            f"{CHANNEL} ('lbr', 'ranges', 'drive.tail', 1)",
            "channel 'lbr/ranges/drive.tail', ",
            ("source: 'ranges' is not of the form capability.port", "target: 'drive' has no input 'tail'"),
        ),
        (
            f"{VERB} ('lbr', 'fly', '/fly/{{a}}/{{a}}', 'drive.fly', NULL, 'king')",
            "verb 'lbr/fly//fly/{a}/{a}', ",
            (
                "pattern: '/fly/{a}/{a}': a field stands in it twice",
                "target: 'drive' has no command 'fly'",
                "role: 'king' is not one of view, operate, admin",
            ),
        ),
        (
            f"{VERB} ('lbr', 'q!', '', 'executive.fly', NULL, 'view')",
            "verb 'lbr/q!/', ",
            ("word: 'q!' is not a word", "pattern: is empty", "target: the executive has no 'fly'"),
        ),
        (
            f"{VERB} ('lbr', 'fly', '/fly/{{height}}', 'drive.command', '{{\"width\": 1}}', 'king')",
            "verb 'lbr/fly//fly/{height}', ",
            (
                "pattern: drive.command has no field 'height'",
                "payload: drive.command has no field 'width'",
                "role: 'king'",
            ),
        ),
        (
            "INSERT INTO external_command (robot, name, argv, arguments) VALUES ('lbr', 'X', '[]', '[[]]')",
            "external_command 'lbr/X', ",
            ("name: 'X' is not a name", "argv: names no program", "arguments: entry 1 is neither"),
        ),
        (
            "INSERT INTO joint (robot, name, device_id, lower_rad, upper_rad, speed_rps) VALUES ('lbr', 'X', 1, 2, 1, 0)",
            "joint 'lbr/X', ",
            ("name: 'X'", "upper_rad: 1 is not above lower_rad, 2", "speed_rps: 0 would never get anywhere"),
        ),
    ],
)
def test_all_problems_of_one_row_are_told_at_once(told, edit, label, words):
    found = [problem.removeprefix(label) for problem in told(edit)]
    assert [word for word in words if not any(problem.startswith(word) for problem in found)] == []
    assert len(found) == len(words)


def test_a_row_with_a_fault_is_there_for_those_who_name_it(told):
    joint = "INSERT INTO joint (robot, name, device_id, lower_rad, upper_rad, speed_rps) VALUES ('lbr', 'neck', 999, 0, 1, 1)"
    motion = "INSERT INTO motion (robot, name, limp) VALUES ('lbr', 'nod', 7)"
    step = "INSERT INTO motion_step (robot, motion, step, duration_s, positions) VALUES ('lbr', 'nod', 1, 1, '{\"neck\": 3}')"
    assert [problem.split(":")[0] for problem in told(joint, motion, step)] == [
        "joint 'lbr/neck', device_id",
        "motion 'lbr/nod', limp",
        "motion_step 'lbr/nod/1', positions",
    ]


def test_a_profile_may_name_a_capability_that_has_a_fault(told):
    edit = "UPDATE capability SET enabled = 7 WHERE robot = 'lbr' AND name = 'drive'"
    found = told(edit, profile=Profile(robot="lbr", simulate=True, without=("drive",), hosts={"pi": ("drive",)}))
    assert not [problem for problem in found if "there is no capability" in problem]


def test_a_program_whose_settings_are_wrong_is_not_told_of_its_ports_too(told):
    program = CAPABILITY + "('lbr', 'shell', 'exec', '{\"argv\": [], \"outputs\": [\"said\"]}', '[]', 'never')"
    (found,) = told(program, f"{CHANNEL} ('lbr', 'shell.said', 'drive.ranges', 1)")
    assert "settings: " in found
    assert "$.argv" in found
