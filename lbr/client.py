"""A program's way to a robot: look, say a line, borrow motion. What stands still keeps nothing moving.

    from lbr import client                    # in the distribution lbr-client: import lbr_client as client

    with client.connect() as robot:           # the one that runs here; connect(at="tls/192.168.1.7:7447") elsewhere
        robot.say("/t/90")                    # as at the console; returns when the turn is over
        with robot.borrow("drive/command", power=0.2, angle_deg=0) as motion:
            while robot.latest("ranges/readings")["forward_m"] > 1.0:
                motion.keep()                 # ten times a second; what is not kept stops within the life of its lease
                time.sleep(0.05)

No thread renews a lease: a program that hangs, sleeps or is killed has let it lapse, and the robot stops by itself.
"""

import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from threading import Event
from typing import Any, NamedTuple, Self

import msgspec

from lbr.bus import session, wire
from lbr.bus.lease_client import ANSWER_S, LeaseClient, LeaseTarget
from lbr.bus.over_session import OverSession
from lbr.console import lines, target
from lbr.console.operator import BusOperator
from lbr.errors import BusError, LbrError
from lbr.messages.drive import GoalResult

Message = dict[str, Any]
"""A message as JSON has it: the fields of its schema (`lbr topic`, docs/reference)."""

POLL_S = 0.005
RESULT_S = 0.5
HELD_S = 5.0


class RefusalError(LbrError):
    """The robot says no, or no longer: `code` is one of docs/reference/codes.md, the text is for people."""

    def __init__(self, code: str, text: str) -> None:
        super().__init__(text)
        self.code = code


class Said(NamedTuple):
    """What a robot answered to a line: its words, what programs read, and how a motion that it began has ended."""

    text: str
    data: Any = None
    ending: str = ""


class Motion:
    """Motion that is borrowed: `keep` it ten times a second; a `with` releases it at its end."""

    def __init__(self, robot: "Robot", key: str, first: Message) -> None:
        self.message = dict(first)
        capability = key.partition("/")[0]
        ports = {"motion": robot.key(key), "halt": robot.key(f"{capability}/stop")}
        over = OverSession(robot.session, robot.source, ports)
        asked = LeaseTarget("motion", "halt", kind=capability, result_s=RESULT_S)
        self._results = wire.Subscription(robot.session, robot.key(f"{capability}/result"), depth=8)
        self._client = LeaseClient(over, asked, self.message)
        until = time.monotonic() + 2 * ANSWER_S
        while self._client.accepted is None and self._client.ended is None and time.monotonic() < until:
            time.sleep(POLL_S)
            self._client.step()
        if not self._client.holds:
            self._results.close()
            why = self._client.ended
            raise RefusalError(why.code, why.text) if why else BusError(f"'{key}' does not answer")

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_exc: object) -> None:
        self.release()

    @property
    def done(self) -> bool:
        """Return whether what it was to do is done: the angle, the distance, the key frames."""
        self._hear()
        return self._client.good

    def keep(self, **change: Any) -> bool:
        """Go on, with fields changed if any; False once it is done. Raise RefusalError when it goes on no longer."""
        self.message.update(change)
        self._hear()
        if self._client.ended is None:
            self._client.keep(self.message)
        elif not self._client.good:
            raise RefusalError(self._client.ended.code, self._client.ended.text)
        return not self._client.good

    def wait(self) -> None:
        """Keep it until it is done; raise RefusalError if it ends otherwise."""
        while self.keep():
            time.sleep(POLL_S)

    def release(self) -> None:
        """Stop it, if it is still ours."""
        asked = self._client.release("the program released it")
        until = time.monotonic() + ANSWER_S
        while asked is not None and asked.answers() is None and time.monotonic() < until:
            time.sleep(POLL_S)
        self._results.close()

    def _hear(self) -> None:
        for raw in self._results.take():
            with suppress(msgspec.DecodeError):
                self._client.hear(msgspec.json.decode(raw.payload, type=GoalResult))
        self._client.step()


class Robot:
    """A robot that is connected to; `role` is the most that it lets us do. Use it in a `with`, from one thread."""

    def __init__(self, found: target.Target, source: str) -> None:
        self.name = found.robot
        self.role = found.role
        self.source = source
        self.session = session.open_client(found.endpoints, found.credentials, certificate=found.certificate)
        self._operator = BusOperator(
            self.session, found.robot, source, role=found.role, proof=found.proof, listen=False
        )

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_exc: object) -> None:
        self.close()

    def close(self) -> None:
        """Stop what a line of ours moves, and disconnect."""
        self._operator.close()
        self.session.close()

    def key(self, name: str) -> str:
        """Return the whole key of `drive/state`, `@status` and their like."""
        return f"{self.name}/{name}"

    def latest(self, name: str) -> Message:
        """Return the newest message of a stream, or what else answers on a key; raise BusError if nothing does."""
        return self.ask(name)

    def ask(self, name: str, **message: Any) -> Message:
        """Give a command that borrows nothing, and return its reply; raise BusError if nothing answers."""
        for raw in wire.ask(self.session, self.key(name), message or None, source=self.source):
            found: Message = msgspec.json.decode(raw.payload)
            return found
        raise BusError(f"nothing answers on '{name}'; 'lbr topic list' names what there is")

    def stream(self, name: str, *, within_s: float = 2.0) -> Iterator[Message]:
        """Yield the messages of a stream as they come, always the newest; raise BusError after a silence."""
        came = Event()
        heard = wire.Subscription(self.session, self.key(name), wake=came.set)
        try:
            while came.wait(within_s):
                came.clear()
                for raw in heard.take():
                    yield msgspec.json.decode(raw.payload)
            raise BusError(f"nothing came on '{name}' for {within_s:g} s")
        finally:
            heard.close()

    def say(self, line: str, *, hold_s: float = HELD_S) -> Said:
        """Say a console line and return when it is done; motion without bounds is held for `hold_s`, then stopped.

        Raise RefusalError if it is refused, or ends otherwise than it was meant to.
        """
        result, code, ending = lines.say_once(self._operator, line, hold_s=hold_s, announce=lambda _result: None)
        if code != 0:
            said = ending or result
            raise RefusalError((ending.code if ending else result.reason_code) or "failed", said.text)
        return Said(result.text, result.data, ending.text if ending else "")

    def borrow(self, name: str, **message: Any) -> Motion:
        """Begin a motion such as `drive/command`, `drive/twist` or `joints/move`; raise RefusalError if it is refused."""
        return Motion(self, name, message)

    def stop(self) -> None:
        """Stop whatever moves."""
        self.say("stop")

    def estop(self, reason: str = "") -> None:
        """Engage the emergency stop, which stays until `reset`."""
        self.say(f"/estop/{reason}" if reason else "estop")

    def reset(self) -> None:
        """Release the emergency stop; nothing moves by that."""
        self.say("reset")


def connect(
    robot: str | None = None, *, at: str | None = None, token_file: Path | None = None, name: str = ""
) -> Robot:
    """Connect to the named robot, the one at an endpoint, or the only one that runs here; raise BusError or InputError.

    At another machine's door (`tls/HOST:PORT`) a token lets us in: `token_file`, $LBR_TOKEN, or one that `lbr` has
    saved. `name` is what refusals and events call this program.
    """
    return Robot(target.find(robot, at, token_file), target.source(name or "program"))


__all__ = ["BusError", "LbrError", "Message", "Motion", "RefusalError", "Robot", "Said", "connect"]
