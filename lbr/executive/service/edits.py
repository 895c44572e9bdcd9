"""Edits of rows for capabilities: of rows that a kind may write, in the name of a person."""

import time
from collections.abc import Callable
from dataclasses import KW_ONLY, dataclass
from functools import partial
from pathlib import Path

from msgspec import Struct

from lbr.bus import keys, stamp, wire
from lbr.bus.codec import Decoder
from lbr.database import edits
from lbr.database.proposals import Judge
from lbr.database.store import Database
from lbr.errors import InputError, RowError
from lbr.executive.planning.event_sink import EventSink
from lbr.executive.planning.live_rows import LiveRows
from lbr.executive.planning.wiring import EXECUTIVE
from lbr.executive.service.row_service import Job, Reply
from lbr.messages.codes import Code
from lbr.messages.faces import EditCommand, EditReply
from lbr.messages.rows import Row

WAITED_FOR_S = 5.0
"""A capability waits this long; a later edit restarts it, as it may not have learnt the result."""
SLOW_S = 1.0
_commands = Decoder(EditCommand)


class Edit(Struct, frozen=True):
    """A capability's request for an edit: its process, and the time."""

    name: str
    command: EditCommand
    rows: tuple[Row, ...]
    process: object
    begun_s: float


@dataclass(eq=False)
class Edits:
    """Reads requests for edits, and writes those that `judge` accepts; `process(name)` is a capability's process."""

    served: wire.QueryServer
    path: Path
    rows: LiveRows
    judge: Judge
    _: KW_ONLY
    process: Callable[[str], object]
    happened: EventSink
    clock: Callable[[], float] = time.monotonic

    def read(self, request: wire.Request) -> Job:
        """Return the edit that a wired capability requests, of rows that its kind may write."""
        sender = stamp.read(request.attachment)
        name = sender.source if sender is not None else ""
        if not self._may(name):
            raise InputError(f"'{name[:40]}' is not wired to executive.edit", "denied")
        command = _commands.decode(request.payload)
        rows = edits.understood(command, self.rows.plan.kinds[name].rights.edits)
        edit = Edit(name, command, rows, self.process(name), self.clock())
        return Job(request, self, partial(self._write, edit), partial(self._end, edit), holds=True)

    def refused(self, reason: str, code: Code) -> EditReply:
        """Return a refusal."""
        return EditReply(accepted=False, reason=reason, code=code, revision=self.rows.plan.rows.revision)

    def _may(self, name: str) -> bool:
        """Return whether rows wire a capability to this; the bus admits no other, but a stamp proves nothing."""
        plan = self.rows.plan
        asked = plan.units[name].config.requests.values() if name in plan.units else ()
        return any(one.get(EXECUTIVE) == keys.edit(plan.robot) for one in asked)

    def _write(self, edit: Edit) -> EditReply:
        command = edit.command
        try:
            with Database.open(self.path, program="executive") as database:
                proposed = edits.write_rows(
                    database,
                    self.rows.plan.robot,
                    edit.rows,
                    self.judge,
                    create=command.create,
                    revision=command.revision,
                    by=" for ".join(filter(None, (edit.name, command.by))),
                ).good()
        except RowError as err:
            more = len(err.problems) - 1
            return self.refused(err.problems[0] + f"; and {more} more" * bool(more), "bad_value")
        return EditReply(accepted=True, revision=proposed.revision)

    def _end(self, edit: Edit, reply: Reply) -> bool:
        if not reply.accepted:
            return False
        name, by, took_s = edit.name, edit.command.by, self.clock() - edit.begun_s
        if took_s < WAITED_FOR_S and self._may(name) and self.process(name) is edit.process:
            self.rows.knows(name, edit.rows)
        text = f"wrote {edits.names(edit.rows)[:300]}" + (f" for {by}" if by else "")
        self.happened("edit", name, text, data={"revision": reply.revision})
        if took_s > SLOW_S:
            self.happened("slow_disk", name, f"it took {took_s:.1f} s to write rows", "warning")
        return True
