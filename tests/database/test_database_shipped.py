"""Shipped rows come into a database that lacks them, and leave what is there alone."""

from lbr.database import shipped
from lbr.database.shipped import differences
from lbr.errors import InputError


def test_a_robot_that_an_older_database_lacks_is_added_whole(database, client):
    client.execute("DELETE FROM robot WHERE name = 'bioloid'")
    added = shipped.add(database, "bioloid")
    assert (added["robot"], added["joint"]) == (1, 18)
    assert differences(database) == ()
    assert database.load("bioloid").problems == ()


def test_rows_that_are_there_stay_as_they_are(database, client):
    client.execute("UPDATE joint SET speed_rps = 1.0 WHERE robot = 'bioloid' AND name = 'left_knee'")
    client.execute("DELETE FROM motion WHERE robot = 'bioloid' AND name = 'wave'")
    assert shipped.add(database, "bioloid") == {"motion": 1, "motion_step": 8}
    assert [str(found) for found in differences(database)] == [
        "joint 'bioloid/left_knee' changed: speed_rps: 3.0 -> 1.0"
    ]
    assert shipped.add(database, "bioloid") == {}


def test_a_motion_that_was_shortened_is_not_mixed_with_the_shipped_one(database, client):
    client.execute("DELETE FROM motion_step WHERE robot = 'bioloid' AND motion = 'wave' AND step > 1")
    assert shipped.add(database, "bioloid") == {}


def test_of_a_robot_that_is_not_there_at_all_only_that_differs(database, client):
    client.execute("DELETE FROM robot WHERE name = 'bioloid'")
    assert [str(found) for found in differences(database)] == ["robot 'bioloid' removed"]


def test_the_robot_with_the_schema_is_added_from_there(database, client):
    client.execute("DELETE FROM robot WHERE name = 'lbr'")
    assert shipped.add(database, "lbr")["robot"] == 1
    assert differences(database) == ()


def test_a_robot_that_does_not_ship_is_named(database, wording):
    with wording.of(InputError):
        shipped.add(database, "c3po")
