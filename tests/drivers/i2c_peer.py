"""An i2c bus behind a unix socket for tests: registers by address, and whatever can go wrong with them."""

import errno
import socket
import struct
import threading
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from lbr.capability.context import Device

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
