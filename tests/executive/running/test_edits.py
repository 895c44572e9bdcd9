"""A capability that rows wire to `executive.edit` changes rows of the running robot; nobody else does."""

import sqlite3
from pathlib import Path

import msgspec
import pytest
from msgspec.structs import replace

from lbr.database.rows import ChannelRow
from lbr.executive.planning import plan as plans
from lbr.executive.planning import rights
from lbr.executive.planning.profile import Profile
from lbr.messages.faces import Motor
from lbr.messages.rows import by_table
from tests.support import databases
from tests.support.planning import planned, problems, shipped
from tests.support.robot import Robot
from tests.support.waiting import until

MOTOR = {"layer": "mine", "id": 3, "name": "neck", "initial": 1, "lowest": 0, "highest": 9, "rest": 1}
NOD = {"motion": "nod", "step": 1, "positions": {"neck": 0.5}, "duration_s": 1.0}
EDITS = (
    "INSERT INTO joint (robot, name, device_id, lower_rad, upper_rad, speed_rps) VALUES ('lbr', 'neck', 3, -1, 1, 1)",
    "INSERT INTO capability (robot, name, kind) VALUES ('lbr', 'face', 'editor'), ('lbr', 'other', 'onlooker')",
    "INSERT INTO channel (robot, source, target) VALUES ('lbr', 'face.edit', 'executive.edit')",
)


@pytest.fixture(scope="module")
def two(robot):
    """A capability that edits rows, and another that has some of them."""
    source = Path(__file__).with_name("editor.py").read_text()
    (robot.home / "capabilities" / "editor.py").write_text(source)
    (robot.home / "capabilities" / "onlooker.py").write_text(source + "\nKIND = ONLOOKER\n")
    databases.edit(robot.home / "robot.db", f"BEGIN; {'; '.join(EDITS)}; COMMIT")
    until(lambda: {robot.capability(name)["phase"] for name in ("face", "other")} == {"ready"})


def write(robot: Robot, rows: dict, **edit):
    return robot.ask("face/write", {"rows": rows, **edit}, timeout_s=8.0)


@pytest.mark.usefixtures("two")
def test_an_edit_is_written_and_only_others_restart_for_it(robot):
    face, other = robot.capability("face")["pid"], robot.capability("other")["pid"]
    reply = write(robot, {"motor": [MOTOR], "motion": [{"name": "nod"}], "motion_step": [NOD]}, create=True, by="phone")
    assert reply["accepted"], reply
    until(lambda: robot.ask("face/known") == {"motors": ["neck"], "motions": ["nod"]})
    until(lambda: robot.capability("other")["pid"] not in {other, None}, what="who has motions restarts")
    until(lambda: (robot.ask("other/known") or {}).get("motions") == ["nod"])
    assert robot.capability("face")["pid"] == face
    until(lambda: robot.status()["revision"] == reply["revision"])
    texts = {event["kind"]: event["text"] for event in robot.events() if event["kind"] in {"edit", "rows_changed"}}
    assert texts["edit"] == "wrote motor 3 of layer 'mine', motion 'nod' for phone"
    assert "insert motion 'nod'" in texts["rows_changed"]
    assert "restart other" in texts["rows_changed"]
    told = "SELECT subject FROM audit WHERE kind = 'edit' AND text LIKE '%phone%'"
    ((who,),) = databases.asked(robot.home / "robot.db", told)
    assert who == "face"


@pytest.mark.usefixtures("two")
def test_a_refusal_is_a_sentence_with_the_newest_revision_and_nothing_changes(robot):
    before = robot.status()["revision"]
    far = {"motion": [{"name": "far"}], "motion_step": [{**NOD, "motion": "far", "positions": {"neck": 5.0}}]}
    for edit, why in (
        ({"rows": {"motor": [{**MOTOR, "id": 4}]}}, "there is no motor 4 of layer 'mine'"),
        ({"rows": {"motor": [{**MOTOR, "id": 4}], **far}, "create": True}, "the joint's limits"),
        ({"rows": {"motor": [{**MOTOR, "id": 4, "layer": "NOT A NAME"}]}, "create": True}, "layer"),
        ({"rows": {"capability": [{"name": "shell", "kind": "exec"}]}, "create": True}, "not for it to write"),
    ):
        reply = write(robot, **edit)
        assert not reply["accepted"]
        assert why in reply["reason"]
    assert robot.status()["revision"] == before


@pytest.mark.usefixtures("two")
def test_whoever_is_not_wired_is_not_heard(robot):
    assert robot.ask("@edit", {"rows": {"motor": [MOTOR]}}, source="face", timeout_s=0.3) is None
    answer = until(lambda: robot.ask("other/write", {"rows": {"motor": [MOTOR]}}), what="it has restarted")
    assert answer["reason"] == "not wired"


@pytest.mark.usefixtures("two")
def test_a_database_that_is_locked_holds_up_the_edit_and_nothing_else(robot):
    with sqlite3.connect(robot.home / "robot.db", isolation_level=None) as other:
        other.execute("BEGIN IMMEDIATE")
        pending = robot.bus.get(
            f"{robot.name}/face/write",
            payload=b'{"rows": {"motor": [{"layer": "mine", "id": 8, "name": "x", "initial": 1, '
            b'"lowest": 0, "highest": 9, "rest": 1}]}, "create": true}',
            timeout=8.0,
        )
        for _ in range(5):
            assert robot.status()["ready"]
        other.execute("ROLLBACK")
    other.close()
    assert b'"accepted":true' in next(iter(pending)).ok.payload.to_bytes().replace(b" ", b"")


# -- plans --------------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def rows():
    return shipped("uxa90")


def test_rows_alone_give_the_right_to_edit(rows):
    plan = planned(rows)
    may = {name: rights.of_unit(plan, unit).values() for name, unit in plan.units.items()}
    asking = {name for name, each in may.items() if any("uxa90/@edit" in one.ask for one in each)}
    assert asking == {"web"}
    assert "uxa90/@edit" not in rights.of_local(plan).ask
    unwired = replace(rows, channels=tuple(row for row in rows.channels if row.source != "web.edit"))
    assert planned(unwired).units["web"].config.requests.get("edit") is None


@pytest.mark.parametrize(
    ("source", "target", "why"),
    [
        ("web.move", "executive.edit", "web.move sends JointsCommand, and executive.edit takes EditCommand"),
        ("web.edit", "executive.reset", "'executive' has no command 'reset'; it has edit"),
        ("web.state", "executive.edit", "'executive' has no input 'edit'; it has none"),
    ],
)
def test_a_wrong_channel_to_the_executive_is_named(rows, source, target, why):
    bad = replace(rows, channels=(*rows.channels, ChannelRow(source=source, target=target)))
    assert any(why in text for text in problems(bad))


def test_who_edits_stays_on_the_robots_own_host(rows):
    profile = Profile(robot="uxa90", simulate=True, hosts={"laptop": ("web",)})
    assert any("it may change rows" in text for text in problems(rows, profile))


def test_who_has_made_an_edit_its_own_is_not_restarted_by_rows_that_say_the_same(rows):
    motor = Motor(layer="mine", id=1, name="one", initial=1, lowest=0, highest=2, rest=1)
    plan = planned(rows)
    again = plans.learnt(plan, "web", by_table((motor,)))
    assert plans.difference(plan, again).restart == ("web",)
    assert motor in msgspec.json.decode(again.units["web"].config.rows["motor"].rows, type=list[Motor])
