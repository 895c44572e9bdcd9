"""Measures whether `lbr at` gives the robot's own answers: why, status and rows at sampled moments of running robots.

`python -m benchmarks then --n 100 --robots lbr,bioloid,uxa90`. Faults and changes are made and undone, some by a kill;
after each, the robot is asked live. Once the box has that time, `lbr at` is asked for the moment before the answer and
the one after it. One of these two must be equal.
"""

import argparse
import json
import random
import sqlite3
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import datetime
from typing import Any

from msgspec import Struct

from benchmarks import Measured, listed
from lbr.apps.recorder.recording import selection
from lbr.apps.recorder.recording.shelf import Shelf
from tests.support.bench import Bench, let_go, temporary_home
from tests.support.figures import Promise, Results
from tests.support.robot import lbr, start

SMOKE = "--n 2 --robots lbr"
PROMISES = {
    "T1": Promise(what="moments at which `at … why` says something else than was answered", hard=0),
    "T2": Promise(what="moments at which `at … status` shows a process otherwise than it was", hard=0),
    "T3": Promise(what="moments at which `at … rows` has other rows than there were", hard=0),
    "T4": Promise(what="one `lbr at TIME why`"),
}
IN_BOX_S = 2.0
"""A chunk is written each second."""
PARTS = {
    "lbr": ("drive", "motors", "dock", "camera_front"),
    "bioloid": ("left_knee", "joints", "motions"),
    "uxa90": ("left_knee", "motions"),
}
LINES = {
    "lbr": ("/l/0.3/200", "/r/0.3/0", "stop", "estop", "reset", "disable", "enable", "/camera/off", "/camera/front", "/restart/drive"),
    "bioloid": ("/torque/on", "/torque/off", "/play/wave", "stop", "estop", "reset", "/restart/joints"),
    "uxa90": ("/torque/on", "/play/basic_motion", "stop", "estop", "reset", "/restart/motions"),
}  # fmt: skip
KILLED = {"lbr": ("drive", "motors", "ranges"), "bioloid": ("joints", "servos"), "uxa90": ("motions",)}
HELP = "UPDATE capability SET help = 'told at {}' WHERE robot = '{}' AND name = 'world'"


class Sample(Struct, kw_only=True):
    """A moment: begin and end of the question, its part, and the answer."""

    did: str
    begun_ns: int
    ended_ns: int
    part: str
    why: dict[str, Any]
    status: dict[str, Any]
    rows: list[dict[str, Any]]


def options(parser: argparse.ArgumentParser) -> None:
    """Add the number, and the robots."""
    parser.add_argument("--n", type=int, default=100, help="moments, of all robots together (default %(default)s)")
    parser.add_argument("--robots", type=listed, default=["lbr", "bioloid", "uxa90"], metavar="lbr,bioloid,uxa90")
    parser.add_argument("--seed", type=int, default=1, help="of chance (default %(default)s)")


def measure(given: argparse.Namespace) -> Measured:
    """Sample each robot, and ask for these moments."""
    results = Results(PROMISES)
    text: list[str] = []
    for place, robot in enumerate(given.robots):
        count = given.n * (place + 1) // len(given.robots) - given.n * place // len(given.robots)
        with _running(robot, results, random.Random(f"{given.seed} {robot}")) as under:
            samples = [_sample(under, robot) for _ in range(count)]
            under.pass_time(IN_BOX_S)
            for one in samples:
                text += _judge(under, one, results)
    return Measured(results=results.ordered(), text="\n".join(text))


@contextmanager
def _running(robot: str, results: Results, dice: random.Random) -> Iterator[Bench]:
    with temporary_home(whole=True) as home:
        under = Bench(start(home, profile=f"{robot}-sim", limit_s=60.0), results, dice=dice)
        try:
            shelf = Shelf(home, robot)
            under.until(
                lambda: "@status" in {one.topic for one in selection.messages(shelf.files())},
                15.0,
                "the box",
                every_s=0.1,
            )
            yield under
        finally:
            let_go(under.robot)


def _sample(under: Bench, robot: str) -> Sample:
    """Change something, wait, and ask."""
    did = _something(under, robot)
    under.pass_time(under.dice.uniform(0.3, 2.5))
    part = under.dice.choice(PARTS[robot])
    begun_ns = time.time_ns()
    why = under.robot.line(f"/why/{part}")["data"]
    status = under.answer("@status")
    rows = _rows(under, robot)
    return Sample(did=did, begun_ns=begun_ns, ended_ns=time.time_ns(), part=part, why=why, status=status, rows=rows)


def _something(under: Bench, robot: str) -> str:
    dice = under.dice
    match dice.randrange(6):
        case 0:
            under.kill(under.pid(name := dice.choice(KILLED[robot])))
            return f"kill -9 {name}"
        case 1:
            under.robot.edit(HELP.format(time.monotonic_ns(), robot))
            return "an edit"
        case _:
            under.robot.line(line := dice.choice(LINES[robot]))
            return line


def _rows(under: Bench, robot: str) -> list[dict[str, Any]]:
    """Return the rows of all capabilities from SQLite."""
    with sqlite3.connect(under.robot.home / "robot.db") as database:
        database.row_factory = sqlite3.Row
        found = database.execute("SELECT * FROM capability WHERE robot = ? ORDER BY name", (robot,)).fetchall()
    return [dict(one) for one in found]


def _judge(under: Bench, sample: Sample, results: Results) -> Iterator[str]:
    """Ask for the two moments; yield the differences."""
    why = [_first(_then(under, at_ns, results, "why", sample.part)) for at_ns in (sample.begun_ns, sample.ended_ns)]
    status = [_processes(_then(under, at_ns, results, "status")) for at_ns in (sample.begun_ns, sample.ended_ns)]
    rows = [_then(under, at_ns, results, "rows", "capability") for at_ns in (sample.begun_ns, sample.ended_ns)]
    for figure, live, then in (
        ("T1", _first(sample.why), why),
        ("T2", _processes(sample.status), status),
        ("T3", _by_name(sample.rows), [_by_name(one["tables"]["capability"]) for one in rows]),
    ):
        text = (
            ""
            if live in then
            else f"{figure} after {sample.did} ({sample.part}): {_other(live, then[-1])} live, {_other(then[-1], live)} then"
        )
        results.check(figure, [text] if text else [])
        if text:
            print(text, file=sys.stderr, flush=True)
            yield text


def _then(under: Bench, at_ns: int, results: Results, *words: str) -> dict[str, Any]:
    when = datetime.fromtimestamp(at_ns / 1e9).astimezone().isoformat()
    begun_s = time.monotonic()
    done = lbr(under.robot.home, "at", when, *words, "--json", limit_s=30.0)
    if words[0] == "why":
        results.sample("T4", (time.monotonic() - begun_s) * 1e3)
    assert done.returncode == 0, done.stderr
    return dict(json.loads(done.stdout))


def _by_name(rows: list[dict[str, Any]]) -> dict[str, Any]:
    return {row["name"]: row for row in rows}


def _other(found: dict[str, Any], than: dict[str, Any]) -> dict[str, Any]:
    """Return the parts of one that differ from another."""
    return {name: value for name, value in found.items() if than.get(name) != value}


def _first(chain: dict[str, Any]) -> dict[str, str]:
    """Return the first link: its subject, its name and its code."""
    link = chain["links"][chain["first"]] if chain.get("first") is not None else {}
    return {"state": chain["state"], **{name: link.get(name, "") for name in ("name", "about", "code")}}


def _processes(status: dict[str, Any]) -> dict[str, str]:
    return {one["name"]: f"{one['phase']} {one.get('code', '')}".strip() for one in status["capabilities"]}
