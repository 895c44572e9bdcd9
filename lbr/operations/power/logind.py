"""Questions to logind over D-Bus, to power the computer off; in a thread of its own, because answers may take time.

The calls: `CanPowerOff() -> s` (yes, no, challenge, na) and `PowerOff(b interactive)`, never interactive, because no
user is present. A refusal by polkit comes back as `no`, `challenge` or an error.
"""

import asyncio
import threading
from collections.abc import Callable
from queue import SimpleQueue
from typing import TYPE_CHECKING, Literal, NamedTuple

if TYPE_CHECKING:
    from dbus_fast import Message

Question = Literal["CanPowerOff", "PowerOff"]

SERVICE, PATH, INTERFACE = "org.freedesktop.login1", "/org/freedesktop/login1", "org.freedesktop.login1.Manager"
DENIED = ("InteractiveAuthorizationRequired", "AccessDenied", "NotAuthorized", "PermissionDenied")
HOW = "let it by 'sudo lbr service install PROFILE --power-off', see docs/power.md"
_MEANINGS = {
    "yes": "",
    "no": f"polkit does not let this user power off; {HOW}",
    "challenge": f"polkit wants a password to power off, and no user is here to give one; {HOW}",
    "na": "this system cannot power off",
}
_END_S = 0.2


class Answer(NamedTuple):
    """The answer of logind: `word`, or an empty string, and `trouble`: the reason not to power off, for people."""

    question: Question
    word: str = ""
    trouble: str = ""


class Logind:
    """Asks in the background; `answers` returns the results, and `wake` is called for each."""

    def __init__(self, address: str, timeout_s: float, wake: Callable[[], None]) -> None:
        self._address = address
        self._timeout_s = timeout_s
        self._wake = wake
        self._questions: SimpleQueue[Question | None] = SimpleQueue()
        self._answers: SimpleQueue[Answer] = SimpleQueue()
        self._thread = threading.Thread(target=self._serve, name="logind", daemon=True)
        self._thread.start()

    def ask(self, question: Question) -> None:
        """Ask; the answer is certain to come within the timeout."""
        self._questions.put(question)

    def answers(self) -> list[Answer]:
        """Return the answers since the last call."""
        return [self._answers.get_nowait() for _ in range(self._answers.qsize())]

    def close(self) -> None:
        """Stop asking; a question in progress is abandoned."""
        self._questions.put(None)
        self._thread.join(_END_S)

    def _serve(self) -> None:
        while (question := self._questions.get()) is not None:
            self._answers.put(ask(self._address, question, self._timeout_s))
            self._wake()


def ask(address: str, question: Question, timeout_s: float) -> Answer:
    """Ask and wait for the answer; an error becomes an answer. `address` is that of a D-Bus, empty for the system's."""
    try:
        reply = asyncio.run(asyncio.wait_for(_call(address, question), timeout_s))
    except TimeoutError:
        return Answer(question, trouble=f"logind does not answer within {timeout_s:g} s")
    except Exception as err:  # noqa: BLE001 - the library has many; none may end the process
        where = address or "the system's D-Bus"
        why = getattr(err, "strerror", "") or err or type(err).__name__
        return Answer(question, trouble=f"logind cannot be asked at {where}: {why}")
    return reply if isinstance(reply, Answer) else Answer(question, reply, meaning(reply) if reply else "")


def meaning(word: str) -> str:
    """Return why logind's word forbids powering off, or an empty string."""
    return _MEANINGS.get(word, f"logind says '{word}'")


async def _call(address: str, question: Question) -> Answer | str:
    """Return logind's word, or an error as an answer; each call has a fresh connection."""
    from dbus_fast import BusType, Message, MessageType
    from dbus_fast.aio import MessageBus

    bus = await MessageBus(bus_address=address or None, bus_type=BusType.SYSTEM).connect()
    try:
        signature, body = ("b", [False]) if question == "PowerOff" else ("", [])
        message = Message(
            destination=SERVICE, path=PATH, interface=INTERFACE, member=question, signature=signature, body=body
        )
        reply = await bus.call(message)
        if reply is None or reply.message_type == MessageType.ERROR:
            return Answer(question, trouble=_refused(reply))
        return str(reply.body[0]) if reply.body else ""
    finally:
        bus.disconnect()


def _refused(reply: "Message | None") -> str:
    name = (reply.error_name if reply is not None else "") or "no answer"
    text = str(reply.body[0]) if reply is not None and reply.body else ""
    if name.rpartition(".")[2] in DENIED:
        return f"polkit does not let this user power off ({text or name}); {HOW}"
    if name.endswith((".ServiceUnknown", ".NameHasNoOwner")):
        return "no logind answers on this D-Bus; systemd-logind has to run"
    return f"logind refuses: {text or name}"
