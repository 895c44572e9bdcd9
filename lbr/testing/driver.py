"""The duties of every driver, tried on its device's twin: `pytest.mark.parametrize("check", CHECKS)`, then
`check(bench)`.
"""

import time
from collections.abc import Callable, Mapping
from math import inf, isfinite, nan
from typing import Any

import msgspec
from msgspec import Struct

from lbr.capability.base import Capability
from lbr.capability.context import Device
from lbr.capability.kind import Kind
from lbr.errors import DeviceError
from lbr.messages.motors import MotorSetpoint
from lbr.simulation.faults import FaultValue
from lbr.simulation.twins import ServoBus, WheelDrive
from lbr.testing import driver_process
from lbr.testing.context import FakeContext
from lbr.testing.device import Plugged

WITHIN_S = 8.0
"""Devices take seconds to begin; a longer wait is a failure."""
BAD_LINE_S = 1.0
RUBBISH = ("garbage", "bit_flip", "half", "half_lines", "drop", "nak")
"""Faults of a line in emulated devices, each with its probability."""
BAD_SHARE = 0.3
POWER = 0.2
Powers = float | Mapping[str, float]
"""The power of all wheels, or of each motor by its name; others stand still."""
STOPS_WITHIN_S = 2.0
"""Longer than any controller's own watchdog, on a busy machine that holds up its guard."""


class RealTimeContext(FakeContext):
    """A context whose clock is the machine's."""

    def clock(self) -> float:
        """Return monotonic seconds."""
        return time.monotonic()


class DriverBench:
    """A driver beside its emulated device, run as the runtime runs it: opened, stepped, closed and opened again.

    `settings` is its row as JSON; `rest` are further arguments of its context, such as the rows `given`. `lose` is the
    fault that removes the device, which returns when that is set to false.
    """

    def __init__(
        self,
        kind: Kind,
        settings: str,
        device: Plugged,
        *,
        lose: str = "unplug",
        wired: dict[str, tuple[str, ...]] | None = None,
        **rest: Any,
    ) -> None:
        self.kind = kind
        self.device = device
        self.lost = lose
        self.settings = settings
        self._leases = 0
        self._rest = {"lose": lose, "wired": wired, **rest}
        self.ctx = RealTimeContext(kind, kind.parse(settings), device=device.device, devices=(device.device,), **rest)
        self.ctx.wired = wired or {}
        self.driver: Capability[Struct] = kind.load()(self.ctx)
        self.errors: list[DeviceError] = []
        self._opened = False
        device.drivers.append(self._close_opened)

    def until(self, condition: Callable[[], object], what: str) -> None:
        """Step until a condition holds; reopen a lost device, as the runtime does."""
        end = time.monotonic() + WITHIN_S
        while True:
            try:
                if not self._opened:
                    self.driver.open()
                    self._opened = True
                    self.ctx.ready()
                self.driver.step()
            except DeviceError as err:
                self.errors.append(err)
                self.close()
            if condition():
                return
            assert time.monotonic() < end, f"{self.kind.name}: not within {WITHIN_S:g} s: {what}; {self._state()}"
            time.sleep(0.005)

    def runs(self, for_s: float) -> None:
        """Step for a while."""
        end = time.monotonic() + for_s
        self.until(lambda: time.monotonic() >= end, "time goes on")

    def faults(self) -> dict[str, Any]:
        """Return the present faults of its device."""
        return self.device.twin.fault("unplug", value=False)

    def again(self, **settings: Any) -> "DriverBench":
        """Return a bench of the same driver and device, with a changed row."""
        self.close()
        changed = msgspec.json.decode(self.settings) | settings
        return DriverBench(self.kind, msgspec.json.encode(changed).decode(), self.device, **self._rest)

    def drive(self, power: Powers) -> None:
        """Send a setpoint for wheels, as from the drive."""
        each = power if isinstance(power, Mapping) else {"left": power, "right": power}
        sides = {side: each.get(side, 0.0) for side in ("left", "right")}
        others = {} if each.keys() <= sides.keys() else dict(each)
        message = MotorSetpoint(**sides, motors=others, lease=f"lease {self._leases}")
        self.ctx.arrive("setpoint", message, source=self._sender())

    def drives(self, power: Powers = POWER) -> None:
        """Turn the wheels, by a lease of their own: a zero arms their driver, then the power follows."""
        self._leases += 1

        def armed() -> bool:
            self.drive(0.0)
            return any(state.armed for state in self.ctx.said("state")[-1:])

        def turning() -> bool:
            holds = self.ctx.said("state")[-1].armed
            self._leases += not holds  # a machine that was busy ended what moved
            self.drive(power if holds else 0.0)
            return any(
                any((state.left, state.right, *(motor.power for motor in state.motors.values())))
                for state in self.ctx.said("state")[-1:]
            )

        self.until(armed, "its driver is armed by a zero")
        self.until(turning, "its wheels get power")

    def as_json(self, powers: Powers = POWER) -> dict[str, Any]:
        """Return the bench as JSON for another process, which drives wheels with these powers."""
        return {
            "powers": powers,
            "kind": self.kind.name,
            "home": self.ctx.home,
            "settings": self.settings,
            "device": {name: getattr(self.device.device, name) for name in ("name", "type", "address", "settings")},
            "wired": self.ctx.wired,
            "given": [
                (type(row).__module__, type(row).__qualname__, msgspec.to_builtins(row)) for row in self.ctx.given
            ],
        }

    def close(self) -> None:
        """Close the driver."""
        self._opened = False
        self.driver.close()

    def _close_opened(self) -> None:
        if self._opened:
            self.close()

    def works(self) -> None:
        """Wait until it has published a new message that it does not mark as invalid."""
        before = len(self.ctx.published)
        self.until(lambda: any(map(_valid, self.ctx.published[before:])), "something is published")

    def in_trouble(self) -> bool:
        """Return whether it has reported a missing or faulty device, or one without a valid reading."""
        return (
            bool(self.errors)
            or any(phase != "ready" for phase in self.ctx.health)
            or not all(map(_valid, self.ctx.published[-1:]))
        )

    def _sender(self) -> str:
        return next(iter(self.ctx.wired.get("setpoint", ())), "setpoint")

    def _state(self) -> str:
        reason = next((message.reason for _, message in reversed(self.ctx.published) if hasattr(message, "reason")), "")
        said = f", reason '{reason}'" if reason else ""
        if answers := self.ctx.estop.acknowledged:
            said += f", last answer to the emergency stop {answers[-1]}"
        return f"errors {[str(err) for err in self.errors[-2:]]}, health {self.ctx.health[-2:]}{said}"


def _valid(published: tuple[str, object]) -> bool:
    return getattr(published[1], "valid", True) is not False


def says_what_it_reads(bench: DriverBench) -> None:
    """With its device present, it opens and publishes."""
    bench.works()
    bench.close()


def closes_twice(bench: DriverBench) -> None:
    """It may be closed before it was opened, and twice."""
    bench.close()
    bench.works()
    bench.close()
    bench.close()


def names_a_device_that_is_not_there(bench: DriverBench) -> None:
    """Without its device it raises a DeviceError or warns, names the row or the port, and ends no process."""
    device = bench.device.device
    absent = Device(device.name, device.type, f"{device.address}-absent", device.settings)
    ctx = RealTimeContext(bench.kind, bench.ctx.settings, device=absent, devices=(absent,), given=bench.ctx.given)
    driver = bench.kind.load()(ctx)
    end, reported = time.monotonic() + WITHIN_S, ""
    try:
        driver.open()
        while not reported and time.monotonic() < end:
            driver.step()
            reported = next((text for text in ctx.health if absent.name in text or absent.address in text), "")
            time.sleep(0.005)
    except DeviceError as err:
        reported = str(err)
    finally:
        driver.close()
    assert reported, f"{bench.kind.name}: a device that is not there is not missed"
    assert absent.name in reported or absent.address in reported, f"it does not say which device: {reported}"


def misses_its_device_and_comes_back(bench: DriverBench) -> None:
    """It reports a lost device. When the device is back, it works again, in the same process."""
    bench.works()
    bench.errors.clear()
    bench.ctx.health.clear()
    bench.device.fault(bench.lost)
    bench.until(bench.in_trouble, f"the loss by '{bench.lost}' is reported")
    bench.device.fault(bench.lost, value=False)
    bench.works()
    bench.close()


def acknowledges_the_emergency_stop(bench: DriverBench) -> None:
    """A mover reports that it has stopped once the latch is engaged; other drivers have nothing to report."""
    if not bench.kind.moves:
        return
    bench.works()
    bench.ctx.estop.engaged = True
    bench.until(lambda: any(stopped for stopped, _ in bench.ctx.estop.acknowledged), "the stop is acknowledged")
    bench.close()


def says_that_its_device_is_silent(bench: DriverBench) -> None:
    """It reports a silent device. When the device answers again, it works again."""
    usual, twin = bench.faults().get("silent"), bench.device.twin
    if usual is None:
        return
    silent: FaultValue = True
    if not isinstance(usual, bool) and isinstance(twin, ServoBus):
        silent = ",".join(map(str, twin.drives(time.monotonic())))  # each of its servos
    bench.works()
    bench.errors.clear()
    bench.ctx.health.clear()
    bench.device.fault("silent", silent)
    bench.until(bench.in_trouble, "the silence of the device is reported")
    bench.device.fault("silent", usual)
    bench.works()
    bench.close()


def publishes_no_rubbish(bench: DriverBench) -> None:
    """On a bad line it neither breaks nor publishes invalid numbers; on a good one it works again."""
    usual = bench.faults()
    found = [name for name in RUBBISH if isinstance(usual.get(name), float)]
    bench.works()
    for name in found:
        bench.device.fault(name, BAD_SHARE)
        bench.runs(BAD_LINE_S)
        bench.device.fault(name, usual[name])
    bench.works()
    wrong = [(output, message) for output, message in bench.ctx.published if not _finite(msgspec.to_builtins(message))]
    assert not wrong, f"{bench.kind.name}: it publishes what is not a number: {wrong[0]}"
    bench.close()


def takes_no_number_for_a_stop(bench: DriverBench) -> None:
    """Turning wheels stop when a setpoint is not a number."""
    twin = bench.device.twin
    if not isinstance(twin, WheelDrive):
        return
    for power in (nan, inf, -inf):
        bench.drives()
        bench.until(lambda: _turns(twin), "its wheels turn")

        def stopped(power: float = power) -> bool:
            bench.drive(power)
            return not _turns(twin)

        bench.until(stopped, f"its wheels stop at a setpoint of {power}")
    bench.close()


def may_be_killed(bench: DriverBench) -> None:
    """When it is killed, its guard or the controller stops the wheels; the next driver gets the device at once."""
    twin = bench.device.twin
    process = driver_process.started(bench.as_json())
    try:
        driver_process.wait_until_it_works(process, WITHIN_S)
        if isinstance(twin, WheelDrive):
            end = time.monotonic() + WITHIN_S
            while not _turns(twin):
                assert time.monotonic() < end, f"{bench.kind.name}: its wheels did not turn"
                time.sleep(0.005)
    finally:
        driver_process.kill(process)
    end = time.monotonic() + STOPS_WITHIN_S
    while isinstance(twin, WheelDrive) and _turns(twin):
        assert time.monotonic() < end, f"{bench.kind.name}: its wheels turn on after it was killed"
        time.sleep(0.005)
    bench.works()
    bench.close()


def _turns(twin: WheelDrive) -> bool:
    return any(power != 0.0 for power in twin.wheels(time.monotonic()))


def _finite(value: object) -> bool:
    """Return whether all numbers in it are finite."""
    if isinstance(value, dict):
        return all(map(_finite, value.values()))
    if isinstance(value, list | tuple):
        return all(map(_finite, value))
    return not isinstance(value, float) or isfinite(value)


CHECKS: tuple[Callable[[DriverBench], None], ...] = (
    says_what_it_reads,
    closes_twice,
    names_a_device_that_is_not_there,
    misses_its_device_and_comes_back,
    acknowledges_the_emergency_stop,
    says_that_its_device_is_silent,
    publishes_no_rubbish,
    takes_no_number_for_a_stop,
    may_be_killed,
)
"""All of these checks."""
