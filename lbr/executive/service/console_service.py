"""Console lines from the bus: each is answered by a thread of a pool, and a stop never waits behind other lines."""

import contextlib
import json
import threading
import traceback
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import get_args

from lbr.bus import keys, stamp, wire
from lbr.bus.session import Session
from lbr.console.stops import is_stop
from lbr.executive.service.dispatch import Dispatcher, Sender
from lbr.executive.service.journal import sender
from lbr.executive.services import Service
from lbr.messages.system import ConsoleResult, Role

MAX_LINE_BYTES = 1 << 16
MOST_UNDER_WAY = 64
STOPPERS = 16
MOST_STOPPERS = 256
"""As many stops as all permitted senders may send within 2 s, the longest wait for a mover that does not answer."""


class Stops:
    """Answers stops, several at once. Equal stops of one source that still wait are combined: one stop answers them
    all.

    Its threads start at the beginning, so that stops work even on a machine that starts no more threads. While all of
    them wait, more are started for as long as stops come.
    """

    def __init__(self, answer: Callable[[wire.Request, str | bytes, Role], ConsoleResult]) -> None:
        self._answer = answer
        self._changed = threading.Condition()
        self._waiting: dict[tuple[tuple[str, bool], str | bytes, Role], list[wire.Request]] = {}
        self._closed = False
        self._idle = self._helpers = 0

    def start(self) -> None:
        """Begin to answer."""
        for number in range(STOPPERS):
            threading.Thread(target=self._run, name=f"stop_{number}", daemon=True).start()

    def put(self, request: wire.Request, line: str | bytes, role: Role) -> None:
        """Answer a stop as soon as possible."""
        found = stamp.read(request.attachment)
        who = (sender(found), bool(found and found.via))
        with self._changed:
            self._waiting.setdefault((who, line, role), []).append(request)
            self._changed.notify()
            if len(self._waiting) > self._idle and self._helpers < MOST_STOPPERS - STOPPERS:
                self._begin_helper()

    def close(self) -> None:
        """Begin no more stops; those under way end by themselves."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()

    def _begin_helper(self) -> None:
        with contextlib.suppress(RuntimeError):  # the machine starts no more threads: the running ones answer later
            threading.Thread(target=self._run, args=(True,), name="stop_more", daemon=True).start()
            self._helpers += 1

    def _run(self, helper: bool = False) -> None:
        while True:
            with self._changed:
                self._idle += 1
                self._changed.wait_for(lambda: self._closed or self._waiting, 0.0 if helper else None)
                self._idle -= 1
                if self._closed or not self._waiting:
                    self._helpers -= helper
                    return
                key = next(iter(self._waiting))
                requests = self._waiting.pop(key)
            try:
                self._run_one(requests, *key[1:])
            except Exception as err:  # noqa: BLE001 - the bus is gone; the next stop needs this thread
                traceback.print_exception(err)

    def _run_one(self, requests: list[wire.Request], line: str | bytes, role: Role) -> None:
        last = max(requests, key=lambda one: stamp.sent_s(stamp.read(one.attachment), one.arrived))
        result = self._answer(last, line, role)
        for request in requests:
            request.reply(result, "executive")


class ConsoleService(Service):
    """Receives lines directly on the bus's thread, so that they never wait for the executive."""

    def __init__(self, bus: Session, robot: str, dispatcher: Dispatcher) -> None:
        self._dispatcher = dispatcher
        self._room = threading.Semaphore(MOST_UNDER_WAY)
        self._talk = ThreadPoolExecutor(max_workers=16, thread_name_prefix="line")
        self._stops = Stops(self._result)
        self._stops.start()
        self._lines: dict[tuple[Role, bool], wire.QueryServer] = {}
        for role in get_args(Role):
            for key, page in ((keys.console(robot, role), False), (keys.console_of_pages(robot, role), True)):
                self._lines[role, page] = wire.QueryServer(bus, key, self._take, puts=False, source="executive")

    def close(self) -> None:
        """Accept no more lines; those under way end by themselves."""
        for lines in self._lines.values():
            lines.close()
        self._talk.shutdown(wait=False, cancel_futures=True)
        self._stops.close()

    def _take(self) -> None:
        for (role, page), lines in list(self._lines.items()):
            for request in lines.take():
                self._sort(request, role, page)

    def _sort(self, request: wire.Request, role: Role, page: bool) -> None:
        line = _line(request.payload)
        if is_stop(line):
            self._stops.put(request, line, role)
        elif not self._room.acquire(blocking=False):
            busy = ConsoleResult(code=1, text="too many lines at once; try again", reason_code="busy")
            request.reply(busy, "executive")
        else:
            try:
                answered = self._talk.submit(self._answer, request, line, role, page)
            except RuntimeError:  # it is closed: the robot shuts down
                self._room.release()
            else:
                answered.add_done_callback(lambda _answered: self._room.release())

    def _answer(self, request: wire.Request, line: str | bytes, role: Role, page: bool) -> None:
        request.reply(self._result(request, line, role, page=page), "executive")

    def _result(self, request: wire.Request, line: str | bytes, role: Role, *, page: bool = False) -> ConsoleResult:
        if len(request.payload) > MAX_LINE_BYTES:
            text = f"a line has at most 4096 characters, not {len(request.payload)}"
            return ConsoleResult(code=2, text=text, reason_code="bad_value")
        sent = stamp.read(request.attachment)
        by = Sender(
            sender(sent),
            role,
            sent_s=stamp.sent_s(sent, request.arrived),
            remote_stamp=request.attachment if sent and sent.via else b"",
            waited_s=sent.waited_s if sent is not None else 0.0,
            page=page,
        )
        return self._dispatcher.execute(line, by)


def _line(payload: bytes) -> str | bytes:
    """Return the line: plain text, a JSON string, or a capability's `LineCommand`."""
    if payload[:1] in {b'"', b"{"}:
        with contextlib.suppress(ValueError, RecursionError):
            said = json.loads(payload)
            return str(said.get("line", "") if isinstance(said, dict) else said)
    return payload
