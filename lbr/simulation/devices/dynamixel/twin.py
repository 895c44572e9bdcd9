"""The emulated servo bus on its port."""

from collections.abc import Mapping
from random import Random

from lbr.capability.context import Device
from lbr.simulation.bus_timing import rhythm
from lbr.simulation.devices.dynamixel import DynamixelFaults, DynamixelRow
from lbr.simulation.devices.dynamixel.bus import DynamixelBus, OnInstruction
from lbr.simulation.devices.dynamixel.dongle import Usb2Ax
from lbr.simulation.devices.dynamixel.servo import AxServo
from lbr.simulation.measured import ServoDrive, ServoFelt
from lbr.simulation.twins.base import Surroundings, row
from lbr.simulation.twins.line import LineTwin

LEAST_SUPPLY_V = 5.0
"""Below this voltage, a servo's processor is off; its error bits begin higher."""


class DynamixelTwin(LineTwin[DynamixelFaults]):
    """Moves a body's joints, and measures them; without a body its servos turn by themselves, without load."""

    def __init__(self, device: Device, around: Surroundings, on_instruction: OnInstruction | None = None) -> None:
        settings = row(device, DynamixelRow)
        seed = around.seed_for(device)
        self.bus = DynamixelBus(
            servos(settings, seed),
            dongle=Usb2Ax(settings.usb2ax) if settings.usb2ax is not None else None,
            timing=settings.timing,
            faults=settings.faults,
            seed=seed,
            on_instruction=on_instruction,
        )
        super().__init__(device, settings.faults, self.bus)

    def hear(self, data: bytes, now: float) -> bytes:
        """Receive bytes at the host's rate; return the bytes that have crossed the line back."""
        return self.bus.feed(data, now, self.port.baud()) if data else self.bus.poll(now)

    def drives(self, _now: float) -> Mapping[int, ServoDrive]:
        """Return each servo's motor state; a servo without power is limp."""
        return {servo.id: servo.drive() for servo in self.bus.servos}

    def feel_servos(self, felt: Mapping[int, ServoFelt], supply_v: float, now: float) -> None:
        """Set the servos' angles in the world, and the voltage of their supply."""
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
