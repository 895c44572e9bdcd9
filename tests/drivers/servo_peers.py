"""A chain of AX-12A servos at the other end of a line, in memory or a pty: as little of them as the driver's tests need, and
their faults."""

import os
import select
import threading
import time
from collections.abc import Callable
from pathlib import Path

from lbr.drivers.servos.line import ServoLine
from lbr.testing import FakeContext
from tests.drivers.peers import Pty

ANSWER_S = 0.0005


def chk(body: bytes) -> bytes:
    return b"\xff\xff" + body + bytes(((~sum(body)) & 0xFF,))


def status(servo: int, data: bytes = b"", error: int = 0) -> bytes:
    return chk(bytes((servo, len(data) + 2, error)) + data)


class Servo:
    """A control table, and a motor that reaches every goal at once while it has torque."""

    def __init__(self, number: int) -> None:
        self.table = bytearray(50)
        self.error = 0
        self.stuck: int | None = None
        for address, value in {
            0: 12,
            2: 24,
            3: number,
            4: 1,
            5: 250,
            11: 70,
            12: 60,
            13: 140,
            16: 2,
            17: 36,
            18: 36,
        }.items():
            self.table[address] = value
        self.put(8, 1023)
        self.put(14, 1023)
        self.boot()

    def boot(self) -> None:
        """Come up again: RAM is forgotten."""
        self.table[24:48] = bytes(24)
        self.put(34, self.word(14))
        self.put(30, 512 + self.table[3])
        self.put(36, 512 + self.table[3])
        self.table[42], self.table[43] = 111, 35

    def word(self, address: int) -> int:
        return int.from_bytes(self.table[address : address + 2], "little")

    def put(self, address: int, value: int) -> None:
        self.table[address : address + 2] = value.to_bytes(2, "little")

    def write(self, address: int, data: bytes) -> None:
        if address < 24 and self.table[24]:
            return
        self.table[address : address + len(data)] = data
        self.settle()

    def settle(self) -> None:
        if self.table[24] and self.word(34):
            self.put(36, self.word(30) if self.stuck is None else self.stuck)

    @property
    def torque(self) -> int:
        return self.word(34) if self.table[24] else 0

    @property
    def goal(self) -> int:
        return self.word(30)

    @property
    def position(self) -> int:
        return self.word(36)

    def trip(self, error: int) -> None:
        """Protect itself: report the error, and have no torque until a torque limit is written."""
        self.error = error
        self.put(34, 0)


class ServoChain:
    """Servos that answer requests. `answer` may replace what one request is answered with; None: as usual."""

    def __init__(self, servos: int = 3, *, adapter: bool = False) -> None:
        self.servos = {number: Servo(number) for number in range(1, servos + 1)}
        self.dead: set[int] = set()
        self.adapter = adapter
        self.echo = False
        self.log: list[bytes] = []
        self.answer: Callable[[bytes, bytes], bytes | None] = lambda _request, _usual: None
        self._held = b""

    def writes(self, address: int) -> list[bytes]:
        """Return the requests that write at this address, to one or to all."""
        return [packet for packet in self.log if packet[4] in (0x03, 0x83) and packet[5] == address]

    def hear(self, data: bytes) -> bytes:
        """Take bytes; return what is answered."""
        self._held += data
        answers = b""
        while len(self._held) >= 4:
            if self._held[:2] != b"\xff\xff" or self._held[2] == 0xFF:
                self._held = self._held[1:]
                continue
            end = self._held[3] + 4
            if len(self._held) < end:
                break
            request, self._held = self._held[:end], self._held[end:]
            self.log.append(request)
            usual = (request if self.echo else b"") + self._usual(request)
            other = self.answer(request, usual)
            answers += usual if other is None else other
        return answers

    def _usual(self, request: bytes) -> bytes:
        servo, code, params = request[2], request[4], request[5:-1]
        if servo == 0xFE:
            self._sync_write(params)
            return b""
        if servo == 0xFD:
            return self._adapter(code, params) if self.adapter else b""
        return self._one(servo, code, params)

    def _one(self, servo: int, code: int, params: bytes) -> bytes:
        one = self.servos.get(servo)
        if one is None or servo in self.dead:
            return b""
        if code == 0x01:
            return status(servo, error=one.error)
        if code == 0x02:
            return (
                status(servo, bytes(one.table[params[0] : params[0] + params[1]]), one.error) if one.table[16] else b""
            )
        one.write(params[0], params[1:])
        return status(servo, error=one.error) if one.table[16] == 2 else b""

    def _sync_write(self, params: bytes) -> None:
        address, size = params[:2]
        for at in range(2, len(params), size + 1):
            one = self.servos.get(params[at])
            if one is not None and params[at] not in self.dead:
                one.write(address, params[at + 1 : at + 1 + size])

    def _adapter(self, code: int, params: bytes) -> bytes:
        if code == 0x02:
            return status(0xFD, bytes((0x01, 0x42, 5, 0xFD)[params[0] : params[0] + params[1]]))
        address, size, *ids = params
        blocks = [
            bytes(size * (0xFF,)) if servo in self.dead else bytes(self.servos[servo].table[address : address + size])
            for servo in ids
        ]
        return status(0xFD, b"".join(blocks))


class Chain(ServoChain, Pty):
    """Servos on a pty."""

    def __init__(self, path: Path, servos: int = 3, *, adapter: bool = False) -> None:
        ServoChain.__init__(self, servos, adapter=adapter)
        Pty.__init__(self, path)
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()

    def finish(self) -> None:
        self._stop.set()
        self._thread.join()
        super().finish()

    def _serve(self) -> None:
        while not self._stop.is_set():
            if self.master < 0:
                time.sleep(0.001)
                continue
            try:
                if select.select([self.master], [], [], 0.005)[0]:
                    os.write(self.master, self.hear(os.read(self.master, 4096)))
            except (OSError, ValueError):
                continue


class MemoryLine(ServoLine):
    """A line to servos in memory; who waits for an answer has the test's time go on."""

    def __init__(self, chain: ServoChain, ctx: FakeContext, baud: int, margin_s: float) -> None:
        self.name, self.baud, self.margin_s = "of the test", baud, margin_s
        self._chain, self._ctx, self._came = chain, ctx, b""

    def fileno(self) -> int:
        return -1

    def send(self, data: bytes) -> bool:
        self._came += self._chain.hear(data)
        return True

    def read(self, wait_s: float = 0.0) -> bytes:
        self._ctx.now += ANSWER_S if self._came else wait_s
        data, self._came = self._came, b""
        return data

    def close(self) -> None:
        pass
