"""The driver against the emulated chip, which was written from the same datasheets by other means."""

import msgspec
import pytest

from lbr.drivers.mpu9150.capability import Mpu9150
from lbr.errors import DeviceError
from lbr.simulation.devices.mpu9150.twin import Mpu9150 as Chip
from lbr.simulation.i2c import Message, transfer
from lbr.simulation.measured import ImuReading
from tests.drivers.i2c_peer import MPU, MemoryBus, Unit

TICK_S = 0.01
FELT = ImuReading(
    gyro_rps=(0.5, -0.25, 2.0), accel_mps2=(1.0, -2.0, 9.5), mag_ut=(20.0, -5.0, -43.0), temperature_c=31.0
)


@pytest.fixture
def chip():
    return Chip()


@pytest.fixture
def ctx(chip, monkeypatch):
    def answer(messages):
        felt = msgspec.structs.replace(FELT, temperature_c=31.0 + len(bus.log) % 3 / 10)
        chip.feel(felt, ctx.now)
        told = [Message(at, read=part) if isinstance(part, int) else Message(at, write=part) for at, part in messages]
        return transfer(chip.on_bus(MPU), told, ctx.now)

    bus = MemoryBus(answer)
    ctx = Unit(monkeypatch, bus, mag_hz=100)
    return ctx


@pytest.fixture
def imu(ctx):
    imu = Mpu9150(ctx)
    imu.open()
    return imu


def step_until(imu, ctx, wanted):
    for _ in range(500):
        ctx.now += TICK_S
        imu.step()
        if wanted(ctx.state):
            return ctx.state
    raise AssertionError(ctx.state)


def test_what_the_chip_feels_is_what_is_published(imu, ctx):
    sample = step_until(imu, ctx, lambda sample: sample.mag_ut is not None)
    assert sample.gyro_rps == pytest.approx(FELT.gyro_rps, abs=0.0003)
    assert sample.accel_mps2 == pytest.approx(FELT.accel_mps2, abs=0.002)
    assert sample.mag_ut == pytest.approx(FELT.mag_ut, abs=0.3)
    assert sample.temperature_c == pytest.approx(31.1, abs=0.2)
    assert sample.time_s == pytest.approx(ctx.now, abs=TICK_S)


def test_a_magnet_takes_the_compass_alone(imu, ctx, chip):
    step_until(imu, ctx, lambda sample: sample.mag_ut is not None)
    chip.faults = msgspec.structs.replace(chip.faults, overflow=True)
    step_until(imu, ctx, lambda _: any("too strong" in phase for phase in ctx.health))
    assert ctx.state.valid
    assert ctx.state.mag_ut is None


def test_a_brown_out_is_absence_and_then_a_new_start(imu, ctx, chip):
    chip.faults = msgspec.structs.replace(chip.faults, brown_out=True)
    imu.step()
    assert not ctx.state.valid
    chip.faults = msgspec.structs.replace(chip.faults, brown_out=False)
    with pytest.raises(DeviceError, match="lost its settings"):
        imu.step()
    imu.close()
    imu.open()
    assert step_until(imu, ctx, lambda sample: sample.valid).gyro_rps == pytest.approx(FELT.gyro_rps, abs=0.0003)


def test_without_its_compass_it_measures_the_rest(imu, ctx, chip):
    imu.close()
    chip.faults = msgspec.structs.replace(chip.faults, no_compass=True)
    imu.open()
    sample = step_until(imu, ctx, lambda sample: sample.valid)
    assert sample.gyro_rps == pytest.approx(FELT.gyro_rps, abs=0.0003)
    assert sample.mag_ut is None
