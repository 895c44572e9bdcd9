"""What the line of the servo bus allows, by the timing model of its twin."""

from tests.support.servo_bus.line import SERVOS
from tests.support.servo_bus.twin import bus as servo_bus


def wire_hz(kind: str, delay: int) -> float:
    """Return how many states a second the line allows to a client that takes no time at all, by the timing model."""
    bus, now, states = servo_bus(delay=delay, usb2ax=5 if kind == "together" else None), 100.0, 0
    if kind == "together":
        requests = [_packet(0xFD, 0x84, 36, 6, *range(1, SERVOS + 1))]
    elif kind == "vendor_three":
        requests = [_packet(1 + turn % SERVOS, 2, 36 + 2 * word, 2) for turn in range(SERVOS) for word in range(3)]
    else:
        requests = [_packet(1 + turn, 2, 36, 6) for turn in range(SERVOS)]
    while now < 100.5:
        for request in requests:
            bus.feed(request, now)
            while (due := bus.next_due()) is not None:
                now = due
                bus.poll(now)
        states += SERVOS
    return states / (now - 100.0)


def _packet(number: int, code: int, *parameters: int) -> bytes:
    body = bytes((number, len(parameters) + 2, code, *parameters))
    return b"\xff\xff" + body + bytes((~sum(body) & 0xFF,))
