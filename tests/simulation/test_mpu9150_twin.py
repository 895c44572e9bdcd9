"""The emulated MPU-9150 and its AK8975 against their datasheets, as registers and on the socket."""

import contextlib
import math
import socket
import struct
import threading

import pytest

from lbr.capability.context import Device
from lbr.errors import DeviceError
from lbr.simulation.devices.mpu9150 import Mpu9150Faults
from lbr.simulation.devices.mpu9150.twin import Mpu9150, Mpu9150Twin
from lbr.simulation.i2c import Message, transfer
from lbr.simulation.measured import ImuReading
from tests.simulation.world_bench import AROUND
from tests.support.waiting import HANG_S

FELT = ImuReading(
    gyro_rps=(0.1, -0.2, 0.3), accel_mps2=(1.0, -2.0, 9.80665), mag_ut=(20.0, -5.0, -40.0), temperature_c=31.0
)
IMU, COMPASS = 0x68, 0x0C


class Bus:
    """A chip on a bus and a clock that stands still until told."""

    def __init__(self, **faults):
        self.now = 100.0
        self.chip = Mpu9150(faults=Mpu9150Faults(**faults), seed=3)
        self.chip.feel(FELT, self.now)

    def transfer(self, *messages):
        return transfer(self.chip.on_bus(IMU), messages, self.now)

    def write(self, register, *values, address=IMU):
        assert self.transfer(Message(address, write=bytes((register, *values)))) == b"\0"

    def read(self, register, count=1, address=IMU):
        answer = self.transfer(Message(address, write=bytes((register,))), Message(address, read=count))
        assert answer[0] == 0
        return answer[1:]

    def wait(self, seconds):
        self.now += seconds
        self.chip.feel(self.chip._felt, self.now)

    def wake(self, *, divider=9, low_pass=3):
        self.write(0x6B, 0x01)
        self.write(0x19, divider)
        self.write(0x1A, low_pass)
        self.wait(0.05)

    def bypass(self):
        self.write(0x6A, 0x00)
        self.write(0x37, 0x02)

    def measure_field(self):
        self.write(0x0A, 0x01, address=COMPASS)
        self.wait(0.009)
        assert self.read(0x02, address=COMPASS) == b"\x01"
        return struct.unpack("<3hB", self.read(0x03, 7, address=COMPASS))


@pytest.fixture
def bus():
    return Bus()


def motion(bus):
    return struct.unpack(">7h", bus.read(0x3B, 14))


def test_it_wakes_up_asleep_and_everything_is_zero_but_its_name(bus):
    registers = bus.read(0x00, 0x74)
    assert registers[0x6B] == 0x40
    assert sum(registers) == 0x40
    assert bus.read(0x75) == b"\x68"


def test_asleep_nothing_is_measured(bus):
    bus.wait(1.0)
    assert motion(bus) == (0,) * 7


def test_awake_it_measures_big_endian_in_its_ranges_units(bus):
    bus.wake()
    accel_x, accel_y, accel_z, warmth, *turns = motion(bus)
    assert (accel_x, accel_y, accel_z) == (round(16384 / 9.80665), round(-2 * 16384 / 9.80665), 16384)
    assert warmth / 340 + 35 == pytest.approx(31.0, abs=0.01)
    assert [turn / 131 for turn in turns] == pytest.approx([math.degrees(v) for v in FELT.gyro_rps], abs=0.01)


@pytest.mark.parametrize("code", range(4))
def test_ranges_scale_and_saturate(bus, code):
    bus.wake()
    bus.write(0x1B, code << 3)
    bus.write(0x1C, code << 3)
    bus.wait(0.05)
    values = motion(bus)
    assert values[2] == 16384 >> code
    assert values[6] == pytest.approx(math.degrees(0.3) * (131, 65.5, 32.8, 16.4)[code], abs=0.6)
    bus.chip.feel(ImuReading(gyro_rps=(100.0, -100.0, 0.0), accel_mps2=(0.0, 500.0, -500.0)), bus.now)
    bus.wait(0.05)
    assert motion(bus)[1:3] == (32767, -32768)
    assert motion(bus)[4:6] == (32767, -32768)


def test_the_first_sample_takes_its_time_after_waking(bus):
    bus.write(0x6B, 0x01)
    bus.wait(0.029)
    assert motion(bus) == (0,) * 7
    bus.wait(0.002)
    assert motion(bus)[2] == 16384


def test_back_asleep_the_last_sample_stays(bus):
    bus.wake()
    before = motion(bus)
    bus.write(0x6B, 0x40)
    bus.chip.feel(ImuReading(gyro_rps=(3.0, 3.0, 3.0)), bus.now)
    bus.wait(1.0)
    assert motion(bus) == before


def test_data_are_new_at_the_rate_that_was_set_and_ready_says_so(bus):
    bus.wake(divider=99, low_pass=3)  # 10 Hz
    bus.wait(0.06)
    news = 0
    for step in range(1000):
        bus.chip.feel(ImuReading(accel_mps2=(step / 1000, 0.0, 9.8)), bus.now)
        bus.now += 0.001
        news += bus.read(0x3A)[0] & 1
    assert news in {10, 11}


def test_without_the_low_pass_it_is_eight_times_as_fast(bus):
    bus.wake(divider=79, low_pass=0)  # 100 Hz
    bus.read(0x3A)
    bus.wait(0.0105)
    assert bus.read(0x3A) == b"\x01"
    assert bus.read(0x3A) == b"\x00"


def test_a_burst_is_of_one_instant_and_single_reads_are_not(bus):
    bus.wake(divider=0)
    first = motion(bus)
    high = bus.read(0x3B)
    bus.chip.feel(ImuReading(accel_mps2=(-1.0, 0.0, 0.0)), bus.now)
    assert motion(bus) == first, "what is felt now shows in the next sample"
    bus.wait(0.002)
    low = bus.read(0x3C)
    assert struct.unpack(">h", high + low)[0] not in {first[0], motion(bus)[0]}


def test_a_reset_puts_all_back_and_is_over_after_a_while(bus):
    bus.wake()
    bus.bypass()
    bus.write(0x6B, 0x80)
    assert bus.read(0x6B) == b"\xc0"
    bus.write(0x6B, 0x01)
    assert bus.read(0x6B) == b"\xc0", "too early"
    bus.wait(0.021)
    assert bus.read(0x6B) == b"\x40"
    assert bus.read(0x37) == b"\x00"
    bus.wake()
    assert motion(bus)[2] == 16384


def test_what_can_only_be_read_cannot_be_written(bus):
    for register in (0x75, 0x3B, 0x60, 0x3A):
        bus.write(register, 0x55)
    assert bus.read(0x75) == b"\x68"
    assert bus.read(0x3B) == bus.read(0x60) == bus.read(0x3A) == b"\x00"


@pytest.mark.parametrize(("control", "bypass", "there"), [(0, 2, True), (0x20, 2, False), (0, 0, False)])
def test_the_compass_answers_through_the_bypass_only(bus, control, bypass, there):
    bus.write(0x6A, control)
    bus.write(0x37, bypass)
    answer = bus.transfer(Message(COMPASS, write=b"\x00"), Message(COMPASS, read=1))
    assert answer == (b"\0\x48" if there else b"\x79")


def test_nobody_else_is_on_the_bus(bus):
    assert bus.transfer(Message(0x69, read=1)) == b"\x79"


def test_the_fuses_can_be_read_in_their_mode_only(bus):
    bus.bypass()
    assert bus.read(0x10, 3, address=COMPASS) == b"\0\0\0"
    bus.write(0x0A, 0x0F, address=COMPASS)
    assert tuple(bus.read(0x10, 3, address=COMPASS)) == (176, 178, 166)
    bus.write(0x0A, 0x00, address=COMPASS)
    assert bus.read(0x10, 3, address=COMPASS) == b"\0\0\0"


def test_a_field_comes_back_by_the_fuses_along_the_compass_own_axes(bus):
    bus.bypass()
    x, y, z, status = bus.measure_field()
    fields = [raw * 0.3 * ((fuse - 128) * 0.5 / 128 + 1) for raw, fuse in zip((x, y, z), (176, 178, 166), strict=True)]
    assert fields == pytest.approx([-5.0, 20.0, 40.0], abs=0.2)
    assert status == 0


def test_a_measurement_takes_its_time_then_the_compass_is_off(bus):
    bus.bypass()
    bus.write(0x0A, 0x01, address=COMPASS)
    bus.now += 0.0072
    assert bus.read(0x02, address=COMPASS) == b"\0"
    assert bus.read(0x0A, address=COMPASS) == b"\x01"
    bus.now += 0.0002
    assert bus.read(0x02, address=COMPASS) == b"\x01"
    assert bus.read(0x0A, address=COMPASS) == b"\x00"


@pytest.mark.parametrize("register", [0x03, 0x08, 0x09])
def test_reading_data_or_the_second_status_ends_ready(bus, register):
    bus.bypass()
    bus.write(0x0A, 0x01, address=COMPASS)
    bus.wait(0.008)
    assert bus.read(0x02, address=COMPASS) == b"\x01"
    bus.read(register, address=COMPASS)
    assert bus.read(0x02, address=COMPASS) == b"\x00"


def test_a_mode_is_changed_only_from_off_and_not_at_once(bus):
    bus.bypass()
    bus.write(0x0A, 0x0F, address=COMPASS)
    bus.write(0x0A, 0x01, address=COMPASS)
    assert bus.read(0x0A, address=COMPASS) == b"\x0f", "not from another mode"
    bus.write(0x0A, 0x00, address=COMPASS)
    bus.now += 0.00005
    bus.write(0x0A, 0x01, address=COMPASS)
    assert bus.read(0x0A, address=COMPASS) == b"\x00", "not within 100 us"
    bus.now += 0.00006
    bus.write(0x0A, 0x01, address=COMPASS)
    assert bus.read(0x0A, address=COMPASS) == b"\x01"


def test_a_field_too_strong_saturates_and_says_so(bus):
    bus.bypass()
    bus.chip.feel(ImuReading(mag_ut=(-1500.0, 1500.0, 0.0)), bus.now)
    assert bus.measure_field() == (4095, -4096, 0, 0x08)


def test_the_self_test_is_a_field_of_its_own(bus):
    bus.bypass()
    bus.write(0x0C, 0x40, address=COMPASS)
    bus.write(0x0A, 0x08, address=COMPASS)
    bus.wait(0.008)
    x, y, z = struct.unpack("<3h", bus.read(0x03, 6, address=COMPASS))
    assert abs(x) <= 100
    assert abs(y) <= 100
    assert -1000 <= z <= -300


def test_frozen_it_is_ready_with_the_same_for_ever(bus):
    bus.wake()
    bus.bypass()
    before, field = motion(bus), bus.measure_field()
    bus.chip.faults = Mpu9150Faults(frozen=True)
    bus.read(0x3A)
    bus.chip.feel(ImuReading(), bus.now)
    bus.wait(0.1)
    assert bus.read(0x3A) == b"\x01"
    assert motion(bus) == before
    assert bus.measure_field() == field


def test_jumps_and_noise_spoil_samples():
    bus = Bus(jump=1.0, noise=10.0)
    bus.wake()
    first = motion(bus)
    bus.wait(0.05)
    second = motion(bus)
    assert abs(abs(first[6] / 131) - math.degrees(4.0)) < 40
    assert all(a != b for a, b in zip(first[:3], second[:3], strict=True))


def test_the_compass_can_be_gone_or_say_overflow():
    bus = Bus(no_compass=True)
    bus.bypass()
    assert bus.transfer(Message(COMPASS, read=1)) == b"\x79"
    bus.chip.faults = Mpu9150Faults(overflow=True)
    assert bus.measure_field()[3] == 0x08


def test_after_a_brown_out_it_sleeps_with_nothing_set(bus):
    bus.wake()
    bus.bypass()
    bus.chip.faults = Mpu9150Faults(brown_out=True)
    assert bus.transfer(Message(IMU, read=1)) == b"\x79"
    bus.chip.faults = Mpu9150Faults()
    bus.wait(0.1)
    assert bus.read(0x6B) == b"\x40"
    assert motion(bus) == (0,) * 7


# On the socket.


class Wire:
    """A twin served by a thread, as the world serves it."""

    def __init__(self, folder, **settings):
        self.path = folder / "imu"
        device = Device("imu", "mpu9150", f"unix:{self.path}", settings)
        self.twin = Mpu9150Twin(device, AROUND)
        self.over = threading.Event()
        self.rounds = 0
        self.twin.service(0.0)
        self.thread = threading.Thread(target=self._serve)
        self.thread.start()

    def _serve(self):
        while not self.over.wait(0.0005):
            self.rounds += 1
            self.twin.service(self.rounds / 1000)

    def connect(self):
        client = socket.socket(socket.AF_UNIX)
        client.settimeout(HANG_S)
        client.connect(str(self.path))
        return client

    def close(self):
        self.over.set()
        self.thread.join()
        self.twin.port.unplug()


@pytest.fixture
def wire(tmp_path):
    made = Wire(tmp_path)
    yield made
    made.close()


WHO_AM_I = b"\x02\x68\x00\x01\x00\x75\x68\x01\x01\x00"


def test_clients_are_answered_each_on_their_own_connection(wire):
    with wire.connect() as one, wire.connect() as two:
        for client in (one, two, one):
            for byte in WHO_AM_I:
                client.send(bytes((byte,)))
            assert client.recv(10) == b"\0\x68"


def test_a_client_that_talks_nonsense_is_cut_off(wire):
    with wire.connect() as client:
        client.send(b"\xff")
        assert client.recv(10) == b""
    with wire.connect() as client:
        client.send(WHO_AM_I)
        assert client.recv(10) == b"\0\x68"


@pytest.mark.parametrize(
    ("fault", "answer"), [("nak", b"\x79"), ("all_ones", b"\0\xff"), ("brown_out", b"\x79"), ("half", None)]
)
def test_a_faulty_bus_answers_accordingly(wire, fault, answer):
    wire.twin.fault(fault, True)
    with wire.connect() as client:
        client.send(WHO_AM_I)
        if answer:
            assert client.recv(10) == answer
            return
        client.settimeout(0.1)
        with contextlib.suppress(TimeoutError):
            assert len(client.recv(10)) < 2


def test_a_silent_bus_swallows_what_it_is_asked(wire):
    wire.twin.fault("silent", True)
    with wire.connect() as client:
        client.settimeout(0.1)
        client.send(WHO_AM_I)
        with pytest.raises(TimeoutError):
            client.recv(10)
    wire.twin.fault("silent", None)
    with wire.connect() as client:
        client.send(WHO_AM_I)
        assert client.recv(10) == b"\0\x68"


def test_a_file_in_its_place_is_never_replaced(tmp_path):
    (tmp_path / "imu").write_text("precious")
    twin = Mpu9150Twin(Device("imu", "mpu9150", str(tmp_path / "imu"), {}), AROUND)
    with pytest.raises(DeviceError, match="something else is there"):
        twin.service(0.0)
