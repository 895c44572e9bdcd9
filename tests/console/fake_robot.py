"""A small robot on a real bus: it answers console lines and motion commands, and keeps what was asked."""

import queue
import threading
import time
from typing import get_args

import msgspec

from lbr.bus import keys, session, stamp, wire
from lbr.messages.drive import GoalResult
from lbr.messages.leases import CommandReply
from lbr.messages.system import ConsoleResult, EstopState, Event, Hold, Role, Status

ROBOT = "rob"


class FakeRobot:
    """Answers on one thread. `lines` maps a console line to its result; leases live until they are killed."""

    def __init__(self, endpoint: str) -> None:
        self.endpoint = endpoint
        self.bus = session.open_router(session.Router(listen=(endpoint,)))
        self.lines: dict[str, ConsoleResult] = {}
        self.said: list[tuple[str, str, str]] = []
        self.waited: dict[str, float] = {}
        self.renewed: list[tuple[float, dict]] = []
        self.stopped: list[str] = []
        self.dead: dict[str, str] = {}
        self.mute = False
        self.blocked: dict[str, threading.Event] = {}
        self._wake: queue.SimpleQueue[bool] = queue.SimpleQueue()
        wake = lambda: self._wake.put(True)  # noqa: E731
        self._consoles = {role: wire.QueryServer(self.bus, keys.console(ROBOT, role), wake) for role in get_args(Role)}
        self._command = wire.QueryServer(self.bus, f"{ROBOT}/drive/command", wake)
        self._stop = wire.QueryServer(self.bus, f"{ROBOT}/drive/stop", wake)
        self.presses = wire.Subscription(self.bus, keys.estop(ROBOT), depth=8)
        self.results = wire.Publisher(self.bus, f"{ROBOT}/drive/result", "drive")
        self.events = wire.Publisher(self.bus, keys.event(ROBOT), "executive")
        self.status = wire.Publisher(self.bus, keys.status(ROBOT), "executive")
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def hold(self, lease: str, *, goal: str = "", max_run_s: float = 30.0) -> Hold:
        return Hold(
            lease=lease,
            ttl_s=0.3,
            key=f"{ROBOT}/drive/command",
            stop_key=f"{ROBOT}/drive/stop",
            result_key=f"{ROBOT}/drive/result",
            payload={"power": 0.2, "angle_deg": 0.0, "lease": lease},
            goal=goal,
            max_run_s=max_run_s,
        )

    def moves(self, line: str, lease: str, **bounds) -> Hold:
        hold = self.hold(lease, **bounds)
        self.lines[line] = ConsoleResult(code=0, text=f"moving under {lease}", hold=hold)
        return hold

    def finish(self, goal: str, result: str = "reached", reason: str = "") -> None:
        self.results.put(GoalResult(goal=goal, result=result, reason=reason, range_cm=40.0, elapsed_s=1.5))

    def tell(self, text: str, level: str = "info") -> None:
        self.events.put(Event(kind="test", subject="motors", text=text, level=level))

    def keep_telling(self) -> None:
        """Repeat status and one event until somebody has had time to listen."""
        self.tell("the battery is low", "warning")
        self.show()

    def show(self, *, ready: bool = True, revision: int = 1) -> None:
        estop = EstopState(engaged=False, reason="")
        self.status.put(
            Status(
                robot=ROBOT, profile="t", ready=ready, pid=1, uptime_s=1.0, estop=estop, capabilities=(), revision=revision
            )
        )  # fmt: skip

    def close(self) -> None:
        self._wake.put(False)
        for gate in self.blocked.values():
            gate.set()
        self._thread.join(5)
        self.bus.close()

    def _run(self) -> None:
        while self._wake.get():
            for role, console in self._consoles.items():
                for request in console.take():
                    self._answer(request, role)
            for request in self._command.take():
                self._renew(request)
            for request in self._stop.take():
                self.stopped.append(msgspec.json.decode(request.payload)["reason"])
                request.reply(CommandReply(accepted=True), "drive")

    def _answer(self, request: wire.Request, role: Role) -> None:
        line = request.payload.decode()
        found = stamp.read(request.attachment)
        self.waited[line] = found.waited_s
        self.said.append((line, found.source, role))
        result = self.lines.get(line, ConsoleResult(code=2, text=f"'{line}' is not a word of this robot"))
        gate = self.blocked.get(line)
        if gate is None:
            request.reply(result, "executive")
        else:
            threading.Thread(target=lambda: (gate.wait(5), request.reply(result, "executive")), daemon=True).start()

    def _renew(self, request: wire.Request) -> None:
        if self.mute:
            return
        payload = msgspec.json.decode(request.payload)
        lease = payload["lease"]
        if lease in self.dead:
            request.reply(CommandReply(accepted=False, code="dead_lease", reason=self.dead[lease]), "drive")
            return
        self.renewed.append((time.monotonic(), payload))
        request.reply(CommandReply(accepted=True, lease=lease, ttl_s=0.3), "drive")
