"""The common part of emulated devices on an i2c bus of their own: a socket, transactions, and bus faults."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from random import Random
from typing import TypeVar

from lbr.simulation.faults import I2cFaults
from lbr.simulation.i2c import FramingError, I2cDevice, Message, RequestReader, refusal, transfer
from lbr.simulation.socket_port import SocketPort
from lbr.simulation.twins.base import PortTwin, plug
from lbr.simulation.wire import strikes

F = TypeVar("F", bound=I2cFaults)


class I2cTwin(PortTwin[SocketPort, F], ABC):
    """Serves one transaction after another, for several clients as a bus does; transactions take no time."""

    def __init__(self, name: str, address: str, faults: F, seed: int) -> None:
        super().__init__(name, SocketPort(address), faults)
        self._random = Random(seed)
        self._requests: dict[int, RequestReader] = {}

    @abstractmethod
    def take_over(self) -> None:
        """Pass the present faults to the device."""

    @abstractmethod
    def devices(self) -> Mapping[int, I2cDevice]:
        """Return the devices on the bus, for one transaction."""

    def service(self, now: float) -> None:
        """Do all that is due: the cable, and every received transaction."""
        self.take_over()
        if plug(self.port, present=not self._faults.unplug):
            self._requests.clear()
        if self.port.plugged:
            for client, data in self.port.receive():
                self._serve(client, data, now)

    def _serve(self, client: int, data: bytes, now: float) -> None:
        if not data or self._faults.silent:
            self._requests.pop(client, None)
            return
        try:
            transactions = self._requests.setdefault(client, RequestReader()).feed(data)
        except FramingError:
            self.port.drop(client)
            self._requests.pop(client, None)
            return
        for messages in transactions:
            answer = self._answer(messages, now)
            if self.port.send(client, answer) < len(answer):
                self.port.drop(client)  # it reads nothing: the answers could no longer be separated

    def _answer(self, messages: tuple[Message, ...], now: float) -> bytes:
        faults = self._faults
        if strikes(faults.nak, self._random):
            return refusal()
        answer = transfer(self.devices(), messages, now)
        if faults.all_ones:
            answer = answer[:1] + b"\xff" * (len(answer) - 1)
        if strikes(faults.half, self._random):
            answer = answer[: self._random.randrange(len(answer))]
        return answer
