"""Answers from the box's files, read on a thread one question at a time, as reading takes a while."""

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any

import msgspec
from msgspec import Struct

from lbr.apps.recorder.messages import HistoryCommand, HistoryReply, ThenCommand, ThenReply
from lbr.apps.recorder.recording.history import history
from lbr.apps.recorder.recording.moment import SILENT_S, Moment, moment
from lbr.apps.recorder.recording.shelf import Shelf
from lbr.capability.context import Call, Context
from lbr.errors import InputError
from lbr.messages.unreadable import UNREADABLE
from lbr.why.chain import explain
from lbr.why.snapshot import Facts, LatestMessage, Snapshot

MOST_WAITING = 4


class Past:
    """The pending questions, oldest first."""

    def __init__(self, ctx: Context[Struct], shelf: Shelf) -> None:
        self._ctx = ctx
        self._shelf = shelf
        self._pool = ThreadPoolExecutor(1, thread_name_prefix="past")
        self._asked: list[tuple[Call, Future[Struct]]] = []

    def ask(self, call: Call, read: Callable[[Shelf, Any], Struct]) -> None:
        """Queue a question; the thread reads its answer."""
        if len(self._asked) >= MOST_WAITING:
            call.refuse("other questions about the past are being answered; ask again", "busy")
            return
        reading = self._pool.submit(read, self._shelf, call.message)
        reading.add_done_callback(lambda _: self._ctx.wake())
        self._asked.append((call, reading))

    def step(self) -> None:
        """Send the answers that are ready."""
        done = [one for one in self._asked if one[1].done()]
        self._asked = [one for one in self._asked if one not in done]
        for call, reading in done:
            try:
                call.reply(reading.result())
            except InputError as err:
                call.refuse(str(err), err.code)
            except OSError as err:  # the oldest files may be deleted during a read
                call.refuse(f"the box cannot be read: {err}", "unreachable")

    def close(self) -> None:
        """Drop the pending questions."""
        self._pool.shutdown(wait=False, cancel_futures=True)


def read_history(shelf: Shelf, asked: HistoryCommand) -> HistoryReply:
    """Return the requested numbers."""
    found = history(shelf.files(), asked.fields, asked.from_ns, asked.to_ns, asked.points)
    return HistoryReply(accepted=True, at_ms=found.at_ms, values=found.values)


def snapshot(moment: Moment) -> Snapshot:
    """Return a moment in the form that `why` explains; raise InputError if its rows were not recorded."""
    if moment.rows is None:
        raise InputError("the rows of then are not in the recording, and without them nothing can be explained")
    try:
        facts = msgspec.json.decode(moment.rows.facts, type=Facts)
    except UNREADABLE as err:
        raise InputError(f"the rows of then are of another version: {err}") from None
    return Snapshot(
        facts=facts,
        executive="up" if moment.late_s <= SILENT_S else "down",
        status=moment.status,
        messages={name: LatestMessage(message=read, age_s=age_s) for name, (read, age_s) in moment.messages.items()},
        events=moment.events,
        wall_ns=moment.at_ns,
    )


def read_then(shelf: Shelf, asked: ThenCommand) -> ThenReply:
    """Return why something stood still at a moment; raise InputError if the moment was not recorded."""
    then = moment(tuple(shelf.files()), asked.at_ns)
    why = explain(snapshot(then), asked.part)
    return ThenReply(accepted=True, state=why.state, text=why.text, code=why.code, late_s=then.late_s)
