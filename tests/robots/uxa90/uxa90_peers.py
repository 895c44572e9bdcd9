"""A UXA-90's main board at the other end of a pty: as much of it as the driver's tests need, and its faults."""

import os
import select
import threading
import time
from collections.abc import Callable
from pathlib import Path

from tests.drivers.peers import Pty

PREAMBLE = bytes.fromhex("FFFFAA55AA5537BA")
CONTROL_REPLY = PREAMBLE + bytes.fromhex("100000000001 01 01")
FIRMWARE = PREAMBLE + bytes.fromhex("1201 00000002 C900 C9")
SERIAL = PREAMBLE + bytes.fromhex("0C04 0000000D") + b"6012000010005" + b"\x31"


class Servo:
    """Reaches every goal at once; `level` None: no torque; `stuck`: where it stays."""

    def __init__(self, number: int) -> None:
        self.position = 100 + 4 * number
        self.level: int | None = None
        self.stuck = False
        self.registers: dict[int, tuple[int, int]] = {0x12: (10, 240), 0x0A: (20, 30), 0x16: (5, 5)}


class Board(Pty):
    """`said` are what was read at once, `packets` single ones; `answer` may replace the answer to a packet."""

    def __init__(self, path: Path, count: int = 3) -> None:
        self.servos = {number: Servo(number) for number in range(count)}
        self.mode = "normal"
        self.braked = False
        self.dead: set[int] = set()
        self.said: list[bytes] = []
        self.packets: list[bytes] = []
        self.frames: list[bytes] = []
        self.plays: list[int] = []
        self.silent = False
        self.answer: Callable[[bytes, bytes], bytes] = lambda _packet, usual: usual
        self.load = 7
        self._stop = threading.Event()
        super().__init__(path)
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()

    def moves(self, servo: int | None = None) -> list[tuple[int, int, int]]:
        """Return id, level and position of each move that came."""
        found = [(one[1] & 31, one[1] >> 5, one[2]) for one in list(self.packets) if len(one) == 4 and one[1] >> 5 < 5]
        return [move for move in found if servo in (None, move[0])]

    def heard(self, data: bytes) -> bool:
        """Say whether something came as it is, within what was read at once: that may be more than was written at once."""
        return any(data in one for one in self.said)

    def forget(self) -> None:
        for log in (self.said, self.packets, self.frames, self.plays):
            log.clear()

    def inject(self, data: bytes) -> None:
        os.write(self.master, data)

    def finish(self) -> None:
        self._stop.set()
        self._thread.join()
        super().finish()

    def _serve(self) -> None:
        while not self._stop.is_set():
            master = self.master
            if master < 0:
                time.sleep(0.005)
                continue
            try:
                if not select.select([master], [], [], 0.02)[0]:
                    continue
                data = os.read(master, 4096)
                self.said.append(data)
                back = b"".join(self._heed(one) for one in split(data))
                if back and not self.silent:
                    os.write(master, back)
            except (OSError, ValueError):
                time.sleep(0.005)

    def _heed(self, one: bytes) -> bytes:
        if one.startswith(PREAMBLE):
            self.frames.append(one)
            return self._frame(one)
        self.packets.append(one)
        if self.mode != "pc":
            return b""
        usual = self._packet(one)
        return self.answer(one, usual)

    def _frame(self, one: bytes) -> bytes:
        match one[8]:
            case 0x10:
                self.mode = "pc"
                return self.answer(one, CONTROL_REPLY)
            case 0x14:
                self.mode = "normal"
                self.plays.append(one[14])
                return b""
            case 0x12:
                return self.answer(one, FIRMWARE)
            case 0x0C:
                return self.answer(one, SERIAL)
        return b""

    def _packet(self, one: bytes) -> bytes:
        number, mode = one[1] & 31, one[1] >> 5
        if one == bytes.fromhex("FFDF207F"):
            self.braked = True
            for servo in self.servos.values():
                servo.level = None
            return b""
        if one[1:3] == b"\xe0\xe1":
            self.plays.append(one[4])
            return b""
        servo = self.servos.get(number)
        if servo is None or number in self.dead:
            return b""
        if mode < 5:
            self.braked = False
            servo.level = mode
            servo.position = servo.position if servo.stuck else one[2]
        elif mode == 6:
            servo.level = None
            return bytes((0x10, servo.position))
        elif mode == 7:
            return self._register(servo, one)
        return bytes((self.load, servo.position))

    def _register(self, servo: Servo, one: bytes) -> bytes:
        written = {0x11: 0x12, 0x09: 0x0A, 0x15: 0x16}.get(one[2])
        if written is not None:
            servo.registers[written] = (one[3], one[4])
        return bytes(servo.registers.get(written or one[2], (one[3], one[4])))


def split(data: bytes) -> list[bytes]:
    """Return the packets and frames of a write."""
    found = []
    while data:
        if data.startswith(PREAMBLE):
            size = 15 + int.from_bytes(data[10:14], "big")
        elif data[1] >> 5 == 7:
            size = 7 if data[2] == 0xC8 or data[1:3] == b"\xe0\xad" else 6
        else:
            size = 4
        found.append(data[:size])
        data = data[size:]
    return found
