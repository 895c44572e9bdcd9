"""The power is cut while rows and latch are edited and the black box writes: what was acknowledged is there afterwards."""

import random
import sqlite3
import tempfile
import threading
import time
from contextlib import closing, suppress
from pathlib import Path
from typing import NamedTuple

import psutil
from msgspec import Struct

from lbr.apps.recorder.recording import selection
from lbr.apps.recorder.recording.shelf import Shelf
from lbr.testing.robot import NoAnswerError
from tests.support.bench import Bench, let_go, processes_of
from tests.support.cut_disk import CutDisk, cut_disk
from tests.support.figures import Results
from tests.support.robot import lbr, prepare, start
from tests.support.witness import Witness

OLD_NS = 1_000_000_000
STREAM = "motors/setpoint"
EDIT = "UPDATE capability SET help = ? WHERE robot = 'lbr' AND name = 'world'"


class Cut(Struct):
    """What came of a cut: what of the rows was wrong, how many edits were acknowledged, and messages older than 1 s."""

    wrong: list[str]
    edits: int
    older: int
    gone: int


def cut(results: Results, seconds: float, dice: random.Random) -> Cut:
    """Run a robot on a disk of its own for so long, cut its power, and look at the disk as the next start does."""
    with tempfile.TemporaryDirectory(prefix="lbr-") as place, cut_disk(Path(place)) as disk:
        home = prepare(disk.at / "h", "box")
        under_test = Bench(start(home), results, dice=dice)
        try:
            return _cut(under_test, disk, seconds)
        finally:
            let_go(under_test.robot)


def _cut(under_test: Bench, disk: CutDisk, seconds: float) -> Cut:
    home = under_test.robot.home
    files = Shelf(home, "lbr").files
    under_test.until(lambda: STREAM in {one.topic for one in selection.messages(files())}, 15.0, "streams in the box")
    witness, editor = Witness(under_test), _Editor(under_test, random.Random(under_test.dice.random()))
    mover = under_test.drive()
    begun_ns = time.monotonic_ns()
    editor.start()
    under_test.pass_time(seconds)
    known, cut_ns = editor.acknowledged(), time.monotonic_ns()
    disk.cut()
    editor.over.set()
    wanted = witness.between(begun_ns, cut_ns - OLD_NS)
    for process in processes_of(home):
        with suppress(psutil.Error):
            process.kill()
    mover.cease()
    editor.join()
    under_test.robot.popen.wait()
    under_test.until(lambda: not processes_of(home), 5.0, "no process", every_s=0.05)
    disk.back()
    there = {(one.topic, one.sequence) for one in selection.messages(Shelf(home, "lbr").files())}
    return Cut(_wrong(home, known, editor), known.count, len(wanted), len(wanted - there))


class _Known(NamedTuple):
    """What was acknowledged at a moment: the last edit, the latch (two values while one is under way), and how many."""

    edit: int
    latches: frozenset[int]
    count: int


class _Editor(threading.Thread):
    """Edits rows and latch without an end; notes what it asked for and what was acknowledged."""

    def __init__(self, under_test: Bench, dice: random.Random) -> None:
        super().__init__(daemon=True)
        self.over = threading.Event()
        self.asked = 0
        self._known = _Known(0, frozenset({0}), 0)
        self._robot, self._dice = under_test.robot, dice

    def acknowledged(self) -> _Known:
        """Return what was acknowledged until now; what the kernel says in the very moment of a cut is no promise."""
        return self._known

    def run(self) -> None:
        """Edit until it is over, or the disk is gone."""
        with suppress(sqlite3.Error, NoAnswerError, OSError):
            while not self.over.wait(self._dice.uniform(0.0, 0.1)):
                if self._dice.random() < 0.8:
                    self._edit()
                else:
                    self._latch(self._dice.randrange(2))

    def _edit(self) -> None:
        self.asked += 1
        self._robot.edit(EDIT, str(self.asked))
        self._known = self._known._replace(edit=self.asked, count=self._known.count + 1)

    def _latch(self, engaged: int) -> None:
        self._known = self._known._replace(latches=self._known.latches | {engaged})
        if self._robot.line("estop" if engaged else "reset")["code"] == 0:
            self._known = self._known._replace(latches=frozenset({engaged}), count=self._known.count + 1)


def _wrong(home: Path, known: _Known, editor: _Editor) -> list[str]:
    """Return what of the rows is not as it was acknowledged."""
    with closing(sqlite3.connect(home / "robot.db")) as database:
        problems = [text for (text,) in database.execute("PRAGMA integrity_check") if text != "ok"]
        problems += [f"foreign key: {row}" for row in database.execute("PRAGMA foreign_key_check")]
        (help_,) = database.execute("SELECT help FROM capability WHERE robot = 'lbr' AND name = 'world'").fetchone()
        (latch,) = database.execute("SELECT estop_engaged FROM robot WHERE name = 'lbr'").fetchone()
    if not known.edit <= (there := int(help_) if help_.isdigit() else 0) <= editor.asked:
        problems.append(f"edit {known.edit} was acknowledged, {editor.asked} was asked for, and {there} is there")
    if latch not in known.latches | editor.acknowledged().latches:
        problems.append(f"the latch is {latch}, and {set(known.latches)} was acknowledged")
    checked = lbr(home, "db", "check", "--db", str(home / "robot.db"))
    return problems + ([checked.stderr] if checked.returncode else [])
