"""What differs from the shipped rows."""

from lbr.database.shipped import differences


def test_a_new_database_differs_in_nothing(database):
    assert differences(database) == ()


def test_added_removed_and_changed_rows_are_named(database, client):
    client.execute("INSERT INTO phrase VALUES ('ouch', 'en', 'Ouch.')")
    client.execute("DELETE FROM external_command WHERE name = 'clock'")
    client.execute("UPDATE channel SET rate_hz = 5 WHERE target = 'drive.motors'")
    assert [str(found) for found in differences(database)] == [
        "channel 'lbr/motors.state/drive.motors' changed: rate_hz: None -> 5.0",
        "external_command 'lbr/clock' removed",
        "phrase 'ouch/en' added",
    ]


def test_json_that_means_the_same_is_no_difference(database, client):
    client.execute("""UPDATE verb SET payload = '{"angle_deg":0,"power":0.25}' WHERE pattern = 'f'""")
    client.execute("""UPDATE verb SET payload = '{"angle_deg":0,"power":0.26}' WHERE pattern = 'b'""")
    (found,) = differences(database)
    assert (found.row, set(found.columns)) == ("lbr/b/b", {"payload"})


def test_running_the_robot_is_no_difference(database):
    database.record_start("lbr")
    database.set_estop("lbr", engaged=True, reason="x")
    assert differences(database) == ()


def test_revisions_since_a_number_tell_how_it_came_about(database, client):
    client.execute("UPDATE robot SET owner = 'a' WHERE name = 'lbr'")
    client.execute("UPDATE robot SET owner = 'b' WHERE name = 'lbr'")
    (second,) = database.revisions(since=1)
    assert (second.id, second.table, second.row_key, second.operation) == (2, "robot", ("lbr",), "update")
    assert (second.before["owner"], second.after["owner"]) == ("a", "b")
    assert second.changed_at.endswith("Z")
