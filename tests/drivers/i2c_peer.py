"""An i2c bus for tests, behind a unix socket or in memory: registers by address, and whatever can go wrong with them."""

import errno
import os
import socket
import struct
import threading
from collections.abc import Callable
from contextlib import suppress
from io import BytesIO
from pathlib import Path
from typing import Any

import pytest

from lbr.capability.context import Device
from lbr.capability.tap import Tap
from lbr.drivers.i2c_bus import Bus, encode
from lbr.drivers.mpu9150 import KIND, capability, controller
from tests.drivers.peers import DriverContext

MPU, COMPASS = 0x68, 0x0C
Messages = list[tuple[int, bytes | int]]
"""Of one transaction: address, and what is written or how many bytes are read."""


def device(path: Path | str, name: str = "imu") -> Device:
    return Device(name, "mpu9150", f"unix:{path}", {})


class Server:
    """Serves transactions to one client after the other; `answer` may be replaced by any bytes, None says nothing."""

    def __init__(self, path: Path, answer: Callable[[Messages], bytes | None]) -> None:
        self.answer = answer
        self.log: list[Messages] = []
        self._listener = socket.socket(socket.AF_UNIX)
        self._listener.bind(str(path))
        self._listener.listen()
        self._client: socket.socket | None = None
        self._thread = threading.Thread(target=self._serve)
        self._thread.start()

    def drop_client(self) -> None:
        client = self._client
        if client is not None:
            with suppress(OSError):
                client.shutdown(socket.SHUT_RDWR)

    def finish(self) -> None:
        self._listener.shutdown(socket.SHUT_RDWR)
        self.drop_client()
        self._thread.join()
        self._listener.close()

    def _serve(self) -> None:
        while True:
            try:
                self._client, _ = self._listener.accept()
            except OSError:
                return
            with suppress(ConnectionError), self._client as client, client.makefile("rb") as stream:
                while (messages := read_request(stream)) is not None:
                    self.log.append(messages)
                    if (answer := self.answer(messages)) is not None:
                        client.sendall(answer)
            self._client = None


class MemoryBus(Bus):
    """A bus whose transactions take no time."""

    def __init__(self, answer: Callable[[Messages], bytes | None]) -> None:
        super().__init__(Tap())
        self.answer = answer
        self.log: list[Messages] = []

    def transact(self, address: int, written: bytes, length: int) -> bytes:
        messages = read_request(BytesIO(encode(address, written, length)))
        assert messages is not None
        self.log.append(messages)
        answer = self.answer(messages)
        error = errno.ETIMEDOUT if answer is None else answer[0]
        if answer is None or error:
            raise OSError(error, os.strerror(error))
        return answer[1:]

    def close(self) -> None:
        pass


class Unit(DriverContext):
    """The context of an inertial unit on such a bus; its clock goes on by itself only as far as the driver sleeps."""

    def __init__(self, patch: pytest.MonkeyPatch, bus: Bus, **settings: Any) -> None:
        super().__init__(KIND, KIND.settings(device="imu", **settings), "unix:/memory/imu", "mpu9150")
        patch.setattr(capability, "open_bus", lambda _device, address: (bus, address))
        patch.setattr(controller.InertialUnit.__init__, "__defaults__", (self.clock, self.sleep))

    def clock(self) -> float:
        return self.now

    def sleep(self, seconds: float) -> None:
        self.now += seconds

    @property
    def samples(self) -> list[Any]:
        return [sample for _, sample in self.published]


def read_request(stream) -> Messages | None:
    """Written from the description of the framing alone."""
    head = stream.read(1)
    if not head:
        return None
    messages: Messages = []
    for _ in range(head[0]):
        address, flags, length = struct.unpack("<BBH", stream.read(4))
        messages.append((address, length if flags & 1 else stream.read(length)))
    return messages


class Chips:
    """An MPU-9150's registers, as far as its driver uses them; every burst differs a little, as real ones do."""

    def __init__(self) -> None:
        self.burst = [100, -200, 16384, 340, 131, -262, 393]
        self.field = [100, -50, 200]
        self.status2 = 0
        self.fuses = (128, 128, 128)
        self.compass_id, self.who = 0x48, 0x68
        self.frozen = self.busy = False
        self.fails: dict[int, int] = {}
        self.bursts = self.conversions = 0
        self.compass_mode = 0
        self.power_up()

    def power_up(self) -> None:
        self.registers = bytearray(128)
        self.registers[0x6B] = 0x40

    def __call__(self, messages: Messages) -> bytes:
        found, pointer = b"\0", 0
        for address, part in messages:
            through = self.registers[0x37] & 2 and not self.registers[0x6A] & 0x20
            if address in self.fails or (address != MPU and not (address == COMPASS and through)):
                return bytes((self.fails.get(address, errno.EREMOTEIO),))
            if isinstance(part, int):
                found += self._read(address, pointer, part)
            else:
                pointer = part[0]
                for offset, value in enumerate(part[1:]):
                    self._write(address, pointer + offset, value)
        return found

    def _write(self, address: int, register: int, value: int) -> None:
        if address == COMPASS:
            assert register == 0x0A
            assert 0 in {self.compass_mode, value}, "changes of mode go through 0"
            self.compass_mode = value
        elif register == 0x6B and value & 0x80:
            self.power_up()
        else:
            self.registers[register] = value

    def _read(self, address: int, register: int, count: int) -> bytes:
        if address == COMPASS:
            return self._read_compass(register, count)
        if register == 0x75:
            return bytes((self.who,))
        if register == 0x3B:
            assert count == 14
            return self._measured()
        return bytes(self.registers[register : register + count])

    def _measured(self) -> bytes:
        if self.registers[0x6B] & 0x40:
            return bytes(14)
        self.bursts += not self.frozen
        noise = self.bursts % 2
        return struct.pack(">7h", *self.burst[:3], self.burst[3] + noise, *self.burst[4:])

    def _read_compass(self, register: int, count: int) -> bytes:
        if register == 0x00:
            return bytes((self.compass_id,))
        if register == 0x10:
            return bytes(self.fuses) if self.compass_mode == 0x0F else bytes(3)
        assert (register, count) == (0x02, 8)
        ready = self.compass_mode == 1 and not self.busy
        if ready:
            self.compass_mode = 0
            self.conversions += 1
        return struct.pack("<B3hB", ready, *self.field, self.status2)
