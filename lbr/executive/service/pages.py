"""Requests from pages for rows, tokens and logs. Only a server for people may send them, after checking the role."""

import contextlib
import os
import subprocess
import sys
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
from lbr.database import forms, history
from lbr.database.proposals import propose
from lbr.database.reading import Problem
from lbr.database.rows import CORE, CapabilityRow, DeviceRow, RobotRows
from lbr.database.store import Database
from lbr.errors import InputError
from lbr.executive.planning import plan as plans
from lbr.executive.planning.event_sink import EventSink
from lbr.executive.planning.plan import Plan
from lbr.executive.planning.wiring import EXECUTIVE
from lbr.executive.service.row_service import Job, Reply
from lbr.messages.codes import Code
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
    RenameToken,
    RevokeToken,
    RowProblem,
    Touched,
    UndoRows,
)
from lbr.messages.rows import Row, short
from lbr.messages.unreadable import UNREADABLE

WITHIN_S = 9.0
LONGEST_TEXT = 300


def look(robot: str, database: Path) -> object:
    """Return the output of `lbr devices --json`, which writes nothing; raise InputError if it fails."""
    words = [sys.executable, "-m", "lbr.start", "devices", "--json", "--robot", robot, "--db", str(database)]
    try:
        done = subprocess.run(words, capture_output=True, timeout=WITHIN_S, stdin=subprocess.DEVNULL, check=False)
    except subprocess.TimeoutExpired:
        raise InputError(f"'lbr devices' did not end within {WITHIN_S:g} s; say it at the robot", "timeout") from None
    except OSError as err:
        raise InputError(f"'lbr devices' cannot be started: {err.strerror}", "failed") from err
    try:
        return msgspec.json.decode(done.stdout)
    except UNREADABLE:
        why = " ".join(done.stderr.decode(errors="replace").split())[-LONGEST_TEXT:]
        raise InputError(f"'lbr devices' failed: {why or f'exit code {done.returncode}'}", "failed") from None


LETS_IN = (
    "decides who comes in, and a page changes none of that: say 'open' or 'close' at the console, or edit the row there"
)
Make = Callable[[RobotRows], tuple[Plan | None, tuple[Problem, ...]]]
_commands: Decoder[Any] = Decoder(ManageCommand)  # type: ignore[arg-type]  # a union is a type, too


class Pages:
    """Reads requests of pages, and answers them over its own connection. `make` plans the rows that would run."""

    def __init__(
        self, served: wire.QueryServer, path: Path, *, plan: Callable[[], Plan], make: Make, happened: EventSink
    ) -> None:
        self.served = served
        self._path = path
        self._plan = plan
        self._make = make
        self._happened = happened
        self._answers: dict[type[Struct], Callable[[Any], ManageReply]] = {
            LookAtRows: self._rows,
            ChangeRows: self._change,
            UndoRows: self._undo,
            LookAtTokens: self._tokens,
            LookAtDevices: self._devices,
            RenameToken: self._rename,
            RevokeToken: self._revoke,
            LookAtLog: self._log,
            LookAtEvents: self._events,
        }

    def read(self, request: wire.Request) -> Job:
        """Return the job for a page's request."""
        command = _commands.decode(request.payload)
        answer = partial(self._answers[type(command)], command)
        return Job(request, self, answer, partial(self._end, command), slow=isinstance(command, LookAtDevices))

    def refused(self, reason: str, code: Code) -> ManageReply:
        """Return a refusal."""
        return ManageReply(accepted=False, reason=reason, code=code)

    def _end(self, command: object, reply: Reply) -> bool:
        """Report the changes; return whether rows were written."""
        match command:
            case ChangeRows(write=True):
                kind, text = "edit", f"{command.by or 'a page'} changed {_listed(command)}"
            case UndoRows():
                kind, text = "edit", f"{command.by} took the change of rows with revision {command.revision} back"
            case RenameToken():
                kind, text = "token", f"{command.by or 'a page'} calls the token '{command.name}' '{command.called}'"
            case RevokeToken():
                kind, text = "token", f"{command.by or 'a page'} revoked the token '{command.name}'"
            case _:
                return False
        if reply.accepted:
            self._happened(kind, EXECUTIVE, text, data={"revision": reply.revision})
        return reply.accepted

    def _classes(self) -> dict[str, type[Row]]:
        read = (read.row for kind in self._plan().kinds.values() for read in kind.reads)
        return {row.TABLE: row for row in (*CORE, *read)}

    def _rows(self, command: LookAtRows) -> ManageReply:
        table, plan, classes = command.table, self._plan(), self._classes()
        with Database.open(self._path) as database:
            tables, schema = database.tables()
            revision = database.revision()
        listed = [
            {"table": name, "rows": len(_own(tables, name, plan.robot)), "fixed": forms.fixed(row)}
            for name, row in classes.items()
            if name in schema
        ]
        if not table:
            return ManageReply(accepted=True, revision=revision, data={"tables": listed})
        row = forms.of(table, schema, classes)
        data = {
            "table": table,
            "key": list(row.KEY),
            "fixed": forms.fixed(row),
            "schema": forms.schema(row),
            "settings": self._settings(row, plan),
            "rows": [forms.json_row(row, one) for one in _own(tables, table, plan.robot)],
        }
        return ManageReply(accepted=True, revision=revision, data=data)

    def _settings(self, row: type[Row], plan: Plan) -> dict[str, object]:
        """Return the schemas of the column `settings`, by the row's name."""
        if row is CapabilityRow:
            return {name: msgspec.json.schema(kind.settings) for name, kind in plan.kinds.items()}
        if row is DeviceRow:
            return {one.name: found for one in plan.rows.devices if (found := _of_twin(one.type)) is not None}
        return {}

    def _change(self, command: ChangeRows) -> ManageReply:
        before, planned = self._plan(), None

        def judge(rows: RobotRows) -> tuple[Problem, ...]:
            nonlocal planned
            made, found = self._make(rows)
            planned = planned or made
            return (*found, *_letting_in(before.rows, rows))

        with Database.open(self._path, program="executive") as database:
            try:
                proposed = propose(
                    database,
                    forms.wanted(before.robot, command.changes, self._classes()),
                    judge,
                    robot=before.robot,
                    by=command.by or "a page",
                    dry_run=not command.write,
                )
            except forms.ChangedError as err:
                return self._changed(database, err)
        touched, revision, problems = _touched(before, planned), proposed.revision, proposed.problems
        if problems:
            row_problems = tuple(
                RowProblem(**asdict(replace(one, row=one.row.removeprefix(f"{before.robot}/")))) for one in problems
            )
            more = f"; and {len(problems) - 1} more" * (len(problems) > 1)
            refusal = self.refused(f"{problems[0]}{more}", "bad_value")
            return replace(refusal, revision=revision, problems=row_problems, touched=touched)
        return ManageReply(accepted=True, revision=revision, touched=touched)

    def _undo(self, command: UndoRows) -> ManageReply:
        with Database.open(self._path, program="executive") as database:
            before, after, schema = database.around(command.revision, command.by)
        forms_back = forms.undoing(before, after, schema, self._classes())
        return self._change(ChangeRows(changes=forms_back, write=True, by=command.by))

    def _changed(self, database: Database, err: forms.ChangedError) -> ManageReply:
        """Return the refusal to change a row that has changed meanwhile, with its author and the time."""
        at, by = database.last_change(self._plan().robot, err.table, err.key) or ("", "")
        refusal = self.refused(f"{err} (by {by})" if by else str(err), err.code)
        return replace(refusal, revision=database.revision(), changed_by=by, changed_at=at)

    def _events(self, command: LookAtEvents) -> ManageReply:
        levels = history.LEVELS[history.LEVELS.index(command.level) :]
        with Database.open(self._path) as database:
            found = database.events(command.limit, subject=command.subject, levels=levels)
        told = ("kind", "subject", "text", "level", "wall_ns")
        data = [{name: getattr(one, name) for name in told} for one in reversed(found)]
        return ManageReply(accepted=True, data={"events": data})

    def _devices(self, _command: LookAtDevices) -> ManageReply:
        return ManageReply(accepted=True, data=look(self._plan().robot, self._path))

    def _tokens(self, _command: LookAtTokens) -> ManageReply:
        with Database.open(self._path) as database:
            found = database.tokens()
        data = [{name: value for name, value in asdict(one).items() if name != "hash"} for one in found]
        return ManageReply(accepted=True, data={"tokens": data})

    def _rename(self, command: RenameToken) -> ManageReply:
        with Database.open(self._path) as database:
            database.rename_token(command.name, command.called)
        return ManageReply(accepted=True, reason=f"'{command.name}' is called '{command.called}'")

    def _revoke(self, command: RevokeToken) -> ManageReply:
        with Database.open(self._path) as database:
            database.revoke_token(command.name)
        return ManageReply(accepted=True, reason=f"'{command.name}' is revoked")

    def _log(self, command: LookAtLog) -> ManageReply:
        name, plan = command.name, self._plan()
        file = plan.log(name)
        if not file:
            raise InputError(f"there is no capability '{short(name)}'", "unknown_name")
        try:
            with (home.directory("logs") / file).open("rb") as log:
                left_out = max(0, os.fstat(log.fileno()).st_size - LOG_BYTES)
                log.seek(left_out)
                text = log.read(LOG_BYTES).decode(errors="replace")
        except FileNotFoundError:
            left_out, text = 0, ""
        except OSError as err:
            raise InputError(f"the log of '{name}' cannot be read: {err.strerror}", "failed") from err
        whole = text.partition("\n")[2] if left_out else text
        return ManageReply(accepted=True, data={"name": name, "text": whole})


def _letting_in(before: RobotRows, after: RobotRows) -> Iterator[Problem]:
    """Yield changes that would affect who has access: a taken-over page's server could admit others."""
    old = {row.name: row for row in before.capabilities}
    for row in after.capabilities:
        was = old.get(row.name)
        if row == was:
            continue
        with contextlib.suppress(KindError):  # reported as such
            kind = registry.find(row.kind, home.home())
            now, then = _deciding(kind, row), _deciding(kind, was if was and was.kind == row.kind else None)
            for name in kind.rights.lets_in if now is not None else ():
                if then is None or now is None or now[name] != then[name]:
                    column = name if name == "enabled" else "settings"
                    yield Problem(row.TABLE, f"{after.robot.name}/{row.name}", column, f"{name} {LETS_IN}")


def _deciding(kind: Kind, row: CapabilityRow | None) -> dict[str, object] | None:
    """Return the parts of a row that decide who has access; without a row, a new one's. None if it is unreadable."""
    try:
        settings = kind.parse(row.settings if row is not None else "{}")
    except UNREADABLE:  # reported as such
        return None
    columns = {"enabled": row is not None and row.enabled}
    return {name: columns[name] if name in columns else getattr(settings, name) for name in kind.rights.lets_in}


def _own(tables: Any, table: str, robot: str) -> list[Any]:
    """Return the rows of a table that belong to this robot, or to every robot."""
    name = "name" if table == "robot" else "robot"
    return [row for row in tables.get(table, ()) if row.get(name, robot) == robot]


def _of_twin(device: str) -> dict[str, object] | None:
    try:
        found = twins.find(device)
    except KindError:
        return None
    return msgspec.json.schema(found.row) if found is not None else None


def _touched(before: Plan, new: Plan | None) -> Touched | None:
    if new is None:
        return None
    change = plans.difference(before, new)
    return Touched(start=change.start, stop=change.stop, restart=change.restart, plug=change.plug)


def _listed(command: ChangeRows) -> str:
    entries = []
    for change in command.changes:
        before, after = change.before or {}, change.after or {}
        name = before.get("name", after.get("name", ""))
        what = "deleted" if change.after is None else "new" if change.before is None else ""
        columns = ", ".join(key for key, value in after.items() if value != before.get(key))
        entries.append(f"{change.table} '{short(name)}' ({what or columns})")
    return ", ".join(entries)[:300]
