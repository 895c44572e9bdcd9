"""Which robots run from a database."""

import sqlite3
from contextlib import closing

import pytest

from lbr.database.claims import Claim, any_robot
from lbr.errors import AlreadyRunningError


def test_the_rows_of_a_robot_are_run_from_one_home_alone(tmp_path):
    database = tmp_path / "robot.db"
    with closing(sqlite3.connect(database)) as connection:
        connection.execute("PRAGMA journal_mode = WAL")
        connection.execute("CREATE TABLE row (a)")
        first, second, other = Claim("lbr"), Claim("lbr"), Claim("bioloid")
        assert not any_robot(database)
        first.take(database)
        with pytest.raises(AlreadyRunningError, match=f"'lbr' already runs from {database}, in another home"):
            second.take(database)
        other.take(database)
        assert any_robot(database)
        connection.execute("INSERT INTO row VALUES (1)")
        connection.commit()
        first.release()
        second.release()
        second.take(database)
        for claim in (second, other):
            claim.release()
        assert not any_robot(database)
