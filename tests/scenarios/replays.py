"""F2 and F3: bytes recorded and sent again, and commands whose number or date is not newer than what was there."""

import json
import time
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import cycle, islice
from typing import Any, NamedTuple

import msgspec

from lbr.bus import session, stamp, wire
from lbr.bus.session import Session
from tests.scenarios.clients import plain_client
from tests.support.bench import ANGLES, Bench, bench
from tests.support.figures import Results
from tests.support.mover import POWER

BURST = 40
BETWEEN_S = 0.005
RECORDED_S = 0.3
REST_S = 0.3
HOUR_NS = 3_600_000_000_000
AGES_NS = (0, 1, 1_000_000, 1_000_000_000, HOUR_NS)
"""As far as the machine has run for so long: its clock begins at zero, and what is below is no date."""
NUMBERS = (0, 1, 2**31, 2**32 + 1, 2**63 - 1)
NO_NUMBERS = (-1, 2**63, 10**30, 1.5, None, "7", True)
COMMAND = {"power": POWER, "angle_deg": ANGLES[0]}


class Message(NamedTuple):
    """What was on the bus: key, payload, attachment."""

    key: str
    payload: bytes
    attachment: bytes


def recorded(under_test: Bench, count: int) -> None:
    """F2: what two senders and the drive itself sent, sent again: at once, later, by the same and another connection."""
    robot = under_test.robot
    messages = _record(under_test)
    with session.open_client(robot.endpoints) as another:
        for bus in (robot.bus, another):
            with _nothing_turns(under_test, "F2", "what was recorded"):
                _send_again(under_test, bus, messages, count // 2)
        commands = [message for message in messages if message.key.endswith("command")]
        for message in islice(cycle(commands), count // 10):
            _refused(under_test, "F2", "what was recorded", _query(another, message))
    under_test.results.of("F2").checks += count


def numbered(under_test: Bench) -> None:
    """F3: dated before the stop, twice, overtaken; with numbers small, huge and wrapped, and with what is none."""
    robot, dice = under_test.robot, under_test.dice
    key, payload = f"{robot.name}/drive/command", msgspec.json.encode(COMMAND)
    number = dice.choice(NUMBERS)
    first, second = _stamp(number), b""

    def begun() -> bool:
        nonlocal second
        second = _stamp(dice.choice(NUMBERS))
        return _query(robot.bus, Message(key, payload, second)).get("accepted") is True

    under_test.until(begun, 3.0, "a command accepted", every_s=0.05)
    for what, attachment in (("the same once more", second), ("one that was overtaken", first)):
        _refused(under_test, "F3", what, _query(robot.bus, Message(key, payload, attachment)))
    before_ns = time.monotonic_ns()
    robot.ask("drive/stop", {}, source="numbers")
    under_test.pass_time(REST_S)
    with _nothing_turns(under_test, "F3", "an old command"):
        old = _stamp(dice.choice(NUMBERS), max(0, before_ns - dice.choice(AGES_NS)))
        _refused(under_test, "F3", "one from before the stop", _query(robot.bus, Message(key, payload, old)))
        robot.bus.put(key, payload, attachment=old)
    _query(robot.bus, Message(key, payload, _stamp(dice.choice(NO_NUMBERS))))  # is no stamp: new, and nobody's
    robot.ask("drive/stop", {}, source="numbers")
    under_test.pass_time(REST_S)


def replays(results: Results, n: int) -> None:
    """F2, with `n` messages."""
    with bench(results) as under_test:
        recorded(under_test, n)


def _record(under_test: Bench) -> list[Message]:
    """Listen while a stamped and a plain sender drive; return what moved something, the last of it just stopped."""
    robot = under_test.robot
    heard = [
        wire.Subscription(robot.bus, f"{robot.name}/{key}", depth=256) for key in ("drive/command", "motors/setpoint")
    ]
    mover = under_test.drive()
    under_test.pass_time(RECORDED_S)
    mover.cease()
    robot.ask("drive/stop", {})
    popen = plain_client(under_test)
    under_test.wait_for_motion()
    under_test.pass_time(RECORDED_S)
    popen.kill()
    popen.communicate()
    robot.ask("drive/stop", {})
    messages = [Message(raw.key, raw.payload, raw.attachment) for feed in heard for raw in feed.take()]
    for feed in heard:
        feed.close()
    under_test.until(lambda: under_test.trace.now().zero, 1.0, "rest")
    moving = [message for message in messages if _moves(json.loads(message.payload))]
    assert {message.key for message in moving} == {f"{robot.name}/drive/command", f"{robot.name}/motors/setpoint"}
    return moving


def _moves(message: dict[str, Any]) -> bool:
    return bool(message.get("power") or message.get("left") or message.get("right"))


def _send_again(under_test: Bench, bus: Session, messages: list[Message], count: int) -> None:
    for n, message in enumerate(islice(cycle(messages), count)):
        bus.put(message.key, message.payload, attachment=message.attachment or None)
        if n % BURST == BURST - 1:
            under_test.pass_time(BETWEEN_S)


def _query(bus: Session, message: Message) -> Any:
    replies = bus.get(message.key, payload=message.payload, attachment=message.attachment or None, timeout=1.0)
    answers = [json.loads(reply.ok.payload.to_bytes()) for reply in replies if reply.ok is not None]
    return answers[0] if answers else {"answer": None}


def _refused(under_test: Bench, figure: str, what: str, reply: Any) -> None:
    wrong = [f"{what} was answered {reply}"] if reply.get("accepted") else []
    under_test.results.check(figure, wrong)


def _stamp(number: object, mono_ns: int | None = None) -> bytes:
    """Return a stamp of a sender on this machine, with any number."""
    now_ns = time.monotonic_ns() if mono_ns is None else mono_ns
    fields = {"source": "numbers", "seq": number, "mono_ns": now_ns, "wall_ns": time.time_ns(), "boot": stamp.boot_id()}
    return json.dumps(fields).encode()


@contextmanager
def _nothing_turns(under_test: Bench, figure: str, what: str) -> Iterator[None]:
    since_ns = time.monotonic_ns()
    yield
    under_test.pass_time(REST_S)
    under_test.trace.read()
    moved = [entry for entry in under_test.trace.outputs(since_ns) if not entry.zero]
    under_test.results.check(figure, [f"{what} turned the motors: {moved[0]}"] if moved else [])
