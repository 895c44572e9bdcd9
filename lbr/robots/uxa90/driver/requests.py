"""Questions to the main board and single servos, and writes to their registers: one job of the line's thread each."""

from collections.abc import Callable, Collection

from lbr.robots.uxa90.driver import frames, packets
from lbr.robots.uxa90.driver.bus import Bus
from lbr.robots.uxa90.driver.messages import ConfigureCommand, InquireCommand, InquireReply
from lbr.robots.uxa90.driver.packets import ANSWER_BYTES, REGISTERS, Register
from lbr.robots.uxa90.driver.session import words

ASKED_S, WRITTEN_S = 0.1, 0.25
"""The waits for a register's answer; storing a value without power takes the servo longer."""
TRIES = 3
SETTLE_S = 0.5
NOT_TOLD = "did not get it: a stop or a move needed the line, or it is not quiet; try again"
Job = Callable[[Bus], InquireReply]


def inquiry(message: InquireCommand, servos: Collection[int]) -> Job:
    """Return the job that asks; raise ValueError for a wrong question."""
    if message.what in frames.QUESTIONS:
        return _about_board(message.what)
    register = REGISTERS[message.what]
    servo = _known(message.id, servos, message.what)
    packets.ask(register, servo)

    def job(bus: Bus) -> InquireReply:
        values = _asked(bus, register, servo)
        if values is None:
            return InquireReply(
                accepted=False, code="timeout", reason=f"servo {servo} does not report its {register.name}"
            )
        return InquireReply(accepted=True, values=values, text=f"servo {servo}: {_text(register, values)}")

    return job


def configuration(message: ConfigureCommand, servos: Collection[int]) -> Job:
    """Return the job that writes a register and reads it back; raise ValueError for a value that is not allowed."""
    if message.what not in REGISTERS:
        raise ValueError(f"{message.what} can only be read")
    register = REGISTERS[message.what]
    servo = _known(message.id, servos, message.what)
    data = packets.configure(register, servo, message.values)
    if register.name == "id" and message.values[0] in servos:
        raise ValueError(f"there is a servo {message.values[0]} already; two with one id cannot be distinguished")
    expected = message.values * 2 if register.twice else message.values

    def job(bus: Bus) -> InquireReply:
        return _written(bus, register, servo, data, expected)

    return job


def _written(bus: Bus, register: Register, servo: int, data: bytes, expected: tuple[int, ...]) -> InquireReply:
    if not bus.settle(SETTLE_S):
        return InquireReply(accepted=False, code="timeout", reason=f"servo {servo} {NOT_TOLD}")
    if not register.answers:
        bus.say(data)
        return InquireReply(accepted=True, values=expected, text=f"sent to servo {servo}, which does not answer that")
    came = bus.ask(data, register.answers, WRITTEN_S)
    values = tuple(came) if came is not None else None
    if register.read is not None:
        values = _asked(bus, register, servo)
    if values is None:
        return InquireReply(
            accepted=False, code="timeout", reason=f"servo {servo} does not confirm its {register.name}"
        )
    if values[: len(expected)] != expected:
        return InquireReply(
            accepted=False,
            code="not_followed",
            values=values,
            reason=f"servo {servo} keeps its {register.name}: {_text(register, values)}",
        )
    return InquireReply(accepted=True, values=values, text=f"servo {servo} now: {_text(register, values)}")


def _about_board(question: str) -> Job:
    def job(bus: Bus) -> InquireReply:
        for _ in range(TRIES):
            answer = bus.inquire(frames.ask(question), *frames.QUESTIONS[question])
            if answer is not None:
                return InquireReply(accepted=True, values=tuple(answer.contents), text=words(question, answer.contents))
        return InquireReply(
            accepted=False, code="timeout", reason=f"the main board does not say its {question.replace('_', ' ')}"
        )

    return job


def _asked(bus: Bus, register: Register, servo: int) -> tuple[int, ...] | None:
    """Ask until two answers agree: nothing else proves that they are the servo's own."""
    before: tuple[int, ...] | None = None
    for _ in range(TRIES):
        came = bus.ask(packets.ask(register, servo), ANSWER_BYTES, ASKED_S)
        values = tuple(came) if came is not None else None
        if values is not None and (values == before or register.name == "position14"):
            return (values[0] << 7 | values[1] & 0x7F,) if register.name == "position14" else values
        before = values
    return None


def _text(register: Register, values: tuple[int, ...]) -> str:
    shown = values[:1] if register.twice else values
    return f"{register.name.replace('_', ' ')} {', '.join(map(str, shown))}"


def _known(servo: int | None, servos: Collection[int], what: str) -> int:
    if servo is None:
        raise ValueError(f"{what} is a servo's: say which (id)")
    if servo not in servos:
        raise ValueError(f"no joint has servo {servo}; there are {', '.join(map(str, sorted(servos)))}")
    return servo
