"""D6: a robot that is told things, edited and killed; its audit trail stays whole and knows what was acknowledged."""

import os
import random
import signal
import time
from pathlib import Path

from lbr.database.rows import AuditRow
from lbr.database.store import Database
from tests.support.bench import Bench, let_go, temporary_home
from tests.support.figures import Results
from tests.support.robot import Robot, start

LONGEST_S = 0.15
ROUNDS = 6


def audits(results: Results, n: int, dice: random.Random) -> None:
    """D6: `n` lives of a robot, each ended by kill -9 in the middle of what it was told."""
    with temporary_home() as home:
        known = 0
        for _ in range(n):
            known = _life(results, home, known, dice)


def _life(results: Results, home: Path, known: int, dice: random.Random) -> int:
    """Run, tell things, kill; return how many entries the trail has, none of which may ever go."""
    robot = start(home)
    under_test = Bench(robot, results)
    told: list[tuple[str, str]] = []
    try:
        for number in range(ROUNDS):
            told += _tell(under_test, number, dice)
        under_test.pass_time(dice.uniform(0.0, LONGEST_S))
        os.kill(robot.popen.pid, signal.SIGKILL)
    finally:
        let_go(robot)
    return _judged(results, home, known, told)


def _tell(under_test: Bench, number: int, dice: random.Random) -> list[tuple[str, str]]:
    """Do something that must be in the trail; return what, once it was acknowledged."""
    robot = under_test.robot
    match dice.choice(("estop", "drive", "edit", "bad edit")):
        case "estop":
            text = f"press {number} {time.monotonic_ns()}"
            robot.line(f"/estop/{text}")
            robot.line("reset")
            return [("estop", text), ("estop_reset", "released")]
        case "drive":
            began = time.time_ns()
            mover = under_test.drive()
            mover.cease()
            robot.ask("drive/stop", {})
            under_test.until(lambda: _left(robot, began), 5.0, "the end of the drive told", every_s=0.02)
            return [("holder", "took the base"), ("holder", "lost the base")]
        case "edit":
            owner = f"owner {time.monotonic_ns()}"
            robot.edit("UPDATE robot SET owner = ?", owner)
            before = robot.status()["revision"]
            under_test.until(lambda: robot.status()["revision"] >= before, 2.0, "the edit seen")
            return []
        case _:
            robot.edit("UPDATE verb SET payload = '{\"nothing\": 1}' WHERE robot = 'lbr' AND word = 'f'")
            under_test.until(lambda: robot.status()["problems"], 3.0, "the refusal told", every_s=0.02)
            robot.edit(
                "UPDATE verb SET payload = '{\"power\": 0.25, \"angle_deg\": 0}' WHERE robot = 'lbr' AND word = 'f'"
            )
            under_test.until(lambda: not robot.status()["problems"], 3.0, "the rows good again", every_s=0.02)
            return [("rows_refused", "verb 'lbr/f")]


def _left(robot: Robot, since_ns: int) -> bool:
    return any("lost the base" in event["text"] and event["wall_ns"] >= since_ns for event in robot.events())


def _judged(results: Results, home: Path, known: int, told: list[tuple[str, str]]) -> int:
    with Database.open(home / "robot.db") as database:
        entries = database.audit(100_000)
        wrong = [*filter(None, [database.audit_fault()]), *_missing(entries[known:], told)]
    wrong += [f"{known} entries were there, now {len(entries)}"] if len(entries) < known else []
    results.check("D6", wrong)
    return len(entries)


def _missing(entries: tuple[AuditRow, ...], told: list[tuple[str, str]]) -> list[str]:
    kinds = [entry.kind for entry in entries]
    return [
        *(f"no {kind} with {text!r}" for kind, text in told if not any(_is(e, kind, text) for e in entries)),
        *([] if kinds[:1] == ["run"] else [f"a life begins with {kinds[:1]}"]),
    ]


def _is(entry: AuditRow, kind: str, text: str) -> bool:
    return entry.kind == kind and text in entry.text
