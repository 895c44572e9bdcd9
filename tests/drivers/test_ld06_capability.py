"""The LD06 on a line: whole turns become scans, and silence, rubbish and a missing row are told."""

from math import pi

import pytest

from lbr.capability.context import Device
from lbr.drivers.ld06 import KIND, capability
from lbr.errors import DeviceError
from lbr.messages.sensing import RangeSensor
from lbr.simulation.measured import Sensed
from lbr.simulation.twins.base import Surroundings, make
from lbr.testing import FakeContext
from tests.support.whole_robot import MemoryPort

ROW = RangeSensor(name="lidar", kind="lidar", fov_rad=6.2832, min_m=0.02, max_m=12.0, rays=360)


class Line:
    """The driver's end of a line in memory."""

    def __init__(self, port):
        self._port = port

    def read(self):
        data, self._port.said = self._port.said, b""
        return data

    drop_input = read

    def close(self):
        pass


class Bench:
    """A driver and the emulated lidar on one line, in the test's time."""

    def __init__(self, patch, row=ROW, **settings):
        given = KIND.settings(device="line", timeout_s=0.3, start_timeout_s=2.0, **settings)
        device = Device("line", "ld06", "/memory/lidar", {})
        self.ctx = FakeContext(KIND, given, device=device, given=() if row is None else (row,))
        patch.setattr("lbr.simulation.twins.line.PtyPort", MemoryPort)
        patch.setattr(capability, "open_line", lambda *_: Line(self.twin.port))
        self.twin = make(device, Surroundings(seed=1, now=self.ctx.now, sensors=(ROW,)))
        self.twin.sense(Sensed(battery_v=12.0, scans_m={"lidar": tuple(1.0 + n / 360 for n in range(360))}))
        self.driver = KIND.load()(self.ctx)

    def step(self):
        self.ctx.now += 1.0 / self.driver.rate_hz
        self.twin.service(self.ctx.now)
        self.driver.step()

    def hear(self, count):
        while len(self.ctx.published) < count:
            self.step()


@pytest.fixture
def bench(monkeypatch):
    made = Bench(monkeypatch)
    made.driver.open()
    return made


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
    began = bench.ctx.now
    with pytest.raises(DeviceError, match=r"'line' is silent: no scan for 0\.3 s.*mirror turns"):
        bench.hear(99)
    assert bench.ctx.now - began == pytest.approx(0.3, abs=0.021)


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
def test_without_a_row_that_says_where_it_is_it_does_not_begin(monkeypatch, row, wording):
    bench = Bench(monkeypatch, row)
    with wording.of(DeviceError):
        bench.driver.open()
