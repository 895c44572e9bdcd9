"""The driver against the emulated unit at its socket: the same calls as the library's, other people's numbers."""

import sys
import threading
import time
from itertools import pairwise
from math import inf, nan, radians
from types import ModuleType

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.capability.context import Device
from lbr.drivers.phidget_spatial import KIND, capability
from lbr.drivers.phidget_spatial.capability import MOST_ALIKE, SILENT_S
from lbr.drivers.phidget_spatial.emulated import EmulatedSpatial
from lbr.drivers.phidget_spatial.library import Spatial, find
from lbr.drivers.phidget_spatial.readings import DeviceClock, Reading, sample, scaled
from lbr.errors import DeviceError
from lbr.messages.imu import ZeroCommand
from lbr.simulation.devices.phidget_spatial.twin import RECORD, PhidgetSpatial, PhidgetSpatialTwin
from lbr.simulation.measured import ImuReading
from lbr.simulation.twins.base import Surroundings
from lbr.testing import FakeCall
from tests.drivers.peers import DriverContext
from tests.support import needs
from tests.support.waiting import HANG_S, until

FELT = ImuReading(gyro_rps=(0.5, -0.25, 2.0), accel_mps2=(1.0, -2.0, 9.5), mag_ut=(20.0, -5.0, -43.0))
TURNING = (0.5, -0.25, 2.0)


class World:
    """Serves the emulated unit, which feels some noise, until it is told to end."""

    def __init__(self, place):
        self.felt, self._next, self.moved_s = FELT, None, 0.0
        self.twin = PhidgetSpatialTwin(Device("imu", "phidget_spatial", f"unix:{place}", {}), Surroundings(1, 0.0))
        self.twin.service(time.monotonic())
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def move(self, felt):
        """Have it feel something else from the end of a round on."""
        self._next = felt
        until(lambda: self._next is None)

    def end(self):
        self._ending.set()
        self._thread.join()
        self.twin.close()

    def _run(self):
        rounds = 0
        while not self._ending.wait(0.002):
            rounds += 1
            x, y, z = self.felt.accel_mps2
            self.twin.feel(ImuReading(**{**_fields(self.felt), "accel_mps2": (x, y, z + rounds % 89 / 1e5)}), 0.0)
            self.twin.service(time.monotonic())
            if self._next is not None:
                self.felt, self._next, self.moved_s = self._next, None, time.monotonic()


def _fields(reading):
    return {name: getattr(reading, name) for name in reading.__struct_fields__}


@pytest.fixture
def world(tmp_path):
    world = World(tmp_path / "imu")
    yield world
    world.end()


@pytest.fixture
def ctx(tmp_path):
    return DriverContext(KIND, KIND.parse('{"device": "imu"}'), f"unix:{tmp_path / 'imu'}", "phidget_spatial")


@pytest.fixture
def imu(ctx, world, monkeypatch):
    monkeypatch.setattr(capability, "SILENT_S", HANG_S)  # how soon a thread of the unit gets to run is another matter
    imu = KIND.load()(ctx)
    imu.open()
    yield imu
    imu.close()


def samples(imu, ctx, wanted):
    """Step until enough samples are as wanted, and return them."""
    end = time.monotonic() + HANG_S
    while True:
        ctx.published.clear() if len(ctx.published) > 5000 else None
        imu.step()
        found = [message for _, message in ctx.published if wanted(message)]
        if len(found) >= 5:
            return found
        assert time.monotonic() < end, "no such samples"
        time.sleep(0.002)


def test_samples_are_in_si_units_with_gravity_up(imu, ctx):
    found = samples(imu, ctx, lambda one: one.valid)
    assert found[0].gyro_rps == pytest.approx(FELT.gyro_rps)
    assert found[0].accel_mps2 == pytest.approx(FELT.accel_mps2, abs=0.001)


def test_the_compass_is_null_between_its_measurements(imu, ctx):
    with_field = samples(imu, ctx, lambda one: one.mag_ut is not None)
    assert with_field[0].mag_ut == pytest.approx(FELT.mag_ut)
    assert samples(imu, ctx, lambda one: one.valid and one.mag_ut is None)


def test_samples_are_dated_as_regularly_as_the_device_measures(imu, ctx):
    found = samples(imu, ctx, lambda one: len(ctx.published) > 60)
    times = [one.time_s for one in found]
    steps = sorted(later - earlier for earlier, later in pairwise(times))
    assert all(step > 0 for step in steps)
    assert steps[len(steps) // 2] == pytest.approx(0.004, abs=0.0005)
    assert times[-1] <= time.monotonic()


def test_a_unit_that_lies_still_measures_25_times_a_second_until_it_is_moved(imu, ctx, world):
    intervals = Intervals(imu, ctx)
    intervals.until(0.04)
    assert imu.rate_hz == 5.0
    world.move(ImuReading(gyro_rps=(0.0, 0.0, 1.0), accel_mps2=FELT.accel_mps2, mag_ut=FELT.mag_ut))
    intervals.until(0.004)
    assert imu.rate_hz == 125.0
    first = next(one for _, one in ctx.published if one.gyro_rps == pytest.approx((0.0, 0.0, 1.0)))
    assert first.time_s >= world.moved_s - 0.05


class Intervals:
    """Steps a driver until its newest samples lie so far apart."""

    def __init__(self, imu, ctx):
        self.imu, self.ctx = imu, ctx

    def until(self, interval_s):
        samples(self.imu, self.ctx, lambda _one: self.newest_s() == pytest.approx(interval_s, abs=0.002))

    def newest_s(self):
        if len(self.ctx.published) < 2:
            return 0.0
        (_, before), (_, last) = self.ctx.published[-2:]
        return last.time_s - before.time_s


@pytest.mark.parametrize(("fault", "reason"), [("frozen", "frozen"), ("no_compass", "")])
def test_a_fault_is_told_and_nothing_is_made_up(imu, ctx, world, fault, reason):
    samples(imu, ctx, lambda one: one.valid)
    world.twin.fault(fault, True)
    ctx.published.clear()
    if reason:
        assert reason in samples(imu, ctx, lambda one: not one.valid)[0].reason
        assert ctx.events[0][0] == "imu_dead"
    else:
        samples(imu, ctx, lambda one: one.valid and len(ctx.published) > 20)
        assert all(one.mag_ut is None for _, one in ctx.published[-10:])


@pytest.mark.parametrize(("fault", "said"), [("unplug", "was unplugged"), ("silent", "fallen silent")])
def test_a_unit_that_is_gone_or_silent_is_opened_anew(imu, ctx, world, fault, said, monkeypatch):
    samples(imu, ctx, lambda one: one.valid)
    world.twin.fault(fault, True)
    monkeypatch.setattr(capability, "SILENT_S", SILENT_S)
    with pytest.raises(DeviceError, match=said):
        samples(imu, ctx, lambda one: False)
    imu.close()
    imu.degraded("away")
    assert not ctx.published[-1][1].valid
    world.twin.fault(fault, None)
    ctx.published.clear()
    end = time.monotonic() + HANG_S
    while True:  # the line that was lost may be met once more
        try:
            imu.open()
            assert samples(imu, ctx, lambda one: one.valid)
            break
        except DeviceError:
            assert time.monotonic() < end
            imu.close()


def test_a_world_that_halts_for_a_moment_looks_like_no_frozen_unit():
    unit = PhidgetSpatial(now=0.0)
    unit.receive(b'{"interval_ms": 4}\n', 0.0)
    assert 0 < len(unit.records(5.0)) // RECORD.size < MOST_ALIKE


def test_the_gyro_is_zeroed_only_while_it_lies_still(imu, ctx, world):
    samples(imu, ctx, lambda one: one.valid)
    call = FakeCall("zero", ZeroCommand())
    imu.command(call)
    assert "turns by more than 5" in call.answer.reason
    call = FakeCall("zero", ZeroCommand())
    world.felt = ImuReading(gyro_rps=(radians(1.0), 0.0, 0.0))
    ctx.published.clear()
    samples(imu, ctx, lambda one: one.gyro_rps is not None and one.gyro_rps[2] == 0.0)
    imu.command(call)
    assert call.answer.accepted
    ctx.published.clear()
    assert "keep it still" in samples(imu, ctx, lambda one: not one.valid)[0].reason
    ctx.published.clear()
    zeroed = samples(imu, ctx, lambda one: one.valid)
    assert zeroed[0].gyro_rps == pytest.approx((0.0, 0.0, 0.0), abs=1e-6)


def test_without_a_unit_the_advice_is_to_plug_it_in(ctx):
    imu = KIND.load()(ctx)
    with pytest.raises(DeviceError, match="is it plugged in"):
        imu.open()
    imu.close()


@pytest.fixture
def library():
    """Phidgets' own, where this machine can load it."""
    try:
        from Phidget22.Devices.Spatial import Spatial as OnUsb

        OnUsb()
    except (ImportError, OSError) as err:
        if needs.IN_CI:
            raise
        pytest.skip(f"Phidgets' library cannot be loaded here: {err}")
    return OnUsb


def test_without_a_unit_the_real_library_says_so_too(ctx, library):
    ctx.device = Device("imu", "phidget_spatial", "usb:12345", {})
    imu = KIND.load()(ctx)
    with pytest.raises(DeviceError, match="is it plugged in"):
        imu.open()
    imu.close()


def test_the_stand_in_has_the_calls_of_the_library(library):
    calls = [name for name in vars(Spatial) if not name.startswith("_")]
    assert len(calls) == 6
    assert all(callable(getattr(library, name)) and callable(getattr(EmulatedSpatial, name)) for name in calls)


def test_without_the_library_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "Phidget22.Devices.Spatial", None)
    with pytest.raises(DeviceError, match="extra 'phidgets'"):
        find(Device("imu", "phidget_spatial", "usb:", {}))


def test_without_what_is_native_of_it_the_system_s_library_is_named(monkeypatch):
    def missing():
        raise OSError("libusb-1.0.so.0: cannot open shared object file")

    devices = ModuleType("Phidget22.Devices.Spatial")
    devices.Spatial = missing
    monkeypatch.setitem(sys.modules, "Phidget22.Devices.Spatial", devices)
    with pytest.raises(DeviceError, match="libusb"):
        find(Device("imu", "phidget_spatial", "usb:", {}))


def test_an_address_that_means_nothing_is_refused(wording):
    with wording.of(DeviceError):
        find(Device("imu", "phidget_spatial", "/dev/ttyUSB0", {}))


@pytest.mark.parametrize("interval_ms", [5, 12, 3])
def test_an_interval_that_no_board_has_is_refused(interval_ms):
    with pytest.raises(ValueError, match="interval_ms"):
        KIND.parse(f'{{"device": "imu", "interval_ms": {interval_ms}}}')


@given(st.lists(st.floats(), max_size=5), st.lists(st.floats(), max_size=5), st.lists(st.floats(), max_size=5))
def test_no_numbers_at_all_make_a_sample_that_lies(accel, gyro, mag):
    made = sample(Reading(accel, gyro, mag, 0.0, 0.0), 1.0, -1)
    numbers = [*(made.gyro_rps or ()), *(made.accel_mps2 or ()), *(made.mag_ut or ())]
    assert all(abs(number) < 1e300 for number in numbers)
    assert made.valid == (scaled(accel, 1.0) is not None and scaled(gyro, 1.0) is not None)
    assert made.valid or made.reason


@pytest.mark.parametrize("value", [nan, inf, 1e300, -1e300])
def test_sentinels_are_no_numbers(value):
    assert scaled((0.0, value, 0.0), 1.0) is None


@given(st.lists(st.floats(0.0, 0.03), min_size=2, max_size=50), st.floats(-1e6, 1e6), st.integers(-100, 100))
def test_a_bursty_arrival_does_not_show_in_the_dates(delays, offset_s, drift_ppm):
    """Dates grow, never lie ahead of the arrival, and are late by no more than the quickest delay and some drift."""
    clock, last = DeviceClock(), -inf
    least = inf
    for number, delay_s in enumerate(delays):
        true_s = 1000.0 + 0.004 * number
        device_ms = (true_s * (1 + drift_ppm * 1e-6) + offset_s) * 1000.0
        arrived_s = max(true_s + delay_s, last)
        least = min(least, arrived_s - true_s)
        dated_s = clock.date_s(Reading((), (), (), device_ms, arrived_s))
        assert last < dated_s <= arrived_s + 1e-6 or dated_s == pytest.approx(last, abs=1e-5)
        assert dated_s - true_s <= least + 0.001 + 2e-6 * len(delays)
        last = max(last, dated_s)


def test_a_device_that_was_restarted_is_dated_anew():
    clock = DeviceClock()
    assert clock.date_s(Reading((), (), (), 5_000_000.0, 100.0)) == pytest.approx(100.0)
    assert clock.date_s(Reading((), (), (), 4.0, 101.0)) == pytest.approx(101.0)
