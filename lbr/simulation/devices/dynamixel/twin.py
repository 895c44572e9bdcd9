"""The emulated servo bus on its port."""

from collections.abc import Mapping
from random import Random

from lbr.capability.context import Device
from lbr.simulation.bus_timing import rhythm
from lbr.simulation.devices.dynamixel import DynamixelFaults, DynamixelRow
from lbr.simulation.devices.dynamixel.bus import DynamixelBus, OnInstruction
from lbr.simulation.devices.dynamixel.dongle import Usb2Ax
from lbr.simulation.devices.dynamixel.servo import AxServo
from lbr.simulation.measured import Sensed, ServoDrive, ServoFelt
from lbr.simulation.port import PtyPort
from lbr.simulation.twins.base import PortTwin, Surroundings, plug, row

LEAST_SUPPLY_V = 5.0
"""Below that a servo's processor is out; what it complains of begins higher."""


class DynamixelTwin(PortTwin[PtyPort, DynamixelFaults]):
    """Moves a body's joints, and measures them; without a body its servos turn by themselves, carrying nothing."""

    def __init__(self, device: Device, around: Surroundings, on_instruction: OnInstruction | None = None) -> None:
        settings = row(device, DynamixelRow)
        super().__init__(device.name, PtyPort(device.address), settings.faults)
        seed = around.seed_for(device)
        self.bus = DynamixelBus(
            servos(settings, seed),
            dongle=Usb2Ax(settings.usb2ax) if settings.usb2ax is not None else None,
            timing=settings.timing,
            faults=settings.faults,
            seed=seed,
            on_instruction=on_instruction,
        )

    def service(self, now: float) -> None:
        """Do all that is due: the cable, bytes in, bytes out."""
        if self.bus.faults is not self._faults:
            self.bus.faults = self._faults
        plug(self.port, present=not self._faults.unplug)
        heard = self.port.read()
        said = self.bus.feed(heard, now, self.port.baud()) if heard else self.bus.poll(now)
        if said:
            self.port.write(said)

    def next_due(self) -> float | None:
        """Return when it next has something to say."""
        return self.bus.next_due()

    def sense(self, sensed: Sensed) -> None:
        """Nothing: its servos feel each step of the world."""

    def drives(self, _now: float) -> Mapping[int, ServoDrive]:
        """Return what each servo's motor does now; a servo without supply is limp."""
        return {servo.id: servo.drive() for servo in self.bus.servos}

    def feel_servos(self, felt: Mapping[int, ServoFelt], supply_v: float, now: float) -> None:
        """Take in where the world has the servos, and the voltage of their supply."""
        self.bus.supplied = supply_v >= LEAST_SUPPLY_V
        for servo in self.bus.servos:
            if servo.id in felt:
                servo.feel(felt[servo.id], supply_v, now)


def servos(settings: DynamixelRow, seed: int) -> list[AxServo]:
    """Return the servos of a row, each with a rhythm of its own."""
    random = Random(seed)
    return [
        AxServo(
            number,
            return_delay=settings.return_delay,
            rhythm=rhythm(random),
            eeprom_s=settings.timing.eeprom_us * 1e-6,
            goal_switches_on=settings.goal_switches_on,
        )
        for number in settings.ids
    ]
