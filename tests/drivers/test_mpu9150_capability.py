import errno
from math import radians

import pytest

from lbr.drivers.mpu9150.capability import Mpu9150
from lbr.errors import DeviceError
from tests.drivers.i2c_peer import COMPASS, MPU, Chips, MemoryBus, Unit

TICK_S = 0.01


@pytest.fixture
def chips():
    return Chips()


@pytest.fixture
def peer(chips):
    return MemoryBus(chips)


@pytest.fixture
def make(peer, monkeypatch):
    def make(**settings):
        ctx = Unit(monkeypatch, peer, **{"gyro_range_dps": 250, "accel_range_g": 2, **settings})
        return Mpu9150(ctx), ctx

    return make


def steps(imu, ctx, count=1):
    for _ in range(count):
        ctx.now += TICK_S
        imu.step()
    return ctx.samples[-count:]


def test_it_starts_the_unit_and_measures_in_si_units(make, chips):
    imu, ctx = make()
    began = ctx.now
    imu.open()
    assert 0.03 < ctx.now - began < 0.5
    assert chips.registers[0x6B] == 1
    assert chips.registers[0x37] == 2
    assert bytes(chips.registers[0x19:0x1D]) == b"\x00\x03\x00\x00"
    first, second = steps(imu, ctx, 2)
    assert first.valid
    assert first.time_s == pytest.approx(ctx.now - TICK_S)
    assert first.accel_mps2 == pytest.approx((0.0599, -0.1197, 9.80665), abs=1e-4)
    assert first.gyro_rps == pytest.approx((radians(1), radians(-2), radians(3)))
    assert first.temperature_c == pytest.approx(36.0, abs=0.01)
    assert first.mag_ut is None
    assert second.mag_ut == pytest.approx((-15.0, 30.0, -60.0))
    assert ctx.events == []


def test_a_sample_is_one_burst_and_the_compass_is_asked_as_often_as_set(make, chips, peer):
    imu, ctx = make(mag_hz=25)
    imu.open()
    peer.log.clear()
    measured = steps(imu, ctx, 100)
    bursts = [each for each in peer.log if each == [(MPU, b"\x3b"), (MPU, 14)]]
    assert len(bursts) == 100
    assert sum(sample.mag_ut is not None for sample in measured) == pytest.approx(25, abs=1)
    assert len(peer.log) < 170


@pytest.mark.parametrize(("mag_hz", "expected"), [(100, 99), (50, 50), (10, 10), (1, 1)])
def test_the_compass_keeps_its_rate(make, mag_hz, expected):
    imu, ctx = make(mag_hz=mag_hz)
    imu.open()
    assert sum(sample.mag_ut is not None for sample in steps(imu, ctx, 100)) == pytest.approx(expected, abs=1)


def test_without_a_compass_rate_nothing_is_said_to_it(make, chips, peer):
    chips.fails[COMPASS] = errno.EREMOTEIO
    imu, ctx = make(mag_hz=0)
    imu.open()
    assert all(sample.valid and sample.mag_ut is None for sample in steps(imu, ctx, 20))
    assert not [message for messages in peer.log for message in messages if message[0] == COMPASS]


@pytest.mark.parametrize(
    ("who", "said"), [(0x71, r"0x71 \(an MPU-9250\)"), (0xFF, r"0xff \(nothing\)"), (0x33, r"0x33 \(something else\)")]
)
def test_another_chip_is_named_and_nothing_is_written_to_it(make, chips, peer, who, said):
    chips.who = who
    imu, _ = make()
    with pytest.raises(DeviceError, match=rf"'imu' .*{said}, not 0x68"):
        imu.open()
    assert peer.log == [[(MPU, b"\x75"), (MPU, 1)]]


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        (lambda chips: chips.fails.update({MPU: errno.EREMOTEIO}), r"it does not answer at 0x68 \(Remote I/O error\)"),
        (lambda chips: setattr(chips, "compass_id", 0x33), r"0x33, not 0x48; .* mag_hz to 0"),
        (lambda chips: setattr(chips, "fuses", (0, 0, 0)), r"sensitivity of its compass cannot be read \(00 00 00\)"),
    ],
)
def test_what_does_not_start_is_a_device_error_and_starts_once_it_can(make, chips, spoil, said):
    imu, ctx = make()
    spoil(chips)
    with pytest.raises(DeviceError, match=said):
        imu.open()
    imu.close()
    imu.degraded("it does not start")
    assert not ctx.state.valid
    assert ctx.state.accel_mps2 is None
    chips.__init__()
    imu.open()
    assert steps(imu, ctx)[0].valid


@pytest.mark.parametrize("number", [errno.EREMOTEIO, errno.ENXIO, errno.ENODEV, errno.EIO])
def test_an_error_of_the_bus_is_one_invalid_sample_and_no_number(make, chips, number):
    imu, ctx = make()
    imu.open()
    chips.fails[MPU] = number
    bad = steps(imu, ctx)[0]
    assert not bad.valid
    assert "does not answer at 0x68" in bad.reason
    assert (bad.accel_mps2, bad.gyro_rps, bad.mag_ut, bad.temperature_c) == (None, None, None, None)
    del chips.fails[MPU]
    assert steps(imu, ctx)[0].valid
    assert ctx.kinds() == ["bus"]


def test_many_errors_in_a_row_are_a_device_error_and_it_begins_anew(make, chips):
    imu, ctx = make(most_errors=4)
    imu.open()
    for _ in range(3):  # those that recovered do not count
        chips.fails[MPU] = errno.EREMOTEIO
        steps(imu, ctx, 3)
        chips.fails.clear()
        steps(imu, ctx)
    chips.fails[MPU] = errno.EREMOTEIO
    steps(imu, ctx, 3)
    with pytest.raises(DeviceError, match=r"'imu' at unix:.* does not answer at 0x68 .* check its power and wiring"):
        steps(imu, ctx)
    imu.close()
    chips.power_up()
    chips.fails.clear()
    imu.open()
    assert steps(imu, ctx)[0].valid


def test_a_bus_that_stalls_is_invalid_samples_and_then_a_device_error(make, peer, chips):
    imu, ctx = make(most_errors=2)
    imu.open()
    peer.answer = lambda _messages: None
    assert "timed out" in steps(imu, ctx)[0].reason
    peer.answer = chips
    assert steps(imu, ctx)[0].valid
    peer.answer = lambda _messages: None
    steps(imu, ctx)
    with pytest.raises(DeviceError, match="timed out"):
        steps(imu, ctx)


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        (lambda chips: setattr(chips, "burst", [-1, -1, -1, -1, -1, -1, -1]), "ones"),
        (lambda _chips: None, "frozen"),
    ],
)
def test_a_reading_that_is_none_is_invalid_and_in_the_end_starts_the_unit_anew(make, chips, spoil, said):
    imu, ctx = make()
    imu.open()
    steps(imu, ctx)
    spoil(chips)
    chips.frozen = True
    chips.bursts = 0
    bad = steps(imu, ctx, 20)[-1]
    assert not bad.valid
    assert said in bad.reason
    assert bad.gyro_rps is None
    assert "unusable" in ctx.kinds()
    with pytest.raises(DeviceError, match=rf"{said}.*restarted"):
        steps(imu, ctx, 120)


def test_a_unit_that_stays_frozen_through_a_new_start_is_so_from_its_first_sample(make, chips):
    imu, ctx = make(mag_hz=0)
    imu.open()
    chips.frozen = True
    with pytest.raises(DeviceError, match="frozen"):
        steps(imu, ctx, 200)
    imu.close()
    imu.open()
    assert "frozen" in steps(imu, ctx)[0].reason
    chips.frozen = False
    assert steps(imu, ctx)[0].valid


def test_a_unit_that_was_without_power_is_noticed_with_its_next_sample(make, chips):
    imu, ctx = make()
    imu.open()
    assert steps(imu, ctx)[0].valid
    chips.power_up()
    with pytest.raises(DeviceError, match=r"lost its settings; .*\(register 0x6b is 40, not 01\)"):
        steps(imu, ctx)
    imu.close()
    imu.open()
    assert steps(imu, ctx)[0].valid


def test_a_range_that_changed_by_itself_is_noticed_before_long(make, chips):
    imu, ctx = make()
    imu.open()
    steps(imu, ctx, 10)
    chips.registers[0x1B] = 0x18
    with pytest.raises(DeviceError, match="register 0x19 is 00 03 18 00, not 00 03 00 00"):
        steps(imu, ctx, 100)


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        (lambda chips: setattr(chips, "status2", 0x08), "too strong"),
        (lambda chips: setattr(chips, "status2", 0x04), "data error"),
        (lambda chips: setattr(chips, "busy", True), "does not finish"),
    ],
)
def test_a_compass_that_does_not_measure_leaves_the_rest_and_is_told(make, chips, spoil, said):
    imu, ctx = make()
    imu.open()
    steps(imu, ctx, 10)
    spoil(chips)
    steps(imu, ctx, 2)
    later = steps(imu, ctx, 150)
    assert all(sample.valid and sample.gyro_rps and sample.mag_ut is None for sample in later)
    told = [text for kind, text in ctx.events if kind == "compass"]
    assert len(told) == 1
    assert said in told[0]
    assert len(ctx.health) == 1
    assert ctx.health[0].startswith("no compass: ")
    chips.status2, chips.busy = 0, False
    assert any(sample.mag_ut for sample in steps(imu, ctx, 20))
    assert ctx.health[1:] == ["ready"]


@pytest.mark.parametrize("from_the_start", [True, False])
def test_a_compass_that_is_gone_leaves_the_rest_and_comes_back(make, chips, from_the_start):
    imu, ctx = make()
    if from_the_start:
        chips.fails[COMPASS] = errno.EREMOTEIO
    imu.open()
    steps(imu, ctx, 4)
    chips.fails[COMPASS] = errno.EREMOTEIO
    later = steps(imu, ctx, 300)
    assert all(sample.valid and sample.gyro_rps and sample.mag_ut is None for sample in later)
    assert len(ctx.health) == 1
    assert "no compass: device 'imu'" in ctx.health[0]
    assert "its compass does not answer at 0x0c (Remote I/O error)" in ctx.health[0]
    chips.__init__()
    imu.close()
    imu.open()
    assert any(sample.mag_ut for sample in steps(imu, ctx, 20))
    chips.fails[COMPASS] = errno.EREMOTEIO
    steps(imu, ctx, 50)
    del chips.fails[COMPASS]
    assert any(sample.mag_ut for sample in steps(imu, ctx, 250))
    assert ctx.health[-1] == "ready"


def test_a_compass_that_comes_back_as_another_chip_is_told_and_leaves_the_rest(make, chips):
    imu, ctx = make()
    imu.open()
    chips.fails[COMPASS] = errno.EREMOTEIO
    steps(imu, ctx, 50)
    del chips.fails[COMPASS]
    chips.compass_id = 0x33
    assert all(sample.valid for sample in steps(imu, ctx, 250))
    assert "0x33, not 0x48" in ctx.health[-1]


def test_what_is_beyond_the_range_is_not_measured_and_told(make, chips):
    imu, ctx = make()
    imu.open()
    chips.burst[0], chips.burst[6] = 32767, -32768
    sample = steps(imu, ctx)[0]
    assert sample.valid
    assert (sample.accel_mps2, sample.gyro_rps) == (None, None)
    assert ctx.kinds() == ["out_of_range"]


def test_only_ticks_measure(make, peer):
    imu, ctx = make()
    imu.open()
    asked = len(peer.log)
    ctx.on_tick = False
    imu.step()
    assert len(peer.log) == asked
    assert imu.rate_hz == 100.0
