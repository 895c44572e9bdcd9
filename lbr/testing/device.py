"""A device's twin on a port of its own, in place of the device."""

import select
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, cast

from lbr.capability.context import Device
from lbr.simulation.faults import FaultValue
from lbr.simulation.measured import ImuReading, Sensed
from lbr.simulation.twins import Feeling, ServoBus, Surroundings, Twin, make

STEP_S = 0.005
"""The interval of its measurements, as in a world."""
LIVE_S = 0.5
"""The time for a thread to end."""
RANGES_M: dict[str, float | None] = dict.fromkeys(("forward", "back", "left", "right", "bottom"), 1.0)
AT_REST = Sensed(battery_v=12.6, ranges_m=RANGES_M)
SUPPLY_V = 11.1


class Plugged:
    """An emulated device, served by a thread, as in a world; `device` is its row, with the port's address."""

    def __init__(self, device: Device, live: Callable[[Twin, float], None] | None = None) -> None:
        self.device = device
        self.twin = make(device, Surroundings(seed=1, now=time.monotonic()))
        self.failure: BaseException | None = None
        self.drivers: list[Callable[[], None]] = []
        """Closing functions of its drivers: the guard of an open driver would end this process as a frozen one."""
        self._live = live or _at_rest
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._serve, name=f"twin of {device.name}", daemon=True)
        self._thread.start()

    def fault(self, name: str, value: FaultValue = True) -> None:
        """Set one of its twin's faults, such as `unplug` or `silent`."""
        self.twin.fault(name, value)

    def close(self) -> None:
        """Close its drivers, unplug it, and end; raise the thread's error."""
        for close in self.drivers:
            close()
        self._over.set()
        self._thread.join(LIVE_S * 10)
        self.twin.close()
        if self.failure is not None:
            raise self.failure

    def _serve(self) -> None:
        due = time.monotonic()
        try:
            while not self._over.is_set():
                now = time.monotonic()
                if now >= due:
                    self._live(self.twin, now)
                    due = now + STEP_S
                self.twin.service(now)
                wanted, itself = self.twin.watched(), self.twin.next_due()
                wait_s = max(0.0, min(due, due if itself is None else itself) - time.monotonic())
                select.select([] if wanted is None else [wanted], [], [], wait_s)
        except BaseException as err:  # noqa: BLE001 - whoever closes it raises it again
            self.failure = err


@contextmanager
def plugged(
    type_: str,
    folder: Path,
    *,
    name: str = "device",
    scheme: str = "",
    settings: dict[str, Any] | None = None,
    live: Callable[[Twin, float], None] | None = None,
) -> Iterator[Plugged]:
    """Plug in the twin of a type of device, at a port in a folder. `settings` are its row's.

    `scheme` begins its address if the type needs one, such as `unix:` on an I2C bus. `live` is called two hundred times
    a second to set its measurements; without it, it lies at rest.
    """
    device = Plugged(Device(name, type_, f"{scheme}{folder / name}", settings or {}), live)
    try:
        yield device
    finally:
        device.close()


@dataclass
class _Elsewhere:
    device: Device
    drivers: list[Callable[[], None]] = field(default_factory=list)


def elsewhere(device: Device) -> Plugged:
    """Return a device whose twin is in another process."""
    return cast("Plugged", _Elsewhere(device))


def _at_rest(twin: Twin, now: float) -> None:
    twin.sense(AT_REST)
    if isinstance(twin, Feeling):
        shaken = 0.01 * (1 + int(now / STEP_S) % 3)  # a unit whose values never change counts as frozen
        twin.feel(ImuReading(mag_ut=(20.0, -5.0, -43.0), gyro_rps=(shaken, 0.0, 0.0)), now)
    if isinstance(twin, ServoBus):
        twin.drives(now)
        twin.feel_servos({}, SUPPLY_V, now)
