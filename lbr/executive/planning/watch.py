"""Reads the rows: makes the first plan, and a later one whenever the rows or a capability's file are edited."""

from collections.abc import Callable, Iterable, Sequence
from datetime import UTC, datetime
from pathlib import Path

from msgspec import Struct
from msgspec.structs import replace

from lbr import plugins
from lbr.database import copies
from lbr.database.reading import Problem
from lbr.database.rows import RevisionRow, RobotRows
from lbr.database.store import PATIENCE_S, Database
from lbr.errors import InputError, LbrError, RowError
from lbr.executive.planning import plan as plans
from lbr.executive.planning import planner
from lbr.executive.planning.kinds import KindLoader
from lbr.executive.planning.machine import Machine, processes
from lbr.executive.planning.plan import Change, Plan
from lbr.executive.planning.profile import Profile
from lbr.executive.planning.run_identity import RunIdentity

UNKNOWN_VERSION = -1
NEVER = datetime.max.replace(tzinfo=UTC)
EDITS_TOLD = 4


class News(Struct, frozen=True):
    """The result of a look: a new plan, with its changes and the edits behind it, or the problems of the rows.

    If there are problems, `plan` is the old one with the present tokens: a revoked token is refused even then.
    """

    plan: Plan | None = None
    change: Change = Change()
    edited: str = ""
    problems: tuple[str, ...] = ()
    unreadable: bool = False


class RowWatch:
    """Compares the database with the last plan; cheap enough for five times a second."""

    def __init__(
        self, database: Database, profile: Profile, site: RunIdentity, machine: Callable[[int], Machine]
    ) -> None:
        """Watch rows for a machine that has `machine(n)` when n of the robot's processes run on it."""
        self._database = database
        self._machine = machine
        self._profile = profile
        self._site = site
        self._file = _identity(database.path)
        self._version = UNKNOWN_VERSION
        self._kinds = KindLoader(Path(site.home))
        self._named: frozenset[str] = frozenset()
        self._files: dict[str, str] = {}
        self._problems: tuple[str, ...] = ()
        self._next_end = NEVER

    def first(self) -> Plan:
        """Return the plan to start with; raise RowError with all faults."""
        self._version = self._database.data_version()
        rows = self._with_valid_tokens(loaded(self._database, [self._profile.robot])[self._profile.robot])
        self._files = self._marks(rows)
        self._kinds.try_now(self._files)
        plan, problems = planner.make(rows, self._profile, self._site, self._machine(0), find=self._kinds.find)
        if plan is None:
            raise RowError(tuple(str(problem) for problem in problems))
        return plan

    def look(self, plan: Plan) -> News | None:
        """Return the news since the last look; None if nothing was touched."""
        try:
            self._check_file()
            seen = self._database.data_version()
            untouched = (seen, self._kinds.marks(self._named)) == (self._version, self._files)
            if untouched and datetime.now(UTC) < self._next_end:
                return None
            rows = self._with_valid_tokens(self._database.load(self._profile.robot, patience_s=PATIENCE_S))
        except LbrError as err:
            self._version = UNKNOWN_VERSION
            self._problems = (str(err),)
            return News(problems=self._problems, unreadable=True)
        files = self._marks(rows)
        if not self._kinds.ready(files):
            self._version = UNKNOWN_VERSION
            return self._locked_out(plan, rows) if rows.tokens != plan.rows.tokens else None
        self._version, self._files = seen, files
        room, find = self._room_beside(plan), self._kinds.find
        wanted, problems = planner.make(rows, self._profile, self._site, room, find=find, before=plan.rows)
        self._kinds.forget_faults()
        self._problems = tuple(str(problem) for problem in problems)
        if wanted is None and rows.tokens != plan.rows.tokens:
            return self._locked_out(plan, rows)
        if wanted is None:
            return News(problems=self._problems)
        return self._news(plan, wanted)

    def _locked_out(self, plan: Plan, rows: RobotRows) -> News:
        """Return the running plan with the present tokens."""
        new = planner.with_tokens(plan, rows.tokens, self._profile, self._site, self._room_beside(plan))
        return self._news(plan, new) if new is not None else News(problems=self._problems)

    def _room_beside(self, plan: Plan) -> Machine:
        """Return the limits of the machine while a plan runs on it."""
        return self._machine(processes(plan.rows.capabilities, plan.local_units))

    def _news(self, plan: Plan, new: Plan) -> News:
        edited = self._edited(plan.rows, new.rows)
        return News(plan=new, change=plans.difference(plan, new), edited=edited, problems=self._problems)

    def planned(self, rows: RobotRows, beside: Plan) -> tuple[Plan | None, tuple[Problem, ...]]:
        """Return the plan for rows that are not written yet, beside another, and their problems; from any thread."""
        return planner.make(rows, self._profile, self._site, self._room_beside(beside), before=beside.rows)

    def look_again(self) -> None:
        """Read the rows at the next look: `data_version` does not change when this process writes them."""
        self._version = UNKNOWN_VERSION

    def _with_valid_tokens(self, rows: RobotRows) -> RobotRows:
        """Remove tokens that have expired, and note when the next one expires."""
        now = datetime.now(UTC)
        valid = tuple(one for one in rows.tokens if one.revoked_at is None and not one.has_expired(now))
        self._next_end = min((datetime.fromisoformat(one.expires_at) for one in valid if one.expires_at), default=NEVER)
        return replace(rows, tokens=valid)

    def _edited(self, before: RobotRows, after: RobotRows) -> str:
        try:
            rows = self._database.touched(before.revision) if after.revision != before.revision else ()
        except RowError as err:  # only a report
            return f"rows that are not known: {err}"
        said = edited(rows, after.robot.name)
        more = f" and {len(said) - EDITS_TOLD} more" if len(said) > EDITS_TOLD else ""
        return ", ".join(filter(None, (", ".join(said[:EDITS_TOLD]) + more, _tokens_edited(before, after))))

    def _marks(self, rows: RobotRows) -> dict[str, str]:
        """Return the marks of users' kinds in the rows; later looks compare with them, even if the rows are refused."""
        kinds = {row.kind for row in rows.capabilities}
        self._named = frozenset(kind for kind in kinds if plugins.find("kinds", kind) is None)
        return self._kinds.marks(self._named)

    def _check_file(self) -> None:
        """Notice that the database's file was replaced: edits of the new file are not read here."""
        path = self._database.path
        try:
            found = _identity(path)
        except OSError as err:
            raise InputError(f"database {path} is gone ({err.strerror}); put it back, or restart") from err
        if found != self._file:
            raise InputError(f"database {path} was replaced by another file; restart to use it")


def loaded(database: Database, robots: Iterable[str]) -> dict[str, RobotRows]:
    """Return the rows of robots as a start reads them."""
    found = database.load_all(robots)
    lost = copies.lost_edits(database.path, next(iter(found.values())).revision) if found else ()
    return {name: replace(rows, problems=(*rows.problems, *lost)) for name, rows in found.items()}


def edited(rows: Iterable[RevisionRow], robot: str) -> list[str]:
    """Describe the edits; rows of a table whose keys differ only in the last part are combined."""
    groups: dict[tuple[str, ...], list[RevisionRow]] = {}
    for row in rows:
        groups.setdefault((row.table, *_own_key(row, robot)[:-1]), []).append(row)
    return [said for group in groups.values() for said in _edits(group, robot)]


def _edits(group: Sequence[RevisionRow], robot: str) -> list[str]:
    (row, *others), (*whole, _) = group, _own_key(group[0], robot)
    if whole and any(other.row_key != row.row_key for other in others):
        operations = {one.operation for one in group}
        operation = row.operation if len(operations) == 1 else "edit"
        return [f"{operation} {len({one.row_key for one in group})} rows of {row.table} '{'/'.join(whole)}'"]
    return list(dict.fromkeys(f"{one.operation} {one.table} '{'/'.join(_own_key(one, robot))}'" for one in group))


def _own_key(row: RevisionRow, robot: str) -> tuple[str, ...]:
    """Return a row's key without the robot's name."""
    key = tuple(map(str, row.row_key))
    return key[1:] if len(key) > 1 and key[0] == robot else key


def _tokens_edited(before: RobotRows, after: RobotRows) -> str:
    """Describe the tokens that were added and removed, whether by an edit or because they expired."""
    came = [f"token '{one.name}' ({one.role}) is valid" for one in after.tokens if one not in before.tokens]
    names = {one.name for one in after.tokens}
    went = [f"token '{one.name}' has no rights any more" for one in before.tokens if one.name not in names]
    said = [*went, *came]
    return ", ".join(said[:EDITS_TOLD]) + (f" and {len(said) - EDITS_TOLD} more" if len(said) > EDITS_TOLD else "")


def _identity(path: Path) -> tuple[int, int]:
    found = path.stat()
    return found.st_dev, found.st_ino
