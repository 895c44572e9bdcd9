"""All that comes to an emulated device, kept as it came; and what of it is an instruction to servos."""

import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from lbr.drivers.servos.protocol1 import packet
from lbr.robots.uxa90.driver import frames
from lbr.simulation.i2c import RequestReader
from lbr.testing.device import Plugged, plugged

PLUGGED_S = 30.0


@contextmanager
def tapped(type_: str, folder: Path, **options: Any) -> Iterator[tuple[Plugged, list[bytes]]]:
    """Plug in a twin, and keep all that comes to it: bytes of a line, or transactions of a bus."""
    with plugged(type_, folder, name=type_, **options) as found:
        heard = of(found)
        end = time.monotonic() + PLUGGED_S
        while not found.twin.port.plugged:  # type: ignore[attr-defined]
            assert time.monotonic() < end, f"the emulated {type_} has no port"
            time.sleep(0.01)
        yield found, heard


def of(found: Plugged, heard: list[bytes] | None = None) -> list[bytes]:
    """Return what comes to a twin from now on, as it grows: in a list of the caller's, if there is one."""
    heard = [] if heard is None else heard
    port: Any = found.twin.port  # type: ignore[attr-defined]
    if hasattr(port, "receive"):
        receive = port.receive

        def received() -> Iterator[tuple[int, bytes]]:
            for client, data in receive():
                heard.append(data)
                yield client, data

        port.receive = received
    else:
        read = port.read

        def was_read() -> bytes:
            data: bytes = read()
            heard.append(data)
            return data

        port.read = was_read
    return heard


def instructions(heard: bytes) -> list[int]:
    """Return the instructions of protocol 1.0 that are somewhere in what came."""
    found = []
    for at in range(len(heard) - 5):
        if heard[at : at + 2] == b"\xff\xff" and 2 <= heard[at + 3] <= 8:
            whole = heard[at + 2 : at + 4 + heard[at + 3]]
            if len(whole) == heard[at + 3] + 2 and sum(whole) & 0xFF == 0xFF:
                found.append(whole[2])
    return found


def assert_asked_only(type_: str, heard: list[bytes]) -> None:
    """Fail if anything but a question came to a device."""
    came = b"".join(heard)
    assert set(instructions(came)) <= {packet.READ, packet.PING}, type_
    assert b"!" not in came, f"{type_} was told something, not asked"
    assert b"^" not in came, f"{type_} was told something, not asked"
    assert frames.TAKE_CONTROL[:9] not in came, f"{type_}: control of a UXA-90 was taken"


def assert_read_only(type_: str, heard: list[bytes]) -> None:
    """Fail if anything but the numbers of registers to read came to a device on an i2c bus."""
    asked = [message for messages in RequestReader().feed(b"".join(heard)) for message in messages]
    assert any(message.read for message in asked), f"{type_} was asked nothing"
    assert all(message.read or len(message.write) == 1 for message in asked), f"{type_}: a register was written"
