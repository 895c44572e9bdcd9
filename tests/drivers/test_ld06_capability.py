"""The LD06 on a line: whole turns become scans, and silence, rubbish and a missing row are told."""

import time
from math import pi

import pytest

from lbr.capability.context import Device
from lbr.drivers.ld06 import KIND
from lbr.errors import DeviceError
from lbr.messages.sensing import RangeSensor
from lbr.simulation.measured import Sensed
from lbr.simulation.twins.base import Surroundings, make
from tests.drivers.peers import DriverContext
from tests.support.waiting import until

ROW = RangeSensor(name="lidar", kind="lidar", fov_rad=6.2832, min_m=0.02, max_m=12.0, rays=360)


class Bench:
    """A driver and the emulated lidar on one line; `hear` has time pass for both."""

    def __init__(self, folder, row=ROW, **settings):
        device = Device("line", "ld06", str(folder / "lidar"), {})
        self.twin = make(device, Surroundings(seed=1, now=time.monotonic(), sensors=(ROW,)))
        self.twin.service(time.monotonic())
        self.twin.sense(Sensed(battery_v=12.0, scans_m={"lidar": tuple(1.0 + n / 360 for n in range(360))}))
        given = KIND.settings(device="line", timeout_s=0.3, start_timeout_s=2.0, **settings)
        self.ctx = DriverContext(KIND, given, device.address, "ld06")
        self.ctx.given = (row,) if row is not None else ()
        self.driver = KIND.load()(self.ctx)

    def step(self):
        self.twin.service(time.monotonic())
        self.driver.step()
        return True

    def hear(self, count):
        until(lambda: self.step() and len(self.ctx.published) >= count)

    def close(self):
        self.driver.close()
        self.twin.close()


@pytest.fixture
def bench(tmp_path):
    made = Bench(tmp_path)
    made.driver.open()
    yield made
    made.close()


def test_every_whole_turn_is_told_and_the_first_makes_it_ready(bench, wording):
    bench.step()
    wording(*bench.ctx.health)
    bench.hear(3)
    assert bench.ctx.health[-1] == "ready"
    output, scan = bench.ctx.published[-1]
    assert output == "scan"
    assert (scan.sensor, len(scan.ranges_m), scan.angle_min_rad) == ("lidar", 360, -pi)
    faced = [1.0 + n / 360 for n in range(360)]
    assert sum(abs(a - b) < 0.01 for a, b in zip(scan.metres(), faced, strict=True)) > 350


@pytest.mark.parametrize("fault", ["silent", "stalled", "bit_flip"])
def test_without_a_turn_in_time_it_is_an_error(bench, fault):
    bench.hear(1)
    bench.twin.fault(fault, True)
    began = time.monotonic()
    with pytest.raises(DeviceError, match=r"'line' is silent: no scan for 0\.[3-9] s.*mirror turns"):
        until(lambda: not bench.step())
    assert time.monotonic() - began > 0.2


def test_a_pulled_cable_is_an_error_at_once(bench):
    bench.hear(1)
    bench.twin.fault("unplug", True)
    with pytest.raises(DeviceError, match="went away"):
        until(lambda: not bench.step())


def test_noise_on_the_line_is_told_once_in_a_while(bench):
    bench.twin.fault("garbage", 0.5)
    bench.hear(3)
    (told,) = bench.ctx.told("bad_bytes")
    assert "from the lidar" in told


@pytest.mark.parametrize(
    "row",
    [
        None,
        RangeSensor(name="lidar", kind="lidar"),
    ],
)
def test_without_a_row_that_says_where_it_is_it_does_not_begin(tmp_path, row, wording):
    bench = Bench(tmp_path, row)
    with wording.of(DeviceError):
        bench.driver.open()
    bench.close()
