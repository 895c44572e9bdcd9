"""Asks what is at the end of a line, on a bus or behind a kernel's name, by the handshakes that drivers declare.

Nothing is written but their questions. Every end is asked within a time, whatever is there: one that floods, is silent,
speaks rubbish or goes away ends in words.
"""

import threading
import time
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from typing import Any

from lbr.capability.context import Device
from lbr.capability.recognition import Handshake, I2cHandshake, NameHandshake, Read, Seen, SerialHandshake
from lbr.drivers import i2c
from lbr.drivers.i2c_bus import Bus
from lbr.drivers.serial_line import SerialLine, open_line
from lbr.errors import DeviceError

Known = Mapping[str, tuple[Handshake, ...]]
"""Handshakes by the type of device that they are of."""
Found = tuple[str, Seen]
"""A type of device, and what was seen of it."""
NAME = "what is there"
MOST_HEARD = 16_384
"""Of a device that floods, no more is looked at in one handshake."""
SHOWN_BYTES = 24
FIRST_BAUD = 115_200
LEAVE_S = 0.005
"""Until the last bytes have left: what has not when a line is closed is thrown away."""
JUDGED_S = 1.0
"""A package's driver has so long to say what some bytes are, which takes others microseconds."""
_HUNG: set[Callable[..., Seen | None]] = set()


def serial(path: str, known: Known, *, wait_s: float, ask: bool = True) -> tuple[Found | None, str]:
    """Return what is on a serial line, or None and what can be said instead. DeviceError says why it cannot be opened.

    `ask` false: only what talks by itself is recognised, and no byte is written.
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
        return None, "it says nothing to what the drivers here ask" if ask else "it says nothing by itself"
    return None, f"it says {count} bytes that no driver here knows, which begin with {begin.hex(' ')}"


def at_i2c(bus_address: str, known: Known, skip: Iterable[int] = ()) -> list[tuple[int, Found]]:
    """Return what answers on a bus, `i2c:N` or `unix:PATH`, at the addresses that drivers know; `skip` are left alone.

    DeviceError says why the bus cannot be opened.
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
    """Return what the kernel's name of a node says it is."""
    for type_, ones in known.items():
        for one in ones:
            if isinstance(one, NameHandshake) and one.place == place and (seen := _judged(one.seen, name)) is not None:
                return type_, seen
    return None


def _in_order(wanted: Iterable[tuple[str, SerialHandshake]]) -> list[tuple[str, SerialHandshake]]:
    """Listen first; then ask at the speed that most have, which changes seldom."""
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
    """Return the recognitions of packages that did not return, for people; no end is judged by them any more."""
    return sorted(
        f"{_name(judge)} has not returned within {JUDGED_S:g} s, and recognises nothing here" for judge in _HUNG
    )


def _judged(judge: Callable[..., Seen | None], answer: bytes | str | Read) -> Seen | None:
    """Return what a driver makes of an answer; a judge that breaks at what a strange device says has not recognised
    it."""
    if judge in _HUNG:
        return None
    verdicts: list[object] = []

    def run() -> None:
        with suppress(Exception, SystemExit):  # it may be a package's, and what it is given may be anything
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


def _name(judge: Callable[..., Any]) -> str:
    return f"{getattr(judge, '__module__', '')}.{getattr(judge, '__qualname__', type(judge).__name__)}"
