"""Console lines from the bus: each is answered by a thread of a pool, and a stop never waits behind other lines."""

import contextlib
import json
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import get_args

from lbr.bus import keys, stamp, wire
from lbr.bus.session import Session
from lbr.capability.calls import UNSTAMPED
from lbr.executive.service.dispatch import DONE, Dispatcher
from lbr.messages.system import ConsoleResult, Role, Stamp

MAX_LINE_BYTES = 1 << 16
MOST_UNDER_WAY = 64
STOPS = ("s", "stop", "estop")


class ConsoleService:
    """Takes lines straight from the bus's thread, so that nothing the executive waits for delays them."""

    def __init__(
        self,
        bus: Session,
        robot: str,
        dispatcher: Dispatcher,
        *,
        reset: Callable[[str], ConsoleResult],
    ) -> None:
        self._dispatcher = dispatcher
        self._reset = reset
        self._room = threading.Semaphore(MOST_UNDER_WAY)
        self._talk = ThreadPoolExecutor(max_workers=16, thread_name_prefix="line")
        self._stops = ThreadPoolExecutor(max_workers=4, thread_name_prefix="stop")
        self._bus = bus
        self._robot = robot
        self._lines: dict[Role, wire.Served] = {}

    def start(self) -> None:
        """Begin to take lines: on a key for each role, because the bus lets in who has it."""
        for role in get_args(Role):
            key = keys.console(self._robot, role)
            self._lines[role] = wire.Served(self._bus, key, self._take, puts=False, source="executive")

    def answer_reset(self, request: wire.Request) -> None:
        """Release the emergency stop for somebody on the bus."""
        _begin(self._stops, self._answer_reset, request)

    def close(self) -> None:
        """Take no more lines; those under way end by themselves."""
        for lines in self._lines.values():
            lines.close()
        self._talk.shutdown(wait=False, cancel_futures=True)
        self._stops.shutdown(wait=False, cancel_futures=True)

    def _take(self) -> None:
        for role, lines in list(self._lines.items()):
            for request in lines.take():
                self._sort(request, role)

    def _sort(self, request: wire.Request, role: Role) -> None:
        line = _line(request.payload)
        if _is_stop(line):
            _begin(self._stops, self._answer, request, line, role)
        elif not self._room.acquire(blocking=False):
            request.reply(
                ConsoleResult(code=1, text="too many lines at once; say it again", reason_code="busy"), "executive"
            )
        else:
            _begin(self._talk, self._answer, request, line, role, done=self._room.release)

    def _answer(self, request: wire.Request, line: str | bytes, role: Role) -> None:
        if len(request.payload) > MAX_LINE_BYTES:
            text = f"a line has at most 4096 characters, not {len(request.payload)}"
            request.reply(ConsoleResult(code=2, text=text, reason_code="bad_value"), "executive")
            return
        found = stamp.read(request.attachment)
        sent_s, afar = stamp.sent_s(found, request.arrived), request.attachment if found and found.via else b""
        waited_s = found.waited_s if found is not None else 0.0
        result = self._dispatcher.execute(
            line, source=_caller(found), role=role, sent_s=sent_s, afar=afar, waited_s=waited_s
        )
        request.reply(result, "executive")

    def _answer_reset(self, request: wire.Request) -> None:
        result = self._reset(_caller(stamp.read(request.attachment)))
        request.reply({"accepted": result.code == DONE, "reason": result.text}, "executive")


def _begin(
    pool: ThreadPoolExecutor, work: Callable[..., None], *values: object, done: Callable[[], object] = int
) -> None:
    """Let a pool do it; one that is closed leaves it undone, for the robot is shutting down."""
    try:
        pool.submit(work, *values).add_done_callback(lambda _future: done())
    except RuntimeError:
        done()


def _caller(found: Stamp | None) -> str:
    return found.source[:80] if found is not None and found.source else UNSTAMPED


def _is_stop(line: str | bytes) -> bool:
    begins = line.strip()[:64]
    text = begins.decode(errors="replace") if isinstance(begins, bytes) else begins
    word, _, more = text.strip("/").partition("/")
    return word.strip().lower() in STOPS and (not more or word == "estop")


def _line(payload: bytes) -> str | bytes:
    """Return the line: plain text, or a JSON string."""
    if payload[:1] == b'"':
        with contextlib.suppress(ValueError, RecursionError):
            return str(json.loads(payload))
    return payload
