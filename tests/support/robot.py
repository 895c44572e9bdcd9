"""A whole robot for tests: `lbr run` in a home of its own, and a plain client on its bus."""

import os
import socket
import sqlite3
import subprocess
import sys
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

import msgspec
from msgspec.structs import replace

from lbr.operations.drive.settings import DEFAULT_RULES
from lbr.testing import robot as robots
from tests.support import databases, programs
from tests.support.waiting import HANG_S, until

LBR = [sys.executable, "-m", "lbr.start"]


BASE = ("motors", "ranges", "drive", "world")
"""What most tests need of the robot; the rest would only make every start slower."""
LEASE_S = 1.0
RULES = msgspec.json.encode([replace(rule, max_age_s=1.0) for rule in DEFAULT_RULES]).decode()
PATIENT = (
    f"""
    UPDATE capability SET settings = json_set(settings, '$.ttl_s', {LEASE_S}, '$.motors_max_age_s', 1.0,
    '$.attitude_max_age_s', 0.5, '$.rules', json('{RULES}')) WHERE robot = 'lbr' AND name = 'drive'
    """,
    "UPDATE capability SET settings = json_set(settings, '$.setpoint_valid_s', 0.25) WHERE robot = 'lbr' AND name = 'motors'",
)
"""For motions that end by a bound or a stop, not by a busy machine: it holds up who renews a lease and what a drive goes by
for 0.3 s, and a motor driver for more than 0.1 s, which then stops."""
PATIENT_SERVOS = f"""
    UPDATE capability SET settings = json_set(settings, iif(name = 'servos', '$.setpoint_valid_s', '$.ttl_s'),
    iif(name = 'servos', 0.25, {LEASE_S})) WHERE robot = 'bioloid' AND name IN ('joints', 'motions', 'servos')
"""
"""The same for the motions of the Bioloid's joints."""


def prepare(home: Path, *also: str, edits: tuple[str, ...] = (), whole: bool = False) -> Path:
    """Make a home with the shipped rows, whose world traces its motor outputs; the base runs, `also`, and after `edits`.

    `whole` leaves robots as they ship. Other robots than lbr run whole, unless an edit says otherwise (`only`); the
    Bioloid without its server, which most tests need not wait for, and none with a black box. What is served has a port of its own.
    """
    home.mkdir(mode=0o700, parents=True, exist_ok=True)
    databases.fresh(home / "robot.db")
    with sqlite3.connect(home / "robot.db") as database:
        trace = str(home / "trace.txt")
        database.execute(
            "UPDATE capability SET settings = json_set(settings, '$.trace', ?) WHERE robot = 'lbr' AND name = 'world'",
            (trace,),
        )
        if not whole:
            database.execute(only("lbr", *BASE, *also))
        for served in database.execute("SELECT robot, name FROM capability WHERE kind = 'web'").fetchall():
            database.execute(
                "UPDATE capability SET settings = json_set(settings, '$.port', ?, '$.announce', json('false'))"
                " WHERE robot = ? AND name = ?",
                (free_port(), *served),
            )
        if not whole and "web" not in also:
            database.execute("UPDATE capability SET enabled = 0 WHERE kind = 'web' AND robot = 'bioloid'")
        if not whole and "box" not in also:
            database.execute("UPDATE capability SET enabled = 0 WHERE kind = 'box'")
        for edit in edits:
            database.execute(edit)
    database.close()
    return home


def only(robot: str, *names: str) -> str:
    """Return the edit that leaves a robot these capabilities alone."""
    wanted = ", ".join(f"'{name}'" for name in names)
    return f"UPDATE capability SET enabled = 0 WHERE robot = '{robot}' AND name NOT IN ({wanted})"


def free_port() -> int:
    """Return a port of this machine that nobody has, now; each is given out once."""
    while True:
        with socket.socket() as found:
            found.bind(("127.0.0.1", 0))
            port = int(found.getsockname()[1])
        if port not in _given:
            _given.add(port)
            return port


_given: set[int] = set()


class Robot(robots.Robot):
    """A running robot. Motor outputs are read from the trace that the emulated controller writes."""

    def line(self, text: str, role: str = "admin") -> dict[str, Any]:
        """Say a line; one that a busy machine held up is said again, as its answer asks for."""
        return until(lambda: None if (said := self.say(text, role))["reason_code"] == "late" else said)

    def status(self) -> dict[str, Any]:
        """Return its status, asked for once."""
        status = self.ask("@status", timeout_s=HANG_S)
        assert status is not None, "the executive does not answer"
        return dict(status)

    def press(self, **how: Any) -> None:
        """Press the emergency stop; on a busy machine its acknowledgement comes after the answer, which waits half a second."""
        answer = self.line("estop", **how)
        assert answer["code"] == 0 or self.status()["estop"]["engaged"], answer

    def capability(self, name: str) -> dict[str, Any]:
        absent = {"name": name, "phase": "absent", "pid": None, "reason": "", "restarts": 0}
        return next((unit for unit in self.status()["capabilities"] if unit["name"] == name), absent)

    def events(self) -> list[dict[str, Any]]:
        return self.line("/report/events")["data"]

    def edit(self, sql: str, *parameters: Any) -> None:
        """Change the rows the way anybody does: with another SQLite client."""
        with closing(sqlite3.connect(self.home / "robot.db", timeout=5.0)) as database, database:
            database.execute(sql, parameters)

    @property
    def web(self) -> str:
        """Where it is served over HTTP: on a port of its own, whatever else runs on this machine."""
        return self.served("web")

    def served(self, name: str) -> str:
        """Return where one of its web servers is."""
        with sqlite3.connect(self.home / "robot.db") as database:
            query = "SELECT settings ->> '$.port' FROM capability WHERE kind = 'web' AND robot = ? AND name = ?"
            (port,) = database.execute(query, (self.name, name)).fetchone()
        database.close()
        return f"http://127.0.0.1:{port}"

    @property
    def trace(self) -> Path:
        return self.home / "trace.txt"


def environment(home: Path) -> dict[str, str]:
    return os.environ | {"LBR_HOME": str(home), "PYTHONUNBUFFERED": "1"}


def start(
    home: Path, *arguments: str, profile: str = "lbr-sim", limit_s: float = HANG_S, prefix: tuple[str, ...] = ()
) -> Robot:
    """Run a robot, by the program `prefix` if there is one, and wait for its ready line."""
    argv = programs.tied([*prefix, *LBR, "run", profile, "--no-console", *arguments])
    return Robot(home, *robots.started(argv, home, limit_s))


def lbr(home: Path, *arguments: str, stdin: str = "", limit_s: float = HANG_S) -> "subprocess.CompletedProcess[str]":
    """Run an `lbr` command to its end."""
    return programs.run(
        [*LBR, *arguments],
        env=environment(home),
        input=stdin,
        capture_output=True,
        text=True,
        timeout=limit_s,
        check=False,
    )


@contextmanager
def running(home: Path, *arguments: str, **options: Any) -> Iterator[Robot]:
    """Run a robot for the time of a `with`, and let no process outlive it."""
    robot = start(home, *arguments, **options)
    try:
        yield robot
    finally:
        robot.close()
