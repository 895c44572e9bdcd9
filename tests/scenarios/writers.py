"""F7: nobody but its owner moves a motor, and no robot runs twice."""

import fcntl
import json
import os
import time
from contextlib import suppress
from pathlib import Path

import serial

from lbr.bus import stamp, wire
from tests.support.bench import Bench
from tests.support.robot import lbr
from tests.support.waiting import HANG_S, STOPS_S

FOREIGN_S = 0.4
ALREADY_RUNNING = 3


def foreign_setpoints(under_test: Bench) -> None:
    """Setpoints from strangers: without a seal, with a forged one, and the owner's own, replayed."""
    robot = under_test.robot
    key = f"{robot.name}/motors/setpoint"
    genuine = _overhear(under_test, key)
    payload = json.dumps({"left": 0.5, "right": -0.5, "lease": "x"}).encode()
    forged = stamp.make("drive", 10**9, payload, b"guessed")
    _nothing_turns(under_test, "without a seal", key, [(payload, b""), (payload, stamp.make("drive", 1, payload))])
    _nothing_turns(under_test, "with a forged seal", key, [(payload, forged)])
    _nothing_turns(under_test, "replayed", key, genuine)


def second_run(under_test: Bench) -> None:
    """A second `lbr run` of the same robot is refused at once."""
    started = time.monotonic()
    second = lbr(under_test.robot.home, "run", "lbr-sim", "--no-console")
    took_ms = (time.monotonic() - started) * 1000
    wrong = [] if second.returncode == ALREADY_RUNNING else [f"a second run ended with {second.returncode}"]
    under_test.results.check("F7", wrong)
    under_test.results.sample("F7 second run", took_ms)


def second_opener(under_test: Bench) -> None:
    """The controller's tty cannot be opened exclusively, nor locked, by anybody else while its driver has it."""
    path = under_test.robot.home / "run" / f"{under_test.robot.name}-devices" / "motor_controller"
    opened: list[str] = []

    def refused() -> bool:
        opened[:] = _opened(path)
        return not opened

    with suppress(AssertionError):  # a busy machine's driver may just open it anew
        under_test.until(refused, STOPS_S, "the driver has it", every_s=0.1)
    under_test.results.check("F7", opened)


def _opened(path: Path) -> list[str]:
    opened = []
    with suppress(serial.SerialException):
        serial.Serial(str(path), exclusive=True).close()
        opened.append("pyserial opened the driver's tty exclusively")
    fd = os.open(path, os.O_RDWR | os.O_NOCTTY)
    try:
        with suppress(BlockingIOError):
            fcntl.flock(fd, fcntl.LOCK_EX | fcntl.LOCK_NB)
            opened.append("the driver's tty is not locked")
    finally:
        os.close(fd)
    return opened


def _overhear(under_test: Bench, key: str) -> list[tuple[bytes, bytes]]:
    """Collect the owner's own setpoints while it drives."""
    heard = wire.Subscription(under_test.robot.bus, key, depth=256)
    mover = under_test.drive()
    under_test.pass_time(0.1)
    mover.cease()
    under_test.robot.ask("drive/stop", {})
    messages = [(raw.payload, raw.attachment) for raw in heard.take()]
    heard.close()
    genuine = [(payload, attachment) for payload, attachment in messages if json.loads(payload)["left"] != 0.0]
    assert genuine, "nothing was overheard"
    return genuine


def _nothing_turns(under_test: Bench, how: str, key: str, messages: list[tuple[bytes, bytes]]) -> None:
    under_test.until(lambda: under_test.trace.now().zero, HANG_S, "rest")
    since_ns = time.monotonic_ns()
    end = time.monotonic() + FOREIGN_S
    while time.monotonic() < end:
        for payload, attachment in messages:
            under_test.robot.bus.put(key, payload, attachment=attachment)
        under_test.pass_time(0.01)
    under_test.trace.read()
    moved = [entry for entry in under_test.trace.outputs(since_ns) if not entry.zero]
    lines = [line for line in under_test.trace.lines(since_ns) if line.moves]
    text = [f"a foreign setpoint {how} turned the motors: {(moved or lines)[0]}"] if moved or lines else []
    under_test.results.check("F7", text)
