"""Shipped rows come into a database that lacks them, and leave what is there alone."""

import pytest

from lbr.database import shipped
from lbr.database.difference import differences
from lbr.errors import InputError


def test_a_robot_that_an_older_database_lacks_is_added_whole(database, client):
    client.execute("DELETE FROM robot WHERE name = 'bioloid'")
    added = shipped.add(database, "bioloid")
    assert (added["robot"], added["joint"]) == (1, 18)
    assert differences(database) == ()
    assert database.load("bioloid").problems == ()


def test_rows_that_are_there_stay_as_they_are(database, client):
    client.execute("UPDATE joint SET speed_rps = 1.0 WHERE robot = 'bioloid' AND name = 'left_knee'")
    client.execute("DELETE FROM verb WHERE robot = 'bioloid' AND word = 'play'")
    assert list(shipped.add(database, "bioloid")) == ["verb"]
    assert [str(found) for found in differences(database)] == [
        "joint 'bioloid/left_knee' changed: speed_rps: 3.0 -> 1.0"
    ]
    assert shipped.add(database, "bioloid") == {}


def test_a_motion_that_somebody_shortened_is_not_mixed_with_the_shipped_one(database, client, tmp_path):
    steps = (
        "INSERT INTO motion_step (robot, motion, step, duration_s, positions) VALUES ('bioloid', 'nod', {}, 1, '{{}}')"
    )
    motion = "INSERT INTO motion (robot, name) VALUES ('bioloid', 'nod')"
    for statement in (motion, steps.format(1)):
        client.execute(statement)
    sql = tmp_path / "longer.sql"
    text = shipped.robot_db_sql().read_text(encoding="utf-8")
    end = text.rindex("COMMIT;")
    sql.write_text(f"{text[:end]}{motion};{steps.format(1)};{steps.format(2)};{text[end:]}")
    assert shipped.add(database, "bioloid", sql) == {}


def test_a_robot_that_does_not_ship_is_named(database):
    with pytest.raises(InputError, match="no robot 'c3po' ships with lbr: bioloid, lbr, uxa90 do"):
        shipped.add(database, "c3po")
