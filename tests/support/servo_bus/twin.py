"""A servo bus on a pty in a process of its own, with answers to the microsecond, whose every state can be checked.

`python -m tests.support.servo_bus.twin PATH` takes one JSON object a line on standard input and answers `{"ready": true}`:
`delay` (the return delay register), `usb2ax` (4, 5 or null), `usb_us`, `faults` as in a device row, `servos`, how many
there are. Each servo counts how often it was read, and says the count in its position, speed and load: see `counter_of`.
With `positions_rad` they are servos that turn as they are told, and begin there; `log` names a file that gets each packet
for all of them, as a line of when it was over and its bytes.
"""

import ctypes
import json
import os
import select
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from random import Random
from typing import Any

import msgspec

from lbr.simulation.bus_timing import BusTiming, rhythm
from lbr.simulation.devices.dynamixel import DynamixelFaults
from lbr.simulation.devices.dynamixel import registers as reg
from lbr.simulation.devices.dynamixel.bus import DynamixelBus
from lbr.simulation.devices.dynamixel.dongle import Usb2Ax
from lbr.simulation.devices.dynamixel.packets import BROADCAST, Instruction
from lbr.simulation.devices.dynamixel.servo import AxServo
from lbr.simulation.port import PtyPort

BITS = 0x3FF
SPREAD, STEP = 57, 300
"""What tells servos apart, and the registers of one."""

SPIN_S = 60e-6
"""How long before something is due it no longer sleeps."""

_PR_SET_TIMERSLACK = 29


class CountingServo(AxServo):
    """Measures nothing but how often it was asked."""

    counter = 0

    def measure(self) -> None:
        super().measure()
        self.counter += 1
        for word in range(3):
            value = (self.counter + SPREAD * self.id + STEP * word) & BITS
            reg.put_word(self._table, reg.PRESENT + 2 * word, value)


def counter_of(servo: int, values: Sequence[int], first: int = 0) -> int | None:
    """Return the counter that the words from the `first` on carry; None if they do not belong together."""
    found = {(value - SPREAD * servo - STEP * word) & BITS for word, value in enumerate(values, first)}
    return found.pop() if len(found) == 1 else None


def bus(
    *,
    delay: int = 0,
    usb2ax: int | None = None,
    usb_us: float = 0.0,
    servos: int = 18,
    faults: dict[str, Any] | None = None,
    positions_rad: Sequence[float] = (),
    log: str = "",
) -> DynamixelBus:
    """Return a bus whose only delays are the line's, the servos' own, and `usb_us`."""
    random = Random(1)
    places = positions_rad or (0.0,) * servos
    return DynamixelBus(
        [
            (AxServo if positions_rad else CountingServo)(
                number, return_delay=delay, position_rad=at_rad, rhythm=rhythm(random)
            )
            for number, at_rad in enumerate(places, 1)
        ],
        dongle=Usb2Ax(5 if usb2ax == 5 else 4) if usb2ax else None,
        timing=BusTiming(usb_us=usb_us),
        faults=msgspec.convert(faults or {}, DynamixelFaults),
        seed=1,
        on_instruction=_logger(Path(log)) if log else None,
    )


def _logger(path: Path) -> Callable[[Instruction, float], None]:
    log = path.open("a", buffering=1)

    def heard(instruction: Instruction, end: float) -> None:
        if instruction.id == BROADCAST:
            log.write(f"{end:.6f} {instruction.code:02x} {instruction.parameters.hex()}\n")

    return heard


def main() -> None:
    """Serve until standard input ends."""
    _be_on_time()
    emulated = bus()
    with PtyPort(sys.argv[1]) as port:
        print(json.dumps({"ready": True}), flush=True)
        while True:
            ready = _wait(port, emulated.next_due())
            if 0 in ready:
                order = sys.stdin.buffer.readline()
                if not order:
                    return
                emulated = _obey(json.loads(order), emulated, port)
                print(json.dumps({"ready": True}), flush=True)
            else:
                _serve(port, emulated)


def _be_on_time() -> None:
    """Servos do not wait for their turn on the computer that reads them; without the right to that, these do."""
    ctypes.CDLL(None).prctl(_PR_SET_TIMERSLACK, 1, 0, 0, 0)
    with suppress(OSError):
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(1))


def _obey(order: dict[str, Any], emulated: DynamixelBus, port: PtyPort) -> DynamixelBus:
    if set(order) == {"faults"}:
        emulated.faults = msgspec.convert(order["faults"], DynamixelFaults)
    else:
        emulated = bus(**order)
    if emulated.faults.unplug:
        port.unplug()
    else:
        port.plug()
    return emulated


def _wait(port: PtyPort, due: float | None) -> list[int]:
    """Wait until something is due, or somebody wants something; return who."""
    watched = [0, port.fileno()] if port.plugged else [0]
    if due is None:
        return select.select(watched, [], [])[0]
    left_s = due - time.monotonic()
    if left_s > SPIN_S and (ready := select.select(watched, [], [], left_s - SPIN_S)[0]):
        return ready
    while time.monotonic() < due:
        pass
    return []


def _serve(port: PtyPort, emulated: DynamixelBus) -> None:
    heard = port.read()
    now = time.monotonic()
    said = emulated.feed(heard, now, port.baud()) if heard else emulated.poll(now)
    if said:
        port.write(said)


if __name__ == "__main__":
    main()
