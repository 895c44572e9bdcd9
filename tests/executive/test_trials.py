"""Rows on trial are kept once what they touch is ready, and else taken back: with a clock of the test's own, without a robot."""

from collections.abc import Iterator

import pytest
from msgspec.structs import replace

from lbr.database import changes, proposals, trials
from lbr.database.proposals import Proposed
from lbr.database.store import Database
from lbr.database.trials import Trial
from lbr.errors import InputError
from lbr.executive.planning.plan import Change
from lbr.executive.planning.trials import STEADY_S, Trials, go_back, not_ready
from lbr.messages.system import CapabilityStatus
from tests.support import databases
from tests.support.waiting import until


def status(name: str, phase: str, reason: str = "", code: str = "") -> CapabilityStatus:
    return CapabilityStatus(
        name=name, kind="k", phase=phase, pid=None, restarts=0, uptime_s=None, rates_hz={}, reason=reason, code=code
    )


@pytest.fixture
def database(tmp_path) -> Iterator[Database]:
    with Database.open(databases.fresh(tmp_path / "robot.db") or tmp_path / "robot.db") as opened:
        yield opened


def owner(tables, schema, name: str = "tried") -> tuple[changes.Change, ...]:
    after = {**tables, "robot": [{**row, "owner": name} for row in tables["robot"]]}
    return changes.between(tables, after, schema, "lbr")


def apply(database: Database, within_s: float = 5.0, **options) -> Proposed:
    return proposals.command(
        database, owner, lambda _rows: (), text="", on_trial=lambda _steps: ("lbr", within_s), **options
    )


def owned_by(database: Database) -> str:
    return next(row["owner"] for row in database.tables()[0]["robot"] if row["name"] == "lbr")


class Bench:
    """A robot of one capability, whose phases and clock the test sets."""

    def __init__(self, database: Database) -> None:
        self.database = database
        self.now = 100.0
        self.phase, self.reason, self.restarts = "ready", "", 0
        self.told: list[str] = []
        self.trials = Trials(
            database,
            lambda: [replace(status("drive", self.phase, self.reason), restarts=self.restarts)],
            lambda kind, _subject, text, level="info", data=None: self.told.append(f"{kind}: {text}"),
            lambda: self.now,
        )

    def adopt(self, phase: str) -> None:
        self.trials.touching(Change(restart=("drive",)))
        self.phase = phase

    def look(self, after_s: float = 0.2, problems: tuple[str, ...] = ()) -> None:
        self.now += after_s
        self.trials.look("lbr", self.database.revision(), problems)

    def end(self) -> Trial:
        def ended() -> Trial | None:
            self.look(0.0)
            found = trials.newest(self.database)
            return found if found is not None and found.state != "running" and not self.trials.on else None

        return until(ended)


@pytest.fixture
def bench(database) -> Bench:
    found = Bench(database)
    found.look()
    return found


def test_rows_are_kept_once_all_that_they_touch_was_ready_for_a_moment(bench):
    apply(bench.database)
    bench.adopt("starting")
    bench.look()
    bench.phase = "ready"
    bench.look()
    assert bench.trials.on
    assert trials.newest(bench.database).state == "running"
    bench.look(STEADY_S)
    assert bench.end().state == "kept"
    assert owned_by(bench.database) == "tried"
    assert bench.told[-1] == "rows_kept: the rows of revision 1 are kept because drive got ready"


def test_what_is_ready_and_ends_again_is_not_ready(bench):
    apply(bench.database)
    bench.adopt("ready")
    bench.look()
    bench.phase = "waiting"
    bench.look(STEADY_S)
    bench.phase = "ready"
    bench.look()
    assert bench.trials.on


def test_what_ends_and_starts_between_two_looks_is_not_ready(bench):
    apply(bench.database, within_s=2.0)
    bench.adopt("ready")
    for _ in range(20):
        bench.look(0.2)
        bench.restarts += 1
    assert bench.end().state == "back"


def test_rows_go_back_when_time_is_over(bench, wording):
    apply(bench.database, within_s=2.0)
    bench.adopt("starting")
    bench.look()
    bench.reason = "no line"
    bench.look(2.0)
    ended = bench.end()
    assert (ended.state, ended.text) == ("back", "drive is starting: no line after 2 s")
    assert owned_by(bench.database) == ""
    (_, back) = bench.database.changes()
    assert back.program == "executive"
    assert back.text == "went back to revision 0: drive is starting: no line after 2 s"
    wording(bench.told[-1])


def test_rows_go_back_at_once_when_what_they_touch_has_failed_for_good(bench):
    apply(bench.database)
    bench.adopt("failed")
    bench.reason = "it ended with 1"
    bench.look()
    assert bench.end().text == "drive is failed: it ended with 1"


def test_rows_that_are_refused_go_back_at_once(bench):
    apply(bench.database)
    bench.look(problems=("channel 'a': bad",))
    assert bench.end().text == "they are refused: channel 'a': bad"
    assert owned_by(bench.database) == ""


def test_what_others_changed_since_stays(bench, database):
    apply(database, within_s=1.0)
    databases.edit(
        database.path,
        "UPDATE robot SET model = 'other' WHERE name = 'uxa90'",
        "INSERT INTO phrase VALUES ('ouch', 'en', 'Ouch.')",
    )
    bench.adopt("starting")
    bench.look()
    bench.look(2.0)
    bench.end()
    tables, _ = database.tables()
    assert owned_by(database) == ""
    assert any(row["name"] == "ouch" for row in tables["phrase"])
    assert [row["model"] for row in tables["robot"] if row["name"] == "uxa90"] == ["other"]


def test_a_start_takes_back_what_was_on_trial_and_nothing_else(database, wording):
    assert go_back(database, "lbr") == ""
    apply(database)
    assert go_back(database, "uxa90") == ""
    wording(go_back(database, "lbr"))
    assert owned_by(database) == ""
    assert go_back(database, "lbr") == ""


def test_a_second_change_is_refused_while_rows_are_on_trial(database):
    apply(database)
    with pytest.raises(InputError, match="revision 1 is on trial by 'lbr' for 5 s"):
        proposals.command(
            database, lambda *of: owner(*of, name="second"), lambda _rows: (), text="", on_trial=lambda _: ("lbr", 1.0)
        )
    assert database.revision() == 1


def test_a_trial_is_judged_once(database):
    apply(database)
    trial = trials.newest(database)
    assert trials.judge(database, trial, good=True, text="").state == "kept"
    assert trials.judge(database, trial, good=False, text="late").state == "kept"
    assert owned_by(database) == "tried"


def test_rows_that_cannot_be_taken_back_stay_and_are_told(database, wording):
    apply(database)
    database.outdo(0, "a copy")
    ended = trials.judge(database, trials.newest(database), good=False, text="it is late")
    assert ended.state == "lost"
    wording(ended.text)


@pytest.mark.parametrize(
    ("before", "now", "lacking"),
    [
        ({}, [status("drive", "ready")], ()),
        ({}, [status("drive", "degraded", "no line")], ("drive is degraded: no line",)),
        ({"drive": "degraded"}, [status("drive", "degraded", "no line")], ()),
        ({"drive": "ready"}, [status("drive", "degraded", "pressed", "estop")], ()),
        ({"drive": "failed"}, [status("drive", "failed", "x")], ("drive is failed: x",)),
        ({}, [], ("drive is not there",)),
        ({}, [status("drive", "ready"), status("web", "failed", "x")], ("web is failed: x",)),
        ({"web": "failed"}, [status("drive", "ready"), status("web", "failed", "x")], ()),
    ],
)
def test_what_keeps_rows_from_being_kept(before, now, lacking):
    assert not_ready(before, ["drive"], now) == lacking
