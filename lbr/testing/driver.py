"""What every driver has to do, tried on its device's twin: `pytest.mark.parametrize("check", CHECKS)`, then `check(bench)`."""

import time
from collections.abc import Callable
from typing import Any

from lbr.capability.base import Capability
from lbr.capability.context import Device
from lbr.capability.kind import Kind
from lbr.errors import DeviceError
from lbr.testing.context import FakeContext
from lbr.testing.device import Plugged

WITHIN_S = 8.0
"""Devices take seconds to begin; what takes longer than that has failed."""


class RealTimeContext(FakeContext[Any]):
    """A context whose clock is the machine's."""

    def clock(self) -> float:
        """Return monotonic seconds."""
        return time.monotonic()


class DriverBench:
    """A driver beside its emulated device, run as the runtime runs it: opened, stepped, closed and opened again.

    `settings` is its row as JSON; `rest` is what else its context has, as the rows that are `given`. `lose` is the fault by
    which the device is taken away; it is back when that is set to false.
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
        self.ctx = RealTimeContext(kind.parse(settings), device=device.device, devices=(device.device,), **rest)
        self.ctx.wired = wired or {}
        self.driver: Capability[Any] = kind.load()(self.ctx)
        self.errors: list[DeviceError] = []
        self._opened = False

    def until(self, condition: Callable[[], object], what: str) -> None:
        """Step until something is so; a lost device is opened again, as by the runtime."""
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

    def close(self) -> None:
        """Close the driver."""
        self._opened = False
        self.driver.close()

    def works(self) -> None:
        """Wait until it has published something new that it does not call invalid."""
        before = len(self.ctx.published)
        self.until(lambda: any(map(_valid, self.ctx.published[before:])), "something is published")

    def in_trouble(self) -> bool:
        """Say whether it has told that its device is away, does not work as it should, or measures nothing valid."""
        return (
            bool(self.errors)
            or any(phase != "ready" for phase in self.ctx.health)
            or not all(map(_valid, self.ctx.published[-1:]))
        )

    def _state(self) -> str:
        return f"errors {[str(err) for err in self.errors[-2:]]}, health {self.ctx.health[-2:]}"


def _valid(published: tuple[str, Any]) -> bool:
    return getattr(published[1], "valid", True) is not False


def says_what_it_reads(bench: DriverBench) -> None:
    """With its device there, it opens and publishes."""
    bench.works()
    bench.close()


def ends_as_often_as_it_is_told(bench: DriverBench) -> None:
    """It may be closed before it was opened, and twice."""
    bench.close()
    bench.works()
    bench.close()
    bench.close()


def names_a_device_that_is_not_there(bench: DriverBench) -> None:
    """Without its device it raises a DeviceError that names the row or the port, and ends no process."""
    device = bench.device.device
    absent = Device(device.name, device.type, f"{device.address}-absent", device.settings)
    ctx = RealTimeContext(bench.ctx.settings, device=absent, devices=(absent,), given=bench.ctx.given)
    driver = bench.kind.load()(ctx)
    end, said = time.monotonic() + WITHIN_S, ""
    try:
        driver.open()
        while time.monotonic() < end:
            driver.step()
            time.sleep(0.005)
    except DeviceError as err:
        said = str(err)
    finally:
        driver.close()
    assert said, f"{bench.kind.name}: a device that is not there is not missed"
    assert absent.name in said or absent.address in said, f"it does not say which device: {said}"


def misses_its_device_and_comes_back(bench: DriverBench) -> None:
    """When its device is lost it says so; when that is back, it works again, in the same process."""
    bench.works()
    bench.errors.clear()
    bench.ctx.health.clear()
    bench.device.fault(bench.lost)
    bench.until(bench.in_trouble, f"the loss by '{bench.lost}' is told")
    bench.device.fault(bench.lost, value=False)
    bench.works()
    bench.close()


def acknowledges_the_emergency_stop(bench: DriverBench) -> None:
    """What moves something says that it has stopped once the latch is engaged; what moves nothing has nothing to say."""
    if not bench.kind.moves:
        return
    bench.works()
    bench.ctx.estop.engaged = True
    bench.until(lambda: any(stopped for stopped, _ in bench.ctx.estop.acknowledged), "the stop is acknowledged")
    bench.close()


CHECKS: tuple[Callable[[DriverBench], None], ...] = (
    says_what_it_reads,
    ends_as_often_as_it_is_told,
    names_a_device_that_is_not_there,
    misses_its_device_and_comes_back,
    acknowledges_the_emergency_stop,
)
"""All of it."""
