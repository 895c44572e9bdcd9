"""A bus that is nothing but answers, for the server's API."""

import json
import time
from collections.abc import Callable, Iterable, Mapping
from math import inf
from typing import Any

import msgspec

from lbr.bus import stamp
from lbr.bus.wire import RawMessage, encode
from lbr.capability.context import PendingReply
from lbr.messages.description import CapabilityDescription, CommandDescription, RobotDescription
from lbr.messages.drive import DriveCommand, DriveState, TurnCommand
from lbr.messages.leases import CommandReply, StopCommand
from lbr.messages.system import CapabilityStatus, ConsoleResult, EstopState, Status

ROBOT = "uxa90"  # as `web_stage.Stage` has it
STANDS = {"moving": False, "power": 0.0, "estop": False}


def described(revision: int = 7, **more: Any) -> RobotDescription:
    """A robot with a base, a light, and a camera."""
    held = {"role": "operate", "leased": True}
    drive = CapabilityDescription(
        name="drive",
        kind="drive",
        family="operation",
        summary="moves",
        outputs={"state": msgspec.json.schema(DriveState)},
        commands={
            "command": CommandDescription(schema=msgspec.json.schema(DriveCommand), **held),
            "turn": CommandDescription(schema=msgspec.json.schema(TurnCommand), **held),
            "stop": CommandDescription(schema=msgspec.json.schema(StopCommand), role="view", leased=False),
        },
    )
    light = CapabilityDescription(
        name="light",
        kind="exec",
        family="program",
        summary="shines",
        outputs={"state": {}},
        commands={
            "switch": CommandDescription(schema={}, role="operate", leased=False),
            "burn": CommandDescription(schema={}, role="admin", leased=False),
        },
    )
    camera = CapabilityDescription(
        name="camera_front",
        kind="camera",
        family="driver",
        summary="sees",
        outputs={"frame": {"title": "JpegFrame", "contentMediaType": "image/jpeg"}},
        commands={},
    )
    words = (
        {"word": "f", "pattern": "f", "role": "operate", "help": "ahead", "target": "drive.command", "fields": []},
    )
    return RobotDescription(
        robot=ROBOT, simulated=True, revision=revision, capabilities=(drive, light, camera), words=words, **more
    )


def status(revision: int = 7, pid: int = 4) -> Status:
    """A robot that is well."""
    drive = CapabilityStatus(
        name="drive", kind="drive", phase="ready", pid=5, restarts=0, uptime_s=1.0, reason="", rates_hz={}
    )
    return Status(
        robot=ROBOT,
        profile="sim",
        ready=True,
        pid=pid,
        uptime_s=1.0,
        estop=EstopState(engaged=False, reason=""),
        capabilities=(drive,),
        revision=revision,
    )


def _stops(said: Any) -> ConsoleResult | None:
    """What the robot answers where a test says nothing else: it stops, and is silent on all else."""
    return ConsoleResult(code=0, text="stopped") if said == "stop" else None


class Feed:
    def __init__(self) -> None:
        self.came: list[RawMessage] = []
        self.closed = False

    def take(self) -> list[RawMessage]:
        came, self.came = self.came, []
        return came

    def close(self) -> None:
        self.closed = True


class Question:
    def __init__(self, key: str, answer: Any) -> None:
        payload = answer if isinstance(answer, bytes) else encode(answer)
        self.replies = [] if answer is None else [raw(key, payload)]
        self.done = answer is None


class StageBus:
    """Hears what a test says, and asks what a test answers: `answers` by key, `say` has a stream say something."""

    def __init__(self, name: str = ROBOT) -> None:
        self.name = name
        self.feeds: dict[str, list[Feed]] = {}
        self.asked: list[tuple[str, Any, str]] = []
        self.robot = described()
        self.answers: dict[str, Callable[[Any], Any]] = {}
        self.lent = Lender()
        self.waited_s: dict[str, float] = {}
        self.sent_s: dict[str, float | None] = {}
        self.closed = False

    def hear(self, key: str, *, depth: int = 1) -> Feed:
        del depth
        feed = Feed()
        self.feeds.setdefault(key, []).append(feed)
        return feed

    def ask(
        self,
        key: str,
        payload: bytes,
        *,
        source: str,
        timeout_s: float,
        waited_s: float = 0.0,
        sent_s: float | None = None,
        wake: Callable[[], None] = lambda: None,
    ) -> Question:
        del timeout_s
        self.waited_s[key], self.sent_s[key] = waited_s, sent_s
        if payload == b"/report/robot":
            return Question(key, {"code": 0, "text": "", "data": self.robot})
        said: Any = payload.decode() if "@console" in key else json.loads(payload or b"null")
        self.asked.append((key, said, source))
        wake()
        return Question(key, self.reply(key, said))

    def reply(self, key: str, said: Any) -> Any:
        return self.answers.get(key, _stops)(said)

    def transport(
        self, source: str, keys: Mapping[str, str], wake: Callable[[], None], origin: stamp.Origin | None = None
    ) -> "Lent":
        return Lent(self.lent, source, dict(keys), wake, origin)

    def say(self, name: str, message: Any) -> None:
        """Publish on a key below the robot's name."""
        payload = message if isinstance(message, bytes) else encode(message)
        key = f"{self.name}/{name}"
        for feed in self.feeds.get(key, ()):
            feed.came.append(raw(key, payload))

    def close(self) -> None:
        self.closed = True


class Reply(PendingReply):
    def __init__(self, answer: CommandReply | None) -> None:
        self._answer = answer

    def answers(self) -> dict[str, Any]:
        return {"drive": self._answer}


class Lender:
    """A base that lends itself to one at a time, by leases that lapse."""

    TTL_S = 0.3

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self.clock = clock
        self.refusal: CommandReply | None = None
        self.ended: CommandReply | None = None
        self.holder = ""
        self.moves: list[tuple[float, str, Any]] = []
        self.halts: list[tuple[float, str, Any]] = []
        self.until = 0.0
        self.stopped = stamp.Origin("", -inf)
        self._count = 0

    def ask(self, source: str, request: str, message: Any, origin: stamp.Origin | None = None) -> CommandReply | None:
        now = self.clock()
        by, wanted_s = origin or (source, inf)
        if request.endswith("stop"):
            self.halts.append((now, source, message))
            self.holder = ""
            return CommandReply(accepted=True)
        self.moves.append((now, source, dict(message)))
        if by != self.stopped.source and not wanted_s > self.stopped.written_s:
            return CommandReply(accepted=False, code="stopped_since", reason="stopped after this was wanted")
        if self.refusal is not None:
            return self.refusal
        if self.holder and now < self.until and self.holder != source:
            text = f"held by {self.holder}; stop it first"
            return CommandReply(accepted=False, code="held", reason=text, holder=self.holder)
        if message.get("lease") and (self.ended is not None or not (self.holder and now < self.until)):
            ended, self.ended = self.ended, None
            return ended or CommandReply(accepted=False, code="dead_lease", cause="lapsed", reason="lease is dead")
        self._count += not message.get("lease")
        self.holder, self.until = source, now + self.TTL_S
        return CommandReply(accepted=True, lease=f"l{self._count}", ttl_s=self.TTL_S)

    @property
    def moving(self) -> bool:
        return bool(self.holder) and self.clock() < self.until


class Lent:
    """By what one source borrows."""

    def __init__(
        self,
        lender: Lender,
        source: str,
        keys: dict[str, str],
        wake: Callable[[], None],
        origin: stamp.Origin | None,
    ) -> None:
        self._lender, self._source, self._keys, self._wake, self._origin = lender, source, keys, wake, origin

    def ask(self, request: str, message: Any, timeout_s: float) -> Reply:
        del timeout_s
        plain = msgspec.to_builtins(message)
        self._wake()
        return Reply(self._lender.ask(self._source, self._keys[request], plain, self._origin))

    def clock(self) -> float:
        return self._lender.clock()


def raw(key: str, payload: bytes) -> RawMessage:
    return RawMessage(key, payload, stamp.make("test", 1), time.monotonic())


def keys(found: Iterable[tuple[str, Any, str]]) -> list[str]:
    return [key for key, _, _ in found]
