"""The driver against the emulated chip, which was written from the same datasheets by other means."""

import time
from functools import partial

import msgspec
import pytest

from lbr.drivers import i2c
from lbr.drivers.i2c_socket import SocketBus
from lbr.drivers.mpu9150 import KIND
from lbr.errors import DeviceError
from lbr.simulation.devices.mpu9150.twin import Mpu9150
from lbr.simulation.i2c import Message, transfer
from lbr.simulation.measured import ImuReading
from tests.drivers.i2c_peer import MPU, Server
from tests.drivers.peers import DriverContext
from tests.support.waiting import HANG_S

FELT = ImuReading(
    gyro_rps=(0.5, -0.25, 2.0), accel_mps2=(1.0, -2.0, 9.5), mag_ut=(20.0, -5.0, -43.0), temperature_c=31.0
)


@pytest.fixture
def chip():
    return Mpu9150()


@pytest.fixture
def ctx(tmp_path, chip, monkeypatch):
    monkeypatch.setattr(i2c, "SocketBus", partial(SocketBus, deadline_s=HANG_S))  # a chip that is held up
    turns = 0

    def answer(messages):
        nonlocal turns
        turns += 1
        now = time.monotonic()
        chip.feel(msgspec.structs.replace(FELT, temperature_c=31.0 + turns % 3 / 10), now)
        told = [
            Message(address, read=part) if isinstance(part, int) else Message(address, write=part)
            for address, part in messages
        ]
        return transfer(chip.on_bus(MPU), told, now)

    server = Server(tmp_path / "imu", answer)
    settings = KIND.parse('{"device": "imu", "mag_hz": 100}')
    yield DriverContext(KIND, settings, f"unix:{tmp_path / 'imu'}", "mpu9150")
    server.finish()


@pytest.fixture
def imu(ctx):
    imu = KIND.load()(ctx)
    imu.open()
    yield imu
    imu.close()


def step_until(imu, ctx, wanted):
    end = time.monotonic() + HANG_S
    while True:
        imu.step()
        if wanted(ctx.state):
            return ctx.state
        assert time.monotonic() < end, ctx.state


def test_what_the_chip_feels_is_what_is_published(imu, ctx):
    sample = step_until(imu, ctx, lambda sample: sample.mag_ut is not None)
    assert sample.gyro_rps == pytest.approx(FELT.gyro_rps, abs=0.0003)
    assert sample.accel_mps2 == pytest.approx(FELT.accel_mps2, abs=0.002)
    assert sample.mag_ut == pytest.approx(FELT.mag_ut, abs=0.3)
    assert sample.temperature_c == pytest.approx(31.1, abs=0.2)
    assert time.monotonic() - sample.time_s < HANG_S


def test_a_magnet_takes_the_compass_alone(imu, ctx, chip):
    step_until(imu, ctx, lambda sample: sample.mag_ut is not None)
    chip.faults = msgspec.structs.replace(chip.faults, overflow=True)
    # On a slow machine it is first said not to finish measuring.
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
