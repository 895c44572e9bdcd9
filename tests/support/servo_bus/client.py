"""Clients of a servo bus, each in a process of its own: how many states they read, at what cost, and whether all are true.

`python -m tests.support.servo_bus.client KIND PATH SERVOS` reads from the bus of `tests.support.servo_bus.twin` for as many
seconds as each line on standard input says, and answers with a line of JSON. Lost: no state, within the client's patience.
"""

import json
import sys
import termios
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from itertools import count
from typing import Any

from tests.support.servo_bus.twin import BITS, counter_of

JUMP = 200
"""A counter may be ahead of the last one by that: answers get lost."""

Words = tuple[int, ...]
Read = Callable[[int], Iterator[tuple[int, Words | None, int]]]
"""Ask the servos in turn; yields each, the words that came, None if they did not, and which word is the first."""


class Tally:
    """Counts what came, and judges it by the counters within; `gone` counts how often the line was."""

    def __init__(self) -> None:
        self.states = self.lost = self.wrong = self.stale = self.gone = 0
        self.longest_s = 0.0
        self._last: dict[int, int] = {}

    def take(self, servo: int, words: Words | None, first: int, *, whole: bool) -> None:
        """Judge one answer; one that does not make a `whole` state only counts if it is bad."""
        if words is None:
            self.lost += 1
            return
        self.states += whole
        counter = counter_of(servo, words, first)
        if counter is None:
            self.wrong += 1
            return
        last = self._last.get(servo)
        if last is not None and not 0 < (counter - last) & BITS <= JUMP:
            self.stale += 1
        self._last[servo] = counter


@contextmanager
def block(path: str, servos: int) -> Iterator[Read]:
    """Read six bytes from each with lbr's own bus."""
    from lbr.drivers.dynamixel.bus import open_bus

    with open_bus(path) as bus:

        def read(turn: int) -> Iterator[tuple[int, Words | None, int]]:
            servo = 1 + turn % servos
            motion = bus.read_motion(servo)
            yield servo, None if motion is None else (motion.position, motion.speed, motion.load), 0

        yield read


@contextmanager
def together(path: str, servos: int) -> Iterator[Read]:
    """Have the USB2AX read all of them, with lbr's own bus."""
    from lbr.drivers.dynamixel.bus import open_bus
    from lbr.errors import DeviceError

    with open_bus(path) as bus:
        numbers = list(range(1, servos + 1))
        if not any(bus.find_adapter() for _ in range(10)):
            raise DeviceError("no USB2AX found")

        def read(_turn: int) -> Iterator[tuple[int, Words | None, int]]:
            for servo, motion in zip(numbers, bus.read_motions(numbers), strict=True):
                yield servo, None if motion is None else (motion.position, motion.speed, motion.load), 0

        yield read


@contextmanager
def vendor(path: str) -> Iterator[tuple[Any, Any]]:
    """Return the port and the packet handler of the vendor's kit."""
    from dynamixel_sdk import PacketHandler, PortHandler

    port = PortHandler(path)
    port.setBaudRate(1_000_000)
    try:
        yield port, PacketHandler(1.0)
    finally:
        port.closePort()


@contextmanager
def vendor_block(path: str, servos: int) -> Iterator[Read]:
    """Read six bytes from each with the vendor's kit."""
    with vendor(path) as (port, handler):

        def read(turn: int) -> Iterator[tuple[int, Words | None, int]]:
            servo = 1 + turn % servos
            data, result, _ = handler.readTxRx(port, servo, 36, 6)
            words = tuple(data[at] | data[at + 1] << 8 for at in (0, 2, 4)) if result == 0 else None
            yield servo, words, 0

        yield read


@contextmanager
def vendor_three(path: str, servos: int) -> Iterator[Read]:
    """Read two bytes from each, three times, with the vendor's kit."""
    with vendor(path) as (port, handler):

        def read(turn: int) -> Iterator[tuple[int, Words | None, int]]:
            servo = 1 + turn % servos
            for word in range(3):
                value, result, _ = handler.read2ByteTxRx(port, servo, 36 + 2 * word)
                yield servo, (value,) if result == 0 else None, word

        yield read


KINDS = {"block": block, "together": together, "vendor_block": vendor_block, "vendor_three": vendor_three}


def main() -> None:
    """Serve until standard input ends."""
    kind, path, servos = sys.argv[1], sys.argv[2], int(sys.argv[3])
    print(json.dumps({"ready": True}), flush=True)
    for line in sys.stdin:
        print(json.dumps(run(kind, path, servos, float(line))), flush=True)


def run(kind: str, path: str, servos: int, seconds: float) -> dict[str, float]:
    """Read for a while; open the line again when it went away."""
    tally, turns = Tally(), count()
    cpu_s = begun = until = None
    while until is None or time.monotonic() < until:
        with suppress(OSError, termios.error), KINDS[kind](path, servos) as read:
            if until is None:  # opening the line is not what is measured
                cpu_s, begun = time.process_time(), time.monotonic()
                until = begun + seconds
            _read(read, tally, until, turns, last=2 if kind == "vendor_three" else 0)
        if until is None or time.monotonic() < until:
            tally.gone += 1
            time.sleep(0.01)
    assert begun is not None
    assert cpu_s is not None
    return {
        "states": tally.states,
        "lost": tally.lost,
        "wrong": tally.wrong,
        "stale": tally.stale,
        "gone": tally.gone,
        "longest_s": tally.longest_s,
        "cpu_s": time.process_time() - cpu_s,
        "wall_s": time.monotonic() - begun,
    }


def _read(read: Read, tally: Tally, until: float, turns: Iterator[int], last: int) -> None:
    now = time.monotonic()
    while now < until:
        for servo, words, first in read(next(turns)):
            tally.take(servo, words, first, whole=first == last)
        before, now = now, time.monotonic()
        tally.longest_s = max(tally.longest_s, now - before)


if __name__ == "__main__":
    main()
