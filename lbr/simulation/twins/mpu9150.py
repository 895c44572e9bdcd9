"""The emulated MPU-9150 on an i2c bus of its own."""

from random import Random

from lbr.capability.context import Device
from lbr.simulation.faults import Mpu9150Faults
from lbr.simulation.i2c import FramingError, Message, RequestReader, refusal, transfer
from lbr.simulation.measured import ImuReading, Sensed
from lbr.simulation.mpu9150 import Mpu9150
from lbr.simulation.rows import Mpu9150Row
from lbr.simulation.socket_port import SocketPort
from lbr.simulation.twins.base import PortTwin, Surroundings, plug, row


class Mpu9150Twin(PortTwin[SocketPort, Mpu9150Faults]):
    """Serves one transaction after another, for several clients as a bus does; takes no time for them."""

    def __init__(self, device: Device, around: Surroundings) -> None:
        settings = row(device, Mpu9150Row)
        super().__init__(device.name, SocketPort(device.address), settings.faults)
        self._address = settings.i2c_address
        self._random = Random(around.seed_for(device) + 1)
        self._chip = Mpu9150(seed=around.seed_for(device), sensitivity=settings.sensitivity)
        self._requests: dict[int, RequestReader] = {}

    def service(self, now: float) -> None:
        """Do all that is due: the cable, and every transaction that came."""
        if self._chip.faults is not self._faults:
            self._chip.faults = self._faults
        if plug(self.port, present=not self._faults.unplug):
            self._requests.clear()
        if self.port.plugged:
            for client, data in self.port.receive():
                self._serve(client, data, now)

    def next_due(self) -> float | None:
        """Return when it next has something to do by itself: never."""

    def sense(self, sensed: Sensed) -> None:
        """Nothing: it feels each step of the world."""

    def feel(self, reading: ImuReading, now: float) -> None:
        """Take in what it measures now."""
        self._chip.feel(reading, now)

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
                self.port.drop(client)  # it reads nothing: the answers could not be told apart any more

    def _answer(self, messages: tuple[Message, ...], now: float) -> bytes:
        faults = self._faults
        if self._hit(faults.nak):
            return refusal()
        answer = transfer(self._chip.on_bus(self._address), messages, now)
        if faults.all_ones:
            answer = answer[:1] + b"\xff" * (len(answer) - 1)
        if self._hit(faults.half):
            answer = answer[: self._random.randrange(len(answer))]
        return answer

    def _hit(self, probability: float) -> bool:
        return probability > 0 and self._random.random() < probability
