"""Console lines from the bus: each is answered by a thread of a pool, and a stop never waits behind other lines."""

import contextlib
import json
import secrets
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

from lbr.bus import keys, stamp, wire
from lbr.bus.session import Session
from lbr.executive.dispatch import DONE, Dispatcher
from lbr.messages.system import ConsoleResult, Role

MAX_LINE_BYTES = 1 << 16
MOST_UNDER_WAY = 64
STOPS = ("s", "stop", "estop", "/estop")


class Service:
    """Takes lines straight from the bus's thread, so that nothing the executive waits for delays them."""

    def __init__(
        self,
        bus: Session,
        robot: str,
        dispatcher: Dispatcher,
        *,
        token: str,
        reset: Callable[[str], ConsoleResult],
    ) -> None:
        self._dispatcher = dispatcher
        self._token = token.encode()
        self._reset = reset
        self._under_way = 0
        self._talk = ThreadPoolExecutor(max_workers=16, thread_name_prefix="line")
        self._stops = ThreadPoolExecutor(max_workers=4, thread_name_prefix="stop")
        self._bus = bus
        self._key = keys.console(robot)
        self._lines: wire.Served | None = None

    def start(self) -> None:
        """Begin to take lines."""
        self._lines = wire.Served(self._bus, self._key, self._take, puts=False, source="executive")

    def answer_reset(self, request: wire.Request) -> None:
        """Release the emergency stop for somebody on the bus."""
        self._stops.submit(self._answer_reset, request)

    def close(self) -> None:
        """Take no more lines; those under way end by themselves."""
        if self._lines is not None:
            self._lines.close()
        self._talk.shutdown(wait=False, cancel_futures=True)
        self._stops.shutdown(wait=False, cancel_futures=True)

    def _take(self) -> None:
        for request in self._lines.take() if self._lines is not None else ():
            line = _line(request.payload)
            if _is_stop(line):
                self._stops.submit(self._answer, request, line)
            elif self._under_way >= MOST_UNDER_WAY:
                request.reply(ConsoleResult(code=1, text="too many lines at once; say it again"), "executive")
            else:
                self._under_way += 1
                self._talk.submit(self._answer, request, line).add_done_callback(self._done)

    def _done(self, _future: object) -> None:
        self._under_way -= 1

    def _answer(self, request: wire.Request, line: str | bytes) -> None:
        if len(request.payload) > MAX_LINE_BYTES:
            text = f"a line has at most 4096 characters, not {len(request.payload)}"
            request.reply(ConsoleResult(code=2, text=text), "executive")
            return
        found = stamp.read(request.attachment)
        source, role = self._caller(found.source if found else "", found.token if found else "")
        sent_s = stamp.sent_s(found, request.arrived)
        request.reply(self._dispatcher.execute(line, source=source, role=role, sent_s=sent_s), "executive")

    def _answer_reset(self, request: wire.Request) -> None:
        found = stamp.read(request.attachment)
        result = self._reset(self._caller(found.source if found else "", "")[0])
        request.reply({"accepted": result.code == DONE, "reason": result.text}, "executive")

    def _caller(self, source: str, token: str) -> tuple[str, Role]:
        local = secrets.compare_digest(token.encode(errors="replace"), self._token)
        return source[:80] or "a bus client", "admin" if local else "operate"


def _is_stop(line: str | bytes) -> bool:
    text = line[:64].decode(errors="replace") if isinstance(line, bytes) else line[:64]
    return text.strip().lower() in STOPS or text.strip().startswith("/estop")


def _line(payload: bytes) -> str | bytes:
    """Return the line: plain text, or a JSON string."""
    if payload[:1] == b'"':
        with contextlib.suppress(ValueError, RecursionError):
            return str(json.loads(payload))
    return payload
