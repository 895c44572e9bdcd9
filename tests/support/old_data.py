"""Synthetic files of robots' former programs, written from descriptions of their formats. None of them is an original."""

import sqlite3
from collections.abc import Mapping, Sequence
from contextlib import closing
from typing import Any

from lbr.robots.bioloid import mtn
from lbr.robots.bioloid.mtn import MtnFile, Page, Step

READY = (0, 235, 788, 279, 744, 462, 561, 358, 666, 507, 516, 341, 682, 240, 783, 647, 376, 507, 516)
"""The maker's ready pose by servo, from 1; what is at 0 says nothing."""
ENABLED = tuple(range(1, 19))

SCHEMA = """
CREATE TABLE robot (robot_id INTEGER PRIMARY KEY, name VARCHAR, type VARCHAR, url VARCHAR,
                    last_start_time TIMESTAMP, last_shutdown_time TIMESTAMP, owner VARCHAR);
CREATE TABLE robot_process (process_id INTEGER PRIMARY KEY, name VARCHAR, target VARCHAR);
CREATE TABLE channel (id INTEGER PRIMARY KEY, robot_id INTEGER, type VARCHAR);
CREATE TABLE message (name VARCHAR, language VARCHAR, text VARCHAR);
CREATE TABLE extcmd (id INTEGER PRIMARY KEY, robot_id INTEGER, cmd_name VARCHAR, target VARCHAR, args VARCHAR,
                     blocking BOOLEAN, stdin VARCHAR, stdout VARCHAR, stderr VARCHAR);
CREATE TABLE calibration (id INTEGER PRIMARY KEY AUTOINCREMENT, robot_id INTEGER REFERENCES robot, name TEXT, value FLOAT);
CREATE TABLE move_config (robot_id INT PRIMARY KEY, wheel_diameter REAL, m1_direction INT, m2_direction INT,
                          m3_direction INT, m4_direction INT, counts_per_rev INT) WITHOUT ROWID;
"""
ROWS: Mapping[str, Sequence[Sequence[Any]]] = {
    "robot": [
        (1, "lbr2a", "lbr", None, "2022-10-17 10:00:00", None, "A Person"),
        (2, "lbr6", "lbr", "", None, None, "A Person"),
    ],
    "robot_process": [(1, "Robot Operations", "ops"), (2, "Robot Http Service", "http")],
    "channel": [(1, 2, "Operations"), (5, 100, "Operations")],
    "message": [("Hello", "English", "Hello there")],
    "extcmd": [
        (1, 1, "navcam", "robapps/navcam/navcam.py", None, 0, None, None, None),
        (2, 2, "Tidy Up", "tools/tidy.sh", "all now", 1, None, "out.txt", None),
        (3, 2, "lost", "tools/lost.sh", None, 0, None, None, None),
        (4, 200, "navcam", "robapps/navcam/navcam-v4l.py", None, 0, None, None, None),
    ],
    "calibration": [
        (28, 1, "MAG_ALPHA", -18.5),
        (29, 1, "MAG_BETA", -15.0),
        (49, 1, "NEWCAL", 789.0),
        (43, 2, "MAG_ALPHA", -34.5),
        (44, 2, "MAG_BETA", 8.4),
        (45, 2, "MAG_COR0", 0.7),
        (46, 2, "MAG_COR1", -0.1),
        (47, 2, "MAG_COR2", -0.1),
        (48, 2, "MAG_COR3", 0.97),
    ],
    "move_config": [(1, 15.24, 1, 1, 0, 0, 0), (2, 18.5, -1, 1, 0, 1, 120)],
}


def _filled(rows: Mapping[str, Sequence[Sequence[Any]]]) -> sqlite3.Connection:
    connection = sqlite3.connect(":memory:")
    connection.executescript(SCHEMA)
    for table, of_table in rows.items():
        for row in of_table:
            connection.execute(f"INSERT INTO {table} VALUES ({', '.join('?' * len(row))})", row)
    connection.commit()
    return connection


def old_database(**changed: Sequence[Sequence[Any]]) -> bytes:
    """A database of the first lbr, with the rows of these tables in the place of the usual ones."""
    with closing(_filled({**ROWS, **changed})) as connection:
        return connection.serialize()


def old_sql(**changed: Sequence[Sequence[Any]]) -> str:
    """The same, written out as SQL."""
    with closing(_filled({**ROWS, **changed})) as connection:
        return "\n".join(connection.iterdump()) + "\n"


def step(time_s: float = 0.5, pause_s: float = 0.0, **moved: int) -> Step:
    """The ready pose with servos elsewhere: s13=300."""
    at = [*READY, *[0] * (mtn.SERVOS - len(READY))]
    for name, count in moved.items():
        at[int(name[1:])] = count
    return Step(tuple(at), pause_s, time_s)


def motion_file(*pages: Page) -> bytes:
    """A RoboPlus file of eighteen servos."""
    return mtn.write(MtnFile(pages, ENABLED))


BOW = (step(1.0), step(0.6, 0.2, s11=300, s12=723), step(0.6))
"""It leans ahead in the hips and comes up again."""
