"""A connected robot: a program reads it, sends it lines, borrows its motion."""

import atexit
import os
from collections.abc import Callable, Generator
from contextlib import closing
from functools import partial
from pathlib import Path
from threading import Event
from typing import Any, NamedTuple, Self
from weakref import ref

import msgspec

from lbr import home
from lbr.bus import wire
from lbr.bus.session import FORKED, Session, open_client
from lbr.client.motion import AT_MOST_S, WHAT_THERE_IS, KeptMotion, Message, Motion, RefusalError, of_numbers
from lbr.client.words import Words
from lbr.console import lines, target
from lbr.console.operator import BusOperator
from lbr.errors import BusError
from lbr.messages.system import RANKS, Role

HELD_S = 5.0
GONE = "the robot has ended since this program connected; if it runs again, connect again"


class LineResult(NamedTuple):
    """A robot's answer to a line: its text, the data for programs, and the end of the motion that it began."""

    text: str
    data: Any = None
    ending: str = ""


class Picture(bytes):
    """A camera's picture: the bytes of a JPEG file, which a notebook shows."""

    __slots__ = ()

    def _repr_jpeg_(self) -> bytes:
        return bytes(self)


class Robot:
    """A connected robot; `role` is our highest role there. Use it in a `with`, from one thread."""

    def __init__(self, place: target.Target, source: str) -> None:
        self.name = place.robot
        self.role = place.role
        self.source = source
        self._by_token = place.proof is not None
        self._running = place.running
        self._process = os.getpid()
        self._session = open_client(place.endpoints, place.credentials, certificate=place.certificate)
        self._operator = BusOperator(
            self._session, place.robot, source, role=place.role, proof=place.proof, listen=False
        )
        self._words: Words[LineResult] | None = None
        self._leave = partial(_leave, ref(self))
        atexit.register(self._leave)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_exc: object) -> None:
        self.close()

    def close(self) -> None:
        """Stop the motion of our lines, and disconnect; this happens at the program's end if nobody has done it."""
        atexit.unregister(self._leave)
        if os.getpid() == self._process:
            self._operator.close()
            self._session.close()

    @property
    def session(self) -> Session:
        """Return our session of the bus; raise BusError in a forked process, which has none of its threads."""
        self._need_own_process()
        return self._session

    @property
    def operator(self) -> BusOperator:
        """Return the sender of our lines; raise BusError in a forked process."""
        self._need_own_process()
        return self._operator

    def _need_own_process(self) -> None:
        if os.getpid() != self._process:
            raise BusError(FORKED)

    @property
    def why_unanswered(self) -> str:
        """Return why an existing command may not answer us; empty if nothing prevents it."""
        if self._has_restarted:
            return GONE
        # the bus is silent when it drops a message that a role does not allow (docs/bus.md)
        return f"the role '{self.role}' may be too low for it" if self._by_token and self.role != "admin" else ""

    @property
    def _has_restarted(self) -> bool:
        """Return whether the robot has restarted since this connection began: the next run has another password."""
        return self._running is not None and self._running.pid not in {one.pid for one in home.running()}

    def _bus_error(self, why: str) -> BusError:
        return BusError(f"{why}; {GONE}" if self._has_restarted else why)

    def key(self, name: str) -> str:
        """Return the complete key of `drive/state`, `@status` and the like."""
        return f"{self.name}/{name}"

    def latest(self, name: str) -> Message:
        """Return the newest message of a stream, or another answer on a key; raise BusError without an answer."""
        return self._answer(name, {})

    def ask(self, name: str, **message: Any) -> Message:
        """Send a command that borrows nothing, and return its reply; raise RefusalError, or BusError without an
        answer."""
        reply = self._answer(name, of_numbers(message), self.why_unanswered)
        if reply.get("accepted") is False:
            raise RefusalError(reply.get("code", ""), reply.get("reason", ""))
        return reply

    def _answer(self, name: str, message: Message, why: str = "") -> Message:
        for raw in wire.ask(self.session, self.key(name), message or None, source=self.source):
            found: Message = msgspec.json.decode(raw.payload)
            return found
        hint = f"{why}; " if why and not self._has_restarted else ""
        raise self._bus_error(f"nothing answers on '{name}'; {hint}{WHAT_THERE_IS}")

    def stream(self, name: str, *, within_s: float = 2.0) -> Generator[Message, None, None]:
        """Yield the messages of a stream as they come, always the newest; raise BusError after a silence."""
        yield from map(msgspec.json.decode, self._payloads(name, within_s))

    def pictures(self, camera: str, *, within_s: float = 2.0) -> Generator[Picture, None, None]:
        """Yield the pictures of a camera such as `camera_front` as they come, always the newest; BusError after a
        silence."""
        yield from map(Picture, self._payloads(f"{camera}/frame", within_s))

    def picture(self, camera: str) -> Picture:
        """Return the next picture of a camera; BusError if none comes."""
        with closing(self.pictures(camera)) as found:
            return next(found)

    def say(self, line: str, *, hold_s: float = HELD_S) -> LineResult:
        """Send a console line and return when it is done; unbounded motion is held for `hold_s`, then stopped.

        Raise RefusalError if it is refused, or does not end as planned.
        """
        return self.say_kept(line, hold_s=hold_s, beat=self.operator.ear.beat)

    def say_kept(self, line: str, *, hold_s: float, beat: Callable[[], None]) -> LineResult:
        """Send a line as `say` does; its motion goes on only while `beat`, or another thread, calls
        `operator.ear.beat`."""
        try:
            result, code, ending = lines.say_once(
                self.operator, line, hold_s=hold_s, announce=lambda _result: None, beat=beat
            )
        except BusError as err:
            raise self._bus_error(str(err)) from err
        if code != 0:
            said = ending or result
            raise RefusalError((ending.code if ending else result.reason_code) or "failed", said.text)
        return LineResult(result.text, result.data, ending.text if ending else "")

    @property
    def do(self) -> Words[LineResult]:
        """Return the robot's words as methods: `robot.do.play("wave")` sends `/play/wave`; Tab completes them."""
        if self._words is None:
            self._words = Words(self.operator.words, self.say)
        return self._words

    def borrow(self, name: str, **message: Any) -> Motion:
        """Begin a motion such as `drive/command`, `drive/twist` or `joints/move`; raise RefusalError if it is
        refused."""
        return Motion(self, name, message)

    def hold(self, name: str, *, at_most_s: float = AT_MOST_S, **message: Any) -> KeptMotion:
        """Return a motion for a `with`: it begins there, is kept for `at_most_s`, and is released at the end."""
        return KeptMotion(lambda: self.borrow(name, **message), at_most_s)

    def drive(self, power: float, angle_deg: float = 0.0, *, at_most_s: float = AT_MOST_S) -> KeptMotion:
        """Drive within a `with`, at a share of full power (-1 to 1); 0 degrees is ahead, 90 to the right."""
        return self.hold("drive/command", at_most_s=at_most_s, power=power, angle_deg=angle_deg)

    def twist(
        self, vx_mps: float = 0.0, wz_rps: float = 0.0, *, vy_mps: float = 0.0, at_most_s: float = AT_MOST_S
    ) -> KeptMotion:
        """Drive within a `with`, with this twist (REP 103: ahead, anticlockwise, to the left)."""
        return self.hold("drive/twist", at_most_s=at_most_s, vx_mps=vx_mps, vy_mps=vy_mps, wz_rps=wz_rps)

    def turn(self, angle_deg: float) -> None:
        """Turn on the spot, clockwise positive; return when it is done."""
        with self.borrow("drive/turn", angle_deg=angle_deg) as motion:
            motion.wait()

    def stop(self) -> None:
        """Stop whatever moves."""
        self.say("stop")

    def estop(self, reason: str = "") -> None:
        """Engage the emergency stop, which stays until `reset`."""
        self.say(f"/estop/{reason}" if reason else "estop")

    def reset(self) -> None:
        """Release the emergency stop, without any motion."""
        self.say("reset")

    def _payloads(self, name: str, within_s: float) -> Generator[bytes, None, None]:
        came = Event()
        subscription = wire.Subscription(self.session, self.key(name), wake=came.set)
        try:
            while came.wait(within_s):
                came.clear()
                for raw in subscription.take():
                    yield raw.payload
            raise self._bus_error(f"nothing came on '{name}' for {within_s:g} s")
        finally:
            subscription.close()


def _leave(robot: "ref[Robot]") -> None:
    """Close a robot that its program left open, so that no thread is in the bus library when the interpreter ends."""
    found = robot()
    if found is not None:
        found.close()


def connect(
    robot: str | None = None,
    *,
    at: str | None = None,
    token_file: Path | str | None = None,
    name: str = "",
    role: Role = "admin",
) -> Robot:
    """Connect to the named robot, the one at an endpoint, or the only one that runs here; raise BusError or InputError.

    Another machine's door (`tls/HOST:PORT`) requires a token: `token_file`, $LBR_TOKEN, or one that `lbr` has saved.
    `name` is this program's name in refusals and events, and `role` the highest role of its lines.
    """
    target_ = target.find(robot, at, Path(token_file) if token_file else None)
    least = min(role, target_.role, key=RANKS.__getitem__)
    return Robot(msgspec.structs.replace(target_, role=least), target.source(name or "program"))
