"""The driver against the emulated unit, which was written apart from it."""

from math import hypot

import msgspec
import pytest

from lbr.drivers.inertial import LifeSigns
from lbr.drivers.riox import KIND
from lbr.drivers.riox.capability import MOST_ALIKE
from lbr.drivers.riox.controller import AhrsUnit
from lbr.errors import DeviceError
from lbr.simulation.devices.riox import RioxFaults, RioxRow
from lbr.simulation.devices.riox.twin import RioxDevice
from lbr.simulation.measured import ImuReading
from tests.drivers.memory_line import MemoryLine

FELT = ImuReading(
    gyro_rps=(0.5, -0.25, 2.0), accel_mps2=(1.0, -2.0, 9.5), mag_ut=(20.0, -5.0, -43.0), temperature_c=31.0
)


def converse(seconds, *, faults=None, echoes=True, **settings):
    device = RioxDevice(RioxRow(echo=echoes, faults=faults or RioxFaults()))
    line = MemoryLine(device)
    row = KIND.settings(device="imu", **settings)
    unit = AhrsUnit(line, row, lambda _kind, _text: None, LifeSigns(MOST_ALIKE), line.clock)
    unit.open()
    samples = []
    for turn in range(round(seconds * 100)):
        line.time.now += 0.01
        device.feel(msgspec.structs.replace(FELT, temperature_c=31.0 + turn % 7 / 10), line.clock())
        samples += unit.poll()
    return samples


@pytest.mark.parametrize("settings", [{}, {"echo": True}, {"echoes": False}])
def test_what_the_unit_feels_is_what_is_published(settings):
    samples = converse(1.0, **settings)
    assert len(samples) >= 40
    for sample in samples:
        assert sample.valid
        assert sample.gyro_rps == pytest.approx(FELT.gyro_rps, abs=0.001)
        assert sample.accel_mps2 == pytest.approx(FELT.accel_mps2, abs=0.001)
        assert sample.mag_ut == pytest.approx(FELT.mag_ut, abs=0.3)
        assert hypot(*sample.orientation) == pytest.approx(1.0)


@pytest.mark.parametrize("fault", [{"drop": 0.1}, {"garbage": 0.2}, {"half": 0.1}, {"refuse": 0.1}, {"pieces": True}])
def test_on_a_bad_line_samples_are_true_or_invalid(fault):
    samples = converse(3.0, faults=msgspec.convert(fault, RioxFaults), timeout_s=2.0)
    good = [sample for sample in samples if sample.valid]
    assert len(good) > 10
    for sample in good:
        assert sample.gyro_rps == pytest.approx(FELT.gyro_rps, abs=0.001)
        assert sample.accel_mps2 == pytest.approx(FELT.accel_mps2, abs=0.001)
    assert all(sample.reason and sample.gyro_rps is None for sample in samples if not sample.valid)


def test_a_silent_unit_is_a_device_error():
    with pytest.raises(DeviceError, match="nothing usable"):
        converse(1.0, faults=RioxFaults(silent=True))
