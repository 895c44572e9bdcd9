"""Identifies devices on a line, on a bus or by a kernel's name, with the handshakes that drivers declare.

Only their questions are written. Each device has a time limit: one that floods, is silent, sends rubbish or goes away
yields a sentence.
"""

import threading
import time
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress

from lbr.capability.context import Device
from lbr.capability.recognition import Handshake, I2cHandshake, NameHandshake, Read, Seen, SerialHandshake
from lbr.drivers import i2c
from lbr.drivers.i2c_bus import Bus
from lbr.drivers.serial_line import SerialLine, open_line
from lbr.errors import DeviceError

Known = Mapping[str, tuple[Handshake, ...]]
"""Handshakes by device type."""
Found = tuple[str, Seen]
"""A device type, and what was recognised of it."""
NAME = "what is there"
MOST_HEARD = 16_384
"""The most bytes that one handshake reads from a device that floods."""
SHOWN_BYTES = 24
FIRST_BAUD = 115_200
LEAVE_S = 0.005
"""The time for the last bytes to leave: closing a line discards the rest."""
JUDGED_S = 1.0
"""The time that a package's driver may take to judge an answer; the others take microseconds."""
_HUNG: set[Callable[..., Seen | None]] = set()


def serial(path: str, known: Known, *, wait_s: float, ask: bool = True) -> tuple[Found | None, str]:
    """Return the device on a serial line, or None and the reason; raise DeviceError if the line cannot be opened.

    Without `ask` only devices that talk by themselves are recognised, and nothing is written.
    """
    wanted = _in_order(
        (type_, one)
        for type_, ones in known.items()
        for one in ones
        if isinstance(one, SerialHandshake) and (ask or not one.questions)
    )
    if not wanted:
        return None, "no driver here knows a device that talks by itself"
    line = open_line(Device(NAME, "", path, {}), wanted[0][1].baud)
    try:
        line.low_latency()
        return _go_through(line, wanted, time.monotonic() + wait_s, ask=ask)
    except DeviceError as err:
        return None, str(err).replace(f"device '{NAME}' at ", "")
    finally:
        with suppress(DeviceError):
            line.drop_output()
        line.close()


def _go_through(
    line: SerialLine, wanted: list[tuple[str, SerialHandshake]], until: float, *, ask: bool
) -> tuple[Found | None, str]:
    count, begin = 0, b""
    for type_, handshake in wanted:
        if time.monotonic() >= until:
            break
        line.set_baud(handshake.baud)
        line.drop_input()
        seen, heard = _ask(line, handshake, until)
        count += len(heard)
        begin = begin or heard[:SHOWN_BYTES]
        if seen is not None:
            if handshake.leave:
                line.write(handshake.leave)
                time.sleep(LEAVE_S)
            return (type_, seen), ""
    if not count:
        return None, "it answers no question of the drivers here" if ask else "it sends nothing by itself"
    return None, f"it says {count} bytes that no driver here knows, which begin with {begin.hex(' ')}"


def at_i2c(bus_address: str, known: Known, skip: Iterable[int] = ()) -> list[tuple[int, Found]]:
    """Return the devices on a bus, `i2c:N` or `unix:PATH`, at the addresses that drivers declare, except `skip`.

    Raises DeviceError if the bus cannot be opened.
    """
    wanted = [
        (type_, handshake) for type_, ones in known.items() for handshake in ones if isinstance(handshake, I2cHandshake)
    ]
    places = sorted({address for _, handshake in wanted for address in handshake.addresses} - set(skip))
    if not places:
        return []
    bus, _ = i2c.open_bus(Device(NAME, "", f"{bus_address}:{places[0]:#04x}", {}), places[0])
    recognised = []
    try:
        for address in places:
            for type_, handshake in wanted:
                if address in handshake.addresses and (seen := _read(bus, address, handshake)) is not None:
                    recognised.append((address, (type_, seen)))
                    break
    finally:
        bus.close()
    return recognised


def by_name(place: str, name: str, known: Known) -> Found | None:
    """Return the device that the kernel's name of a node identifies."""
    for type_, ones in known.items():
        for one in ones:
            if isinstance(one, NameHandshake) and one.place == place and (seen := _judged(one.seen, name)) is not None:
                return type_, seen
    return None


def _in_order(wanted: Iterable[tuple[str, SerialHandshake]]) -> list[tuple[str, SerialHandshake]]:
    """Put the handshakes that only listen first; then sort by speed, the most common first, as it changes seldom so."""
    return sorted(wanted, key=lambda one: (bool(one[1].questions), one[1].baud != FIRST_BAUD, one[1].baud, one[0]))


def _ask(line: SerialLine, handshake: SerialHandshake, until: float) -> tuple[Seen | None, bytes]:
    answer = bytearray()
    for number, question in enumerate(handshake.questions):
        line.write(question)
        last = number == len(handshake.questions) - 1
        _hear(line, answer, 0.0 if last else handshake.gap_s, until, lambda: False)
        if not (handshake.whole or last) and (seen := _judged(handshake.seen, bytes(answer))) is not None:
            return seen, bytes(answer)

    def known() -> bool:
        return not handshake.whole and _judged(handshake.seen, bytes(answer)) is not None

    _hear(line, answer, handshake.listen_s, until, known)
    return _judged(handshake.seen, bytes(answer)), bytes(answer)


def _hear(line: SerialLine, answer: bytearray, wait_s: float, until: float, enough: Callable[[], bool]) -> None:
    end = min(time.monotonic() + wait_s, until)
    while (left := end - time.monotonic()) > 0.0 and len(answer) < MOST_HEARD:
        data = line.read(left)
        if data:
            answer += data
            if enough():
                return


def _read(bus: Bus, address: int, handshake: I2cHandshake) -> Seen | None:
    def read(register: int, count: int) -> bytes:
        return bytes(bus.read_i2c_block_data(address, register, count))

    return _judged(handshake.seen, read)


def hung() -> list[str]:
    """Return a sentence for each hung handshake of a package; it judges no more devices."""
    return sorted(
        f"{_name(judge)} has not returned within {JUDGED_S:g} s, and recognises nothing here" for judge in _HUNG
    )


def _judged(judge: Callable[..., Seen | None], answer: bytes | str | Read) -> Seen | None:
    """Return a driver's verdict on an answer; None if its code fails on it."""
    if judge in _HUNG:
        return None
    verdicts: list[object] = []

    def run() -> None:
        with suppress(Exception, SystemExit):  # a package's code, and any answer
            verdicts.append(judge(answer))

    if _name(judge).startswith("lbr."):
        run()
    else:
        thread = threading.Thread(target=run, daemon=True)
        thread.start()
        thread.join(JUDGED_S)
        if thread.is_alive():
            _HUNG.add(judge)
    return verdicts[0] if verdicts and isinstance(verdicts[0], Seen) else None


def _name(judge: Callable[..., object]) -> str:
    return f"{getattr(judge, '__module__', '')}.{getattr(judge, '__qualname__', type(judge).__name__)}"
