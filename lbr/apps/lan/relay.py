"""Receives messages at the door that may move or change something, and sends them to the robot, marked as from afar.

Messages of another machine may be old: a network that heals delivers delayed ones. Only the robot can judge that, so
such messages never pass from router to router. Stops and emergency stops do, and never wait here.
"""

import threading
import time
from collections.abc import Callable, Mapping
from typing import get_args

from lbr.apps.http.rates import Bucket
from lbr.bus import keys, stamp, wire
from lbr.bus.session import Session
from lbr.messages.codes import Reason
from lbr.messages.leases import refused
from lbr.messages.system import ConsoleResult, Role

COMMAND_S = 3.0
LINE_S = 600.0
MOST_UNDER_WAY = 32
MOST_UNDER_WAY_IN_ALL = 128
PER_KEY_HZ = 150.0
IN_ALL_HZ = 400.0
POLL_S = 0.2


class Lane:
    """One key behind the door, with its requests under way; `line`: it is for console lines."""

    def __init__(
        self,
        inside: Session,
        key: str,
        wake: Callable[[], None],
        source: str,
        *,
        line: bool = False,
        puts: bool = False,
    ) -> None:
        self.line = line
        self.served = wire.QueryServer(inside, key, wake, puts=puts, source=source)
        self.bucket = Bucket(PER_KEY_HZ, time.monotonic())
        self.under_way: list[tuple[wire.Request, wire.PendingQuery]] = []


class Relay:
    """Works in a thread of its own, in which nothing blocks; `turns` counts its rounds.

    `secrets` are the tokens' by name; `refused(text)` receives the reason of each refusal.
    """

    def __init__(
        self,
        inside: Session,
        robot_side: Session,
        robot: str,
        commands: tuple[str, ...],
        *,
        via: str,
        secrets: Mapping[str, bytes],
        refused: Callable[[str], None],
    ) -> None:
        self.turns = 0
        self._secrets = secrets
        self._bus = robot_side
        self._via = via
        self._refused = refused
        self._wake = threading.Event()
        self._closing = False
        self._bucket = Bucket(IN_ALL_HZ, time.monotonic())
        lines = [keys.console(robot, role) for role in get_args(Role)]
        self._lanes = [Lane(inside, key, self._wake.set, via, puts=True) for key in commands]
        self._lanes += [Lane(inside, key, self._wake.set, via, line=True) for key in lines]
        self._lanes.append(Lane(inside, keys.estop_reset(robot), self._wake.set, via))
        self._thread = threading.Thread(target=self._run, name="relay", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Stop."""
        self._closing = True
        self._wake.set()
        self._thread.join(POLL_S)

    def _run(self) -> None:
        while not self._closing:
            self._wake.wait(POLL_S)
            self._wake.clear()
            self.turns += 1
            now = time.monotonic()
            for lane in self._lanes:
                self._answer(lane)
                for request in lane.served.take():
                    self._take(lane, request, now)

    def _take(self, lane: Lane, request: wire.Request, now: float) -> None:
        why_not = self._too_much(lane, request, now)
        if why_not:
            self._refuse(lane, request, Reason("busy", why_not))
            return
        attachment = stamp.passed_on(request.attachment, self._via, self._token(request))
        if not request.answerable:
            wire.forward(self._bus, request.key, request.payload, attachment)
            return
        question = wire.PendingQuery(
            self._bus,
            request.key,
            request.payload,
            timeout_s=LINE_S if lane.line else COMMAND_S,
            source=self._via,
            attachment=attachment,
            wake=self._wake.set,
        )
        lane.under_way.append((request, question))

    def _token(self, request: wire.Request) -> str:
        """Return the token that a message's seal proves, or an empty string."""
        seal = stamp.read(request.attachment)
        secret = self._secrets.get(seal.token) if seal is not None else None
        proven = secret is not None and stamp.genuine(seal, request.payload, secret)
        return seal.token if seal is not None and proven else ""

    def _too_much(self, lane: Lane, request: wire.Request, now: float) -> str:
        if len(request.payload) > wire.MAX_COMMAND_BYTES:
            return f"a message may have {wire.MAX_COMMAND_BYTES} bytes, not {len(request.payload)}"
        under_way = sum(len(one.under_way) for one in self._lanes)
        if len(lane.under_way) >= MOST_UNDER_WAY or under_way >= MOST_UNDER_WAY_IN_ALL:
            return f"too much is under way from other machines ({request.key})"
        if not (lane.bucket.take(now) and self._bucket.take(now)):
            return f"too many messages a second from other machines ({request.key})"
        return ""

    def _refuse(self, lane: Lane, request: wire.Request, why: Reason) -> None:
        self._refused(why.text)
        request.reply(
            ConsoleResult(code=1, text=why.text, reason_code=why.code) if lane.line else refused(why), self._via
        )

    def _answer(self, lane: Lane) -> None:
        waiting = []
        for request, question in lane.under_way:
            if question.replies:
                answer = question.replies[0]
                request.forward_reply(answer.payload, answer.attachment)
            elif question.done:
                self._refuse(lane, request, Reason("unreachable", f"no capability answers on {request.key}"))
            else:
                waiting.append((request, question))
        lane.under_way = waiting
