"""Edits of rows that capabilities ask for: written beside the main loop, as a client of SQLite's would, and
answered."""

import time
from collections import deque
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, Protocol

import msgspec
from msgspec import Struct
from msgspec.structs import replace

from lbr.bus import keys, stamp, wire
from lbr.bus.codec import Decoder
from lbr.database.edits import Edit, understood
from lbr.database.reading import Problem
from lbr.database.rows import RobotRows
from lbr.database.store import Database
from lbr.errors import InputError, LbrError, MalformedError, RowError
from lbr.executive import beside
from lbr.executive.planning.happened import Happened
from lbr.executive.planning.plan import Plan
from lbr.executive.planning.wiring import EXECUTIVE
from lbr.executive.processes.process_host import LARGEST_DOCUMENT_BYTES
from lbr.messages.faces import EditCommand, EditReply

WAITED_FOR_S = 5.0
"""Who asks waits this long; what is written later restarts it, since it may not know."""
SLOW_S = 1.0
MOST_WAITING = 16
MORE_IN_A_DOCUMENT_BYTES = 4096
"""What a process is told at its start besides what is planned."""
_edits = Decoder(EditCommand)


class Rows(Protocol):
    """The rows in force."""

    held: bool

    @property
    def plan(self) -> Plan:
        """Return the plan that runs."""

    def edited(self, name: str, edit: Edit) -> None:
        """Take note that a capability has an edit already."""


class Written:
    """Checks and writes an edit by a connection of its own; `make` plans what would run. From any thread."""

    def __init__(
        self, path: Path, robot: str, make: Callable[[RobotRows], tuple[Plan | None, tuple[Problem, ...]]]
    ) -> None:
        self._path = path
        self._robot = robot
        self._make = make

    def __call__(self, edit: Edit) -> EditReply:
        """Return what became of it."""
        revision = 0
        try:
            with Database.open(self._path, program="executive") as database:
                revision = database.revision()
                revision = database.edit(self._robot, edit, self._wrong)
        except RowError as err:
            more = len(err.problems) - 1
            return EditReply(
                accepted=False,
                code="bad_value",
                reason=err.problems[0] + f"; and {more} more" * bool(more),
                revision=revision,
            )
        except LbrError as err:
            code = err.code if isinstance(err, InputError) else "failed"
            return EditReply(accepted=False, reason=str(err), code=code, revision=revision)
        return EditReply(accepted=True, revision=revision)

    def setting(self, name: str, setting: str, value: Any, by: str = "") -> None:
        """Write one setting of a capability, and leave all others; RowError or InputError says why it may not be."""
        with Database.open(self._path, program="executive") as database:
            database.set_setting(self._robot, name, setting, value, self._wrong, by=by)

    def _wrong(self, rows: RobotRows) -> list[str]:
        plan, problems = self._make(rows)
        units = plan.units.values() if plan is not None else ()
        sizes = {unit.name: len(msgspec.json.encode(unit.config)) + MORE_IN_A_DOCUMENT_BYTES for unit in units}
        return [
            *map(str, problems),
            *(
                f"the rows for '{name}' would be too many: it can be given {LARGEST_DOCUMENT_BYTES} bytes of them"
                for name, size in sizes.items()
                if size > LARGEST_DOCUMENT_BYTES
            ),
        ]


class _Job(Struct):
    """An edit under way: who asked, by which process, and since when."""

    request: wire.Request
    edit: Edit
    name: str
    process: object
    begun_s: float
    reply: EditReply | None = None


class Edits:
    """Answers edits one after the other. `process(name)` is what runs for a capability now.

    The main thread calls `step`; a thread of its own waits for the disk meanwhile.
    """

    def __init__(
        self,
        served: wire.QueryServer,
        rows: Rows,
        write: Callable[[Edit], EditReply],
        *,
        process: Callable[[str], object],
        happened: Happened,
        wake: Callable[[], None],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._served = served
        self._rows = rows
        self._write = write
        self._process = process
        self._happened = happened
        self._wake = wake
        self._clock = clock
        self._waiting: deque[_Job] = deque()
        self._job: _Job | None = None

    def step(self) -> bool:
        """Begin and end what is due; say whether rows were written."""
        for request in self._served.take():
            self._take(request)
        job, written = self._job, False
        if job is not None and job.reply is not None:
            self._job = None
            self._rows.held = False
            self._end(job, job.reply)
            written = job.reply.accepted
        if self._job is None and self._waiting and not written:
            self._begin(self._waiting.popleft())
        return written

    def close(self) -> None:
        """Take no more; one under way is written, or not, by itself."""
        self._served.close()

    def _take(self, request: wire.Request) -> None:
        found = stamp.read(request.attachment)
        name = found.source if found is not None else ""
        revision = self._rows.plan.rows.revision
        if not self._may(name):
            text = f"'{name[:40]}' is not wired to executive.edit"
            request.reply(EditReply(accepted=False, reason=text, code="denied", revision=revision), EXECUTIVE)
            return
        if len(self._waiting) >= MOST_WAITING:
            request.reply(
                EditReply(accepted=False, reason="too many edits at once", code="busy", revision=revision), EXECUTIVE
            )
            return
        try:
            edit = replace(understood(_edits.decode(request.payload), self._rows.plan.kinds[name].edits), source=name)
        except (MalformedError, InputError) as err:
            text, code = (
                (str(err), err.code) if isinstance(err, InputError) else (f"malformed edit: {err}", "malformed")
            )
            request.reply(EditReply(accepted=False, reason=text, code=code, revision=revision), EXECUTIVE)
            return
        self._waiting.append(_Job(request, edit, name, self._process(name), self._clock()))

    def _may(self, name: str) -> bool:
        """Say whether rows wire a capability to this; the bus lets in no other, but a name in a stamp is a claim."""
        plan = self._rows.plan
        asked = plan.units[name].config.requests.values() if name in plan.units else ()
        return any(one.get(EXECUTIVE) == keys.edit(plan.robot) for one in asked)

    def _begin(self, job: _Job) -> None:
        self._job = job
        self._rows.held = True
        if beside.begin(partial(self._run, job), "edit") is None:
            job.reply = EditReply(
                accepted=False, code="busy", reason=beside.NO_THREAD, revision=self._rows.plan.rows.revision
            )
            self._wake()

    def _run(self, job: _Job) -> None:
        try:
            job.reply = self._write(job.edit)
        except Exception as err:  # noqa: BLE001 - the asker is to hear it, and the rows are not locked for ever
            job.reply = EditReply(
                accepted=False, code="failed", reason=f"this edit is broken: {type(err).__name__}: {err}"
            )
        self._wake()

    def _end(self, job: _Job, reply: EditReply) -> None:
        took_s = self._clock() - job.begun_s
        if reply.accepted:
            if took_s < WAITED_FOR_S and self._may(job.name) and self._process(job.name) is job.process:
                self._rows.edited(job.name, job.edit)
            by = f" for {job.edit.by}" if job.edit.by else ""
            text = f"wrote {str(job.edit)[:300]}{by}"
            self._happened("edit", job.name, text, "info", {"revision": reply.revision})
            if took_s > SLOW_S:
                self._happened("slow_disk", job.name, f"it took {took_s:.1f} s to write rows", "warning")
        job.request.reply(reply, EXECUTIVE)
