"""What people ask from pages of rows, tokens and logs: read and written beside the main loop, one after the other, and
answered.

Only a server for people may ask here; it looks at the role of who asks before it does.
"""

import contextlib
import os
from collections import deque
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import msgspec
from msgspec import Struct
from msgspec.structs import asdict, replace

from lbr import home
from lbr.bus import wire
from lbr.bus.codec import Decoder
from lbr.capability import registry, twins
from lbr.capability.kind import Kind, KindError
from lbr.database import history, row_changes
from lbr.database.reading import Problem
from lbr.database.rows import CORE, CapabilityRow, DeviceRow, RobotRows
from lbr.database.store import Database
from lbr.errors import InputError, LbrError, MalformedError
from lbr.executive import beside
from lbr.executive.planning import plan as plans
from lbr.executive.planning.happened import Happened
from lbr.executive.planning.plan import Plan
from lbr.executive.planning.wiring import EXECUTIVE
from lbr.executive.service import attached
from lbr.messages.manage import (
    LOG_BYTES,
    ChangeRows,
    LookAtDevices,
    LookAtEvents,
    LookAtLog,
    LookAtRows,
    LookAtTokens,
    ManageCommand,
    ManageReply,
    RevokeToken,
    RowProblem,
    Touched,
)
from lbr.messages.rows import Row, shown

MOST_WAITING = 16
MOST_REMEMBERED = 256
"""Rows of which it is known which page changed them last; a form is not open for more changes."""
LETS_IN = (
    "decides who comes in, and a page changes none of that: say 'open' or 'close' at the console, or edit the row there"
)
Make = Callable[[RobotRows], tuple[Plan | None, tuple[Problem, ...]]]
_commands: Decoder[Any] = Decoder(ManageCommand)  # type: ignore[arg-type]  # a union is a type, too


class Note(Struct, frozen=True):
    """An event that a job leaves for the main thread."""

    kind: str
    text: str


class Clerk:
    """Does one job by a connection of its own; from any thread."""

    def __init__(self, path: Path, plan: Callable[[], Plan], make: Make) -> None:
        self._path = path
        self._plan = plan
        self._make = make
        self._edited: deque[tuple[int, str, str, tuple[Any, ...]]] = deque(maxlen=MOST_REMEMBERED)

    def __call__(self, command: Any) -> tuple[ManageReply, tuple[Note, ...]]:
        """Return what became of it, and what is to be told."""
        match command:
            case LookAtRows():
                return self._rows(command.table), ()
            case ChangeRows():
                return self._change(command)
            case LookAtTokens() | LookAtDevices():
                return self._tokens() if isinstance(command, LookAtTokens) else self._devices(), ()
            case RevokeToken():
                return self._revoke(command)
            case LookAtLog():
                return self._log(command.name), ()
            case LookAtEvents():
                return self._events(command), ()
        raise InputError("that is nothing to ask here", "unknown_command")

    def _classes(self) -> dict[str, type[Row]]:
        read = (read.row for kind in self._plan().kinds.values() for read in kind.reads)
        return {row.TABLE: row for row in (*CORE, *read)}

    def _rows(self, table: str) -> ManageReply:
        plan, classes = self._plan(), self._classes()
        with Database.open(self._path) as database:
            tables, schema = database.tables()
            revision = database.revision()
        found = [
            {"table": name, "rows": len(_own(tables, name, plan.robot)), "fixed": row_changes.fixed(row)}
            for name, row in classes.items()
            if name in schema
        ]
        if not table:
            return ManageReply(accepted=True, revision=revision, data={"tables": found})
        row = row_changes.of(table, schema, classes)
        data = {
            "table": table,
            "key": list(row.KEY),
            "fixed": row_changes.fixed(row),
            "schema": _schema(row),
            "settings": self._settings(row, plan),
            "rows": [row_changes.told(row, one) for one in _own(tables, table, plan.robot)],
        }
        return ManageReply(accepted=True, revision=revision, data=data)

    def _settings(self, row: type[Row], plan: Plan) -> dict[str, Any]:
        """Return the schemas of what the column `settings` holds, by the row's name."""
        if row is CapabilityRow:
            return {name: _schema(kind.settings) for name, kind in plan.kinds.items()}
        if row is DeviceRow:
            return {one.name: found for one in plan.rows.devices if (found := _of_twin(one.type)) is not None}
        return {}

    def _change(self, command: ChangeRows) -> tuple[ManageReply, tuple[Note, ...]]:
        before, new = self._plan(), None
        problems: tuple[Problem, ...]

        def wrong(rows: RobotRows) -> tuple[Problem, ...]:
            nonlocal new
            made, found = self._make(rows)
            new = new or made
            return (*found, *_letting_in(before.rows, rows))

        with Database.open(self._path, program="executive") as database:
            try:
                revision, problems = database.change_rows(
                    before.robot,
                    command.changes,
                    self._classes(),
                    wrong,
                    dry_run=not command.write,
                    by=command.by or "a page",
                )
            except row_changes.ChangedError as err:
                return self._changed(database, err), ()
        touched = _touched(before, new)
        if problems:
            told = tuple(
                RowProblem(**asdict(replace(one, row=one.row.removeprefix(f"{before.robot}/")))) for one in problems
            )
            more = f"; and {len(problems) - 1} more" * (len(problems) > 1)
            reason = f"{problems[0]}{more}"
            return ManageReply(
                accepted=False, reason=reason, code="bad_value", revision=revision, problems=told, touched=touched
            ), ()
        note = Note("edit", f"{command.by or 'a page'} changed {_listed(command)}")
        if command.write:
            classes = self._classes()
            for one in command.changes:
                values = one.before if one.before is not None else one.after or {}
                key = tuple(values[name] for name in classes[one.table].KEY)
                self._edited.append((revision, command.by, one.table, key))
        done = ManageReply(accepted=True, revision=revision, touched=touched)
        return done, (note,) if command.write else ()

    def _changed(self, database: Database, err: row_changes.ChangedError) -> ManageReply:
        """Return the refusal of a change of a row that is another meanwhile: with who changed it, and when."""
        last = database.last_change(self._plan().robot, err.table, err.key)
        number, at = last or (0, "")
        by = next(
            (
                by
                for revision, by, *row in reversed(self._edited)
                if last is not None and revision >= number and row == [err.table, err.key]
            ),
            "",
        )
        told = f" (by {by})" if by else ""
        return ManageReply(
            accepted=False,
            reason=f"{err}{told}",
            code=err.code,
            revision=database.revision(),
            changed_by=by,
            changed_at=at,
        )

    def _events(self, command: LookAtEvents) -> ManageReply:
        levels = history.LEVELS[history.LEVELS.index(command.level) :]
        with Database.open(self._path) as database:
            found = database.events(command.limit, subject=command.subject, levels=levels)
        told = ("kind", "subject", "text", "level", "wall_ns")
        data = [{name: getattr(one, name) for name in told} for one in reversed(found)]
        return ManageReply(accepted=True, data={"events": data})

    def _tokens(self) -> ManageReply:
        with Database.open(self._path) as database:
            found = database.tokens()
        data = [{name: value for name, value in asdict(one).items() if name != "hash"} for one in found]
        return ManageReply(accepted=True, data={"tokens": data})

    def _devices(self) -> ManageReply:
        return ManageReply(accepted=True, data=attached.look(self._plan().robot, self._path))

    def _revoke(self, command: RevokeToken) -> tuple[ManageReply, tuple[Note, ...]]:
        with Database.open(self._path) as database:
            database.revoke_token(command.name)
        note = Note("token", f"{command.by or 'a page'} revoked the token '{command.name}'")
        return ManageReply(accepted=True, reason=f"'{command.name}' is revoked"), (note,)

    def _log(self, name: str) -> ManageReply:
        plan = self._plan()
        file = plan.log(name)
        if not file:
            raise InputError(f"there is no capability '{shown(name)}'", "unknown_name")
        try:
            with (home.directory("logs") / file).open("rb") as log:
                size = os.fstat(log.fileno()).st_size
                log.seek(max(0, size - LOG_BYTES))
                text = log.read(LOG_BYTES).decode(errors="replace")
        except FileNotFoundError:
            text = ""
        except OSError as err:
            raise InputError(f"the log of '{name}' cannot be read: {err.strerror}", "failed") from err
        whole = text if len(text) < LOG_BYTES // 2 else text.partition("\n")[2]
        return ManageReply(accepted=True, data={"name": name, "text": whole})


class _Job(Struct):
    """A question under way."""

    request: wire.Request
    command: Any
    reply: ManageReply | None = None
    notes: tuple[Note, ...] = ()


class Desk:
    """Answers people's questions one after the other. The main thread calls `step`; a thread waits for the disk."""

    def __init__(
        self,
        served: wire.QueryServer,
        path: Path,
        *,
        plan: Callable[[], Plan],
        make: Make,
        happened: Happened,
        wake: Callable[[], None],
    ) -> None:
        self._served = served
        self._clerk = Clerk(path, plan, make)
        self._happened = happened
        self._wake = wake
        self._waiting: deque[_Job] = deque()
        self._job: _Job | None = None

    def step(self) -> bool:
        """Begin and end what is due; say whether rows were written."""
        for request in self._served.take():
            self._take(request)
        job, written = self._job, False
        if job is not None and job.reply is not None:
            self._job = None
            for note in job.notes:
                self._happened(note.kind, EXECUTIVE, note.text, "info", {"revision": job.reply.revision})
            job.request.reply(job.reply, EXECUTIVE)
            written = bool(job.notes)
        if self._job is None and self._waiting:
            self._job = self._waiting.popleft()
            if beside.begin(partial(self._run, self._job), "desk") is None:
                self._job.reply = ManageReply(accepted=False, code="busy", reason=beside.NO_THREAD)
                self._wake()
        return written

    def close(self) -> None:
        """Take no more; one under way is written, or not, by itself."""
        self._served.close()

    def _take(self, request: wire.Request) -> None:
        if len(self._waiting) >= MOST_WAITING:
            request.reply(
                ManageReply(accepted=False, reason="too much is asked at once; try again", code="busy"), EXECUTIVE
            )
            return
        try:
            self._waiting.append(_Job(request, _commands.decode(request.payload)))
        except MalformedError as err:
            request.reply(ManageReply(accepted=False, reason=str(err), code="malformed"), EXECUTIVE)

    def _run(self, job: _Job) -> None:
        try:
            reply, job.notes = self._clerk(job.command)
        except LbrError as err:
            code = err.code if isinstance(err, InputError) else "failed"
            reply = ManageReply(accepted=False, reason=str(err), code=code)
        except Exception as err:  # noqa: BLE001 - the asker is to hear it
            reply = ManageReply(accepted=False, reason=f"this is broken: {type(err).__name__}: {err}", code="failed")
        job.reply = reply
        self._wake()


def _letting_in(before: RobotRows, after: RobotRows) -> Iterator[Problem]:
    """Yield what would decide otherwise who comes in: a page's server that was taken over would let others in."""
    old = {row.name: row for row in before.capabilities}
    for row in after.capabilities:
        was = old.get(row.name)
        if row == was:
            continue
        with contextlib.suppress(KindError):  # told as such
            kind = registry.find(row.kind, home.home())
            now, then = _deciding(kind, row), _deciding(kind, was if was and was.kind == row.kind else None)
            for name in kind.lets_in if now is not None else ():
                if then is None or now is None or now[name] != then[name]:
                    column = name if name == "enabled" else "settings"
                    yield Problem(row.TABLE, f"{after.robot.name}/{row.name}", column, f"{name} {LETS_IN}")


def _deciding(kind: Kind, row: CapabilityRow | None) -> dict[str, Any] | None:
    """Return what of a row decides who comes in; without a row what a new one has, and None if that says nothing."""
    try:
        settings = kind.parse(row.settings if row is not None else "{}")
    except Exception:  # noqa: BLE001 - a user's own kind may check its settings in any way, and that is told as such
        return None
    columns = {"enabled": row is not None and row.enabled}
    return {name: columns[name] if name in columns else getattr(settings, name) for name in kind.lets_in}


def _own(tables: Any, table: str, robot: str) -> list[Any]:
    """Return a table's rows that are this robot's, or every robot's."""
    name = "name" if table == "robot" else "robot"
    return [row for row in tables.get(table, ()) if row.get(name, robot) == robot]


def _schema(struct: type[Struct]) -> dict[str, Any]:
    return msgspec.json.schema(struct)


def _of_twin(device: str) -> dict[str, Any] | None:
    try:
        found = twins.find(device)
    except KindError:
        return None
    return _schema(found.row) if found is not None else None


def _touched(before: Plan, new: Plan | None) -> Touched | None:
    if new is None:
        return None
    change = plans.difference(before, new)
    return Touched(start=change.start, stop=change.stop, restart=change.restart, plug=change.plug)


def _listed(command: ChangeRows) -> str:
    told = []
    for change in command.changes:
        before, after = change.before or {}, change.after or {}
        name = before.get("name", after.get("name", ""))
        what = "deleted" if change.after is None else "new" if change.before is None else ""
        columns = ", ".join(key for key, value in after.items() if value != before.get(key))
        told.append(f"{change.table} '{shown(name)}' ({what or columns})")
    return ", ".join(told)[:300]
