"""The emulated servo bus against what manuals and measurements say of the real one."""

import os
import termios
from math import radians

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.capability.context import Device
from lbr.errors import InputError
from lbr.simulation.bus_timing import BusTiming, Rhythm
from lbr.simulation.devices.dynamixel import DynamixelFaults
from lbr.simulation.devices.dynamixel.bus import DynamixelBus
from lbr.simulation.devices.dynamixel.dongle import Usb2Ax
from lbr.simulation.devices.dynamixel.packets import Code, Fault, status
from lbr.simulation.devices.dynamixel.servo import OVERLOAD_S, AxServo
from lbr.simulation.faults import changed
from lbr.simulation.measured import ServoFelt
from lbr.simulation.twins import ServoBus, Surroundings, make

STEP = radians(300 / 1023)
NO_DELAY = BusTiming(ping_us=0, read_us=0, write_us=0, write_byte_us=0, interrupt_us=0, usb_us=0)
BARE = {"return_delay": 0, "timing": NO_DELAY, "dongle": None}


def packet(number, code, *parameters):
    body = bytes((number, len(parameters) + 2, code, *parameters))
    return b"\xff\xff" + body + bytes((~sum(body) & 0xFF,))


def read(number, address, count):
    return packet(number, Code.READ, address, count)


def write(number, address, *data):
    return packet(number, Code.WRITE, address, *data)


class Bench:
    """A bus and a clock; `say` waits for whatever comes, and a while longer."""

    def __init__(self, ids=(1, 2), *, return_delay=250, timing=None, dongle=5, **faults):
        self.now = 100.0
        self.heard = []
        self.servos = {number: AxServo(number, return_delay=return_delay) for number in ids}
        self.bus = DynamixelBus(
            self.servos.values(),
            dongle=Usb2Ax(dongle) if dongle else None,
            timing=timing or BusTiming(),
            faults=DynamixelFaults(**faults),
            seed=3,
            on_instruction=lambda instruction, at: self.heard.append((instruction, at)),
        )

    def say(self, data, wait_s=0.2):
        self.now += wait_s
        answer = self.bus.feed(data, self.now)
        return answer + self.bus.poll(self.now + wait_s / 2)

    def timed(self, data):
        """Return the answer, and after how many microseconds the last of it came."""
        self.now += 0.2
        answer, at = self.bus.feed(data, self.now), self.now
        while (due := self.bus.next_due()) is not None:
            answer, at = answer + self.bus.poll(due), due
        return answer, round((at - self.now) * 1e6, 1)

    def fault(self, name, value=True):
        self.bus.faults = changed(self.bus.faults, name, value)

    def words(self, number, address, count):
        data = self.say(read(number, address, count * 2))[5:-1]
        return [data[at] | data[at + 1] << 8 for at in range(0, len(data), 2)]


@pytest.fixture
def bench():
    return Bench()


def moved(bench, number, **felt):
    bench.servos[number].feel(ServoFelt(**felt), 11.1, bench.now)


# Packets.


def test_answers_the_worked_packets():
    bench = Bench(ids=range(1, 19))
    assert bench.say(bytes.fromhex("FFFF 01 02 01 FB")) == bytes.fromhex("FFFF 01 02 00 FC")
    assert bench.say(bytes.fromhex("FFFF 01 04 02 24 06 CE")) == bytes.fromhex("FFFF 01 08 00 0002 0000 0000 F4")
    assert bench.say(bytes.fromhex("FFFF 01 05 03 0C 64 AA DC")) == bytes.fromhex("FFFF 01 02 00 FC")
    assert bench.say(bytes.fromhex("FFFF FE 0E 83 1E 04 01 0002 1E00 02 0002 1E00 0B")) == b""
    assert bench.words(2, 30, 2) == [512, 30]
    asked = bytes.fromhex("FFFF FD 16 84 24 06") + bytes(range(1, 19)) + b"\x93"
    answer = bench.say(asked)
    assert len(answer) == 114
    assert answer[:5] == bytes.fromhex("FFFF FD 6E 00")
    assert answer[5:-1] == bytes.fromhex("0002 0000 0000") * 18


def test_overload_and_heat_are_in_the_error_byte(bench):
    bench.fault("hot", "1")
    bench.fault("overload", 1.0)
    assert bench.say(packet(1, Code.PING)) == bytes.fromhex("FFFF 01 02 24 D8")


@pytest.mark.parametrize(
    ("said", "error"),
    [
        (packet(1, 0x55), Fault.INSTRUCTION),
        (packet(1, Code.ACTION), Fault.INSTRUCTION),
        (packet(1, Code.SYNC_WRITE, 30, 2, 1, 0, 2), Fault.INSTRUCTION),
        (read(1, 36, 6)[:-1] + b"\x00", Fault.CHECKSUM),
        (read(1, 36, 0), Fault.RANGE),
        (read(1, 49, 2), Fault.RANGE),
        (write(1, 36, 0, 2), Fault.RANGE),
        (write(1, 30, 0, 4), Fault.RANGE),
        (write(1, 24, 2), Fault.RANGE),
        (write(1, 10, 1), Fault.RANGE),
        (write(1, 24), Fault.RANGE),
        (write(1, 16, 3), Fault.RANGE),
    ],
)
def test_refuses_with_the_bit_that_says_why(bench, said, error):
    assert bench.say(said) == status(1, error)


def test_a_goal_outside_the_angle_limits_is_not_taken(bench):
    bench.say(write(1, 6, 0, 1, 0, 3))
    assert bench.say(write(1, 30, 255, 0)) == status(1, Fault.ANGLE)
    assert bench.say(write(1, 30, 1, 3)) == status(1, Fault.ANGLE)
    assert bench.say(write(1, 30, 0, 1)) == status(1, 0)
    assert bench.words(1, 30, 1) == [256]


def test_says_as_much_as_its_return_level_allows(bench):
    bench.say(write(1, 16, 1))
    assert bench.say(write(1, 25, 1)) == b""
    assert bench.say(read(1, 25, 1)) == status(1, 0, b"\x01")
    bench.say(write(1, 16, 0))
    assert bench.say(read(1, 25, 1)) == b""
    assert bench.say(packet(1, Code.PING)) == status(1, 0)


def test_what_was_registered_is_done_at_action_and_by_all_at_once(bench):
    for number in (1, 2):
        assert bench.say(packet(number, Code.REG_WRITE, 30, 44, 1)) == status(number, 0)
    assert bench.words(1, 30, 1) == [512]
    assert bench.say(read(1, 44, 1)) == status(1, 0, b"\x01")
    assert bench.say(packet(0xFE, Code.ACTION)) == b""
    assert [bench.words(number, 30, 1) for number in (1, 2)] == [[300], [300]]
    assert bench.say(read(1, 44, 1)) == status(1, 0, b"\x00")


def test_a_broadcast_is_never_answered(bench):
    for said in (packet(0xFE, Code.PING), read(0xFE, 36, 6), write(0xFE, 25, 1), packet(0xFE, Code.FACTORY_RESET)):
        assert bench.say(said) == b""
    assert bench.say(read(1, 25, 1)) == status(1, 0, b"\x01")


def test_locked_it_takes_ram_alone_until_it_is_switched_off(bench):
    bench.say(write(1, 47, 1))
    assert bench.say(write(1, 5, 0)) == status(1, Fault.RANGE)
    assert bench.say(write(1, 48, 40, 0)) == status(1, Fault.RANGE)
    assert bench.say(write(1, 25, 1)) == status(1, 0)
    bench.fault("brown_out")
    bench.fault("brown_out", None)
    assert bench.say(write(1, 5, 0)) == status(1, 0)


def test_eeprom_is_written_without_torque_only(bench):
    bench.say(write(1, 24, 1))
    assert bench.say(write(1, 5, 0)) == status(1, Fault.RANGE)


def test_a_servo_is_deaf_while_it_writes_eeprom(bench):
    assert bench.say(write(1, 5, 0), wait_s=0.004) == status(1, 0)
    assert bench.say(packet(1, Code.PING), wait_s=0.004) == b""
    assert bench.say(packet(1, Code.PING), wait_s=0.004) == status(1, 0)
    assert bench.say(write(1, 6, 0, 0, 255, 3), wait_s=0.004) == status(1, 0)
    assert bench.say(packet(1, Code.PING), wait_s=0.020) == b""
    assert bench.say(packet(1, Code.PING), wait_s=0.008) == status(1, 0)


def test_a_new_number_is_answered_to_at_once(bench):
    assert bench.say(write(1, 3, 7)) == status(1, 0)
    assert bench.say(packet(1, Code.PING)) == b""
    assert bench.say(packet(7, Code.PING)) == status(7, 0)


def test_at_another_rate_it_hears_nothing(bench):
    bench.say(write(1, 4, 34))
    assert bench.say(packet(1, Code.PING)) == b""
    bench.bus.baud = 57_600
    assert bench.say(packet(1, Code.PING)) == status(1, 0)
    assert bench.say(packet(2, Code.PING)) == b""


def test_hunts_for_a_packet_in_noise_and_drops_one_that_stalls(bench):
    assert bench.say(b"\x00\xff\xff\xff\xff" + packet(1, Code.PING)) == status(1, 0)
    half = packet(1, Code.PING)
    assert bench.say(half[:4], wait_s=0.02) == b""
    assert bench.say(half[4:], wait_s=0.02) == status(1, 0)
    assert bench.say(half[:4]) == b""
    assert bench.say(half[4:]) == b""
    assert bench.say(half) == status(1, 0)


def test_a_packet_longer_than_its_buffer_is_not_heard():
    bench = Bench(ids=range(1, 40), dongle=4)
    goals = [part for number in range(1, 34) for part in (number, 44, 1, 30, 0)]
    bench.say(packet(0xFE, Code.SYNC_WRITE, 30, 4, *goals))
    assert bench.words(1, 30, 1) == [512]
    bench.say(packet(0xFE, Code.SYNC_WRITE, 30, 4, *goals[:90]))
    assert bench.words(1, 30, 1) == [300]


# Time.


def test_a_block_read_takes_its_bytes_and_nothing_else_if_nothing_else_is_set():
    assert Bench(**BARE).timed(read(1, 36, 6)) == (status(1, 0, bytes((0, 2, 0, 0, 0, 0))), 200.0)


@pytest.mark.parametrize(
    ("parts", "delay", "said", "us"),
    [
        ({"read_us": 22.0}, 0, read(1, 36, 6), 222.0),
        ({"read_us": 22.0}, 125, read(1, 36, 6), 450.0),
        ({"read_us": 22.0}, 250, read(1, 36, 6), 700.0),
        ({"read_us": 22.0, "delay_adds": True}, 250, read(1, 36, 6), 722.0),
        ({"ping_us": 18.0}, 0, packet(1, Code.PING), 138.0),
        ({"write_us": 24.0, "write_byte_us": 6.0}, 0, write(1, 30, 0, 2), 186.0),
        ({"usb_us": 1100.0}, 0, read(1, 36, 6), 1300.0),
    ],
)
def test_each_part_of_the_time_counts(parts, delay, said, us):
    timing = BusTiming(**{**{name: getattr(NO_DELAY, name) for name in NO_DELAY.__struct_fields__}, **parts})
    assert Bench(dongle=None, return_delay=delay, timing=timing).timed(said)[1] == us


@pytest.mark.parametrize(
    ("begun_us", "work_us", "done_us"),
    [(0, 10, 140), (129, 10, 140), (130, 10, 140), (500, 500, 1000), (500, 501, 1131), (990, 1890, 3270)],
)
def test_interrupts_hold_a_servo_up(begun_us, work_us, done_us):
    done = BusTiming().finished(begun_us * 1e-6, work_us * 1e-6 - 1e-12, Rhythm())
    assert done * 1e6 == pytest.approx(done_us, abs=0.01)


def test_jitter_averages_to_what_was_measured():
    timing = BusTiming()
    late = [timing.finished(at * 1e-5, 142e-6, Rhythm()) - at * 1e-5 - 142e-6 for at in range(100)]
    assert sum(late) / len(late) * 1e6 == pytest.approx(27, abs=1.5)
    assert max(late) * 1e6 <= 130.01


def test_a_dongle_holds_short_answers_back_until_told_not_to():
    bench = Bench(**{**BARE, "dongle": 5})
    assert bench.timed(read(1, 36, 6))[1] == 280.0
    assert bench.say(write(0xFD, 5, 0)) == status(0xFD, 0)
    assert bench.timed(read(1, 36, 6))[1] == 200.0


def test_a_slower_line_takes_longer():
    bench = Bench(**BARE)
    bench.say(write(1, 4, 3))
    bench.bus.baud = 500_000
    assert bench.timed(read(1, 36, 6))[1] == 400.0


def test_reading_synchronously_takes_the_line_s_time_and_a_millisecond_for_the_silent():
    bench = Bench(ids=range(1, 19), **{**BARE, "dongle": 5}, silent=(3, 9))
    answer, us = bench.timed(packet(0xFD, Code.SYNC_READ, 36, 6, *range(1, 19)))
    assert us == 16 * 200 + 2 * (80 + 1000) + 260 + 80  # silent ones, the request, and the end held back
    states = [answer[at : at + 6] for at in range(5, 113, 6)]
    assert [number for number, state in enumerate(states, 1) if state == b"\xff" * 6] == [3, 9]


def test_two_who_talk_at_once_are_both_lost():
    bench = Bench(**BARE)
    bench.bus.feed(read(1, 36, 6), bench.now)
    assert bench.bus.feed(read(2, 36, 6), bench.now + 0.0001) == b""
    assert bench.bus.next_due() is None
    assert bench.say(packet(2, Code.PING)) == status(2, 0)


def test_packets_without_an_answer_may_follow_each_other():
    bench = Bench(**BARE)
    assert bench.timed(packet(0xFE, Code.SYNC_WRITE, 30, 2, 1, 0, 2) + read(1, 36, 6))[1] == 310.0
    assert [round((at - bench.now) * 1e6) for _, at in bench.heard] == [110, 190]


# The dongle.


def test_the_dongle_is_a_servo_of_its_own():
    bench = Bench(dongle=4)
    assert bench.say(read(0xFD, 0, 4)) == status(0xFD, 0, bytes((0x01, 0x42, 4, 0xFD)))
    assert bench.say(packet(0xFD, Code.PING)) == b""
    newer = Bench(dongle=5)
    assert newer.say(packet(0xFD, Code.PING)) == status(0xFD, 0)
    assert newer.say(read(0xFD, 2, 5)) == status(0xFD, 0, bytes((5, 0xFD, 50, 4, 100)))
    assert Bench(dongle=None).say(read(0xFD, 0, 4)) == b""


@pytest.mark.parametrize(
    ("firmware", "each", "count", "answered"),
    [(4, 6, 18, True), (4, 7, 2, False), (4, 6, 30, True), (4, 6, 31, False), (5, 8, 18, True), (5, 8, 29, False)],
)
def test_reading_synchronously_has_limits(firmware, each, count, answered):
    bench = Bench(ids=range(1, 40), dongle=firmware)
    answer = bench.say(packet(0xFD, Code.SYNC_READ, 36, each, *range(1, count + 1)))
    assert (len(answer) == 6 + each * count) is answered
    assert answered or answer == (b"" if firmware == 4 else status(0xFD, Fault.RANGE))


def test_version_5_comments_on_long_broadcasts_and_forwards_them():
    goals = [part for number in range(1, 19) for part in (number, 44, 1, 30, 0, 255, 3)]
    bench = Bench(ids=range(1, 19))
    assert bench.say(packet(0xFE, Code.SYNC_WRITE, 30, 6, *goals)) == bytes.fromhex("FFFF FD 02 08 F8")
    assert bench.words(18, 30, 1) == [300]
    assert Bench(ids=range(1, 19), dongle=4).say(packet(0xFE, Code.SYNC_WRITE, 30, 6, *goals)) == b""


# The motor.


def test_limp_until_it_is_switched_on_and_then_it_goes_to_its_goal(bench):
    bench.say(write(1, 30, 88, 2, 50, 0))
    assert bench.words(1, 36, 1) == [512]
    bench.say(write(1, 24, 1))
    position, speed, load = bench.words(1, 36, 3)
    assert 512 < position < 600
    assert speed == 50
    assert 0 < load < 1024
    assert bench.say(read(1, 46, 1)) == status(1, 0, b"\x01")
    bench.now += 2.0
    assert bench.words(1, 36, 3) == [600, 0, 0]
    assert bench.say(read(1, 46, 1)) == status(1, 0, b"\x00")


def test_some_are_switched_on_by_a_goal(bench):
    bench.say(write(1, 30, 0, 1))
    assert bench.servos[1].drive().torque == 0.0
    eager = DynamixelBus([AxServo(1, goal_switches_on=True)])
    eager.feed(write(1, 32, 100, 0), bench.now)
    assert eager.servos[0].drive().torque == 0.0
    eager.feed(write(1, 30, 0, 1), bench.now + 1.0)
    assert eager.servos[0].drive().torque == 1.0


def test_clockwise_is_the_eleventh_bit(bench):
    bench.say(write(1, 30, 0, 0, 50, 0))
    bench.say(write(1, 24, 1))
    _, speed, load = bench.words(1, 36, 3)
    assert speed == 1024 + 50
    assert load > 1024


def test_its_registers_say_what_its_motor_does(bench):
    servo = bench.servos[1]
    assert servo.drive().torque == 0.0
    bench.say(write(1, 24, 1, 0, 3, 5, 16, 130, 12, 2, 0, 0, 255, 1))
    drive = servo.drive()
    assert drive is servo.drive()
    assert drive.goal_rad == pytest.approx(12 * STEP)
    assert drive.speed_rps is None
    assert drive.torque == pytest.approx(511 / 1023)
    assert drive.margins_rad == pytest.approx((3 * STEP, 5 * STEP))
    assert drive.slopes_rad == pytest.approx((16 * STEP, 128 * STEP))


def test_a_world_moves_it(bench):
    moved(bench, 1, position_rad=-100 * STEP, speed_rps=-radians(66.6), load=-0.5)
    assert bench.words(1, 36, 3) == [412, 1024 + 100, 1024 + 512]
    assert bench.words(2, 36, 1) == [512]
    moved(bench, 1, position_rad=9.0)
    assert bench.words(1, 36, 1) == [1023]


def test_a_stall_ends_in_overload_and_no_torque_until_a_torque_limit_is_written(bench):
    bench.say(write(1, 24, 1))
    for _ in range(3):
        moved(bench, 1, position_rad=0.0, load=-1.0)
        bench.now += OVERLOAD_S / 1.5
    assert bench.say(packet(1, Code.PING)) == status(1, Fault.OVERLOAD)
    assert bench.words(1, 34, 1) == [0]
    assert bench.servos[1].drive().torque == 0.0
    moved(bench, 1, position_rad=0.0)
    assert bench.say(write(1, 34, 255, 3)) == status(1, 0)
    assert bench.servos[1].drive().torque == 1.0


@pytest.mark.parametrize(("name", "bit"), [("hot", Fault.HEAT), ("overload", Fault.OVERLOAD)])
def test_an_alarm_that_lasts_lets_no_torque_come_back(bench, name, bit):
    bench.say(write(1, 24, 1))
    bench.fault(name, "1")
    assert bench.say(write(1, 34, 255, 3)) == status(1, bit)
    assert bench.servos[1].drive().torque == 0.0
    bench.fault(name, None)
    assert bench.say(write(1, 34, 255, 3)) == status(1, 0)
    assert bench.servos[1].drive().torque == 1.0


def test_an_alarm_that_is_not_for_shutdown_is_only_told(bench):
    bench.say(write(1, 18, 0))
    bench.fault("hot", "1")
    assert bench.say(write(1, 24, 1)) == status(1, Fault.HEAT)
    assert bench.servos[1].drive().torque == 1.0


def test_full_load_makes_it_warm(bench):
    for _ in range(100):
        bench.now += 1.0
        moved(bench, 1, position_rad=0.0, load=1.0)
    assert bench.say(read(1, 43, 1))[5] in range(40, 60)
    assert bench.say(read(2, 43, 1))[5] == 30


def test_a_voltage_outside_its_limits_is_told(bench):
    bench.servos[1].feel(ServoFelt(position_rad=0.0), 5.5, bench.now)
    assert bench.say(read(1, 42, 1)) == status(1, Fault.VOLTAGE, b"\x37")


# Faults.


@pytest.mark.parametrize(
    "faults", [{"silent": (1,)}, {"other_baud": (1,)}, {"unpowered": (1,)}, {"brown_out": True}, {"drop": 1.0}]
)
def test_no_answer_comes(faults):
    bench = Bench(**faults)
    assert bench.say(write(1, 25, 1)) == b""
    bench.bus.faults = DynamixelFaults()
    obeyed = b"\x01" if "silent" in faults or "drop" in faults else b"\x00"
    assert bench.say(read(1, 25, 1)) == status(1, 0, obeyed)


def test_a_servo_that_lost_its_supply_is_limp_and_has_forgotten_its_ram(bench):
    bench.say(write(1, 5, 0))
    bench.say(write(1, 24, 1))
    moved(bench, 1, position_rad=10 * STEP)
    bench.fault("unpowered", "1")
    assert bench.servos[1].drive().torque == 0.0
    bench.fault("unpowered", None)
    assert bench.servos[1].drive().torque == 0.0
    assert bench.words(1, 30, 1) == [522]
    assert bench.say(read(1, 5, 1)) == status(1, 0, b"\x00")


@pytest.mark.parametrize(
    ("faults", "seen"),
    [
        ({"bit_flip": 1.0}, lambda answer, good: answer != good and len(answer) == len(good)),
        ({"garbage": 1.0}, lambda answer, good: answer.endswith(good) and len(answer) > len(good)),
        ({"stray": 1.0}, lambda answer, good: answer == bytes.fromhex("FFFFFD0208F8") + good),
        ({"half": 1.0}, lambda answer, good: len(answer) < len(good) and good.startswith(answer)),
        ({"pieces": 1.0}, lambda answer, good: answer == good),
        ({"late": 1.0}, lambda answer, good: answer == good),
        ({"echo": True}, lambda answer, good: answer == packet(1, Code.PING) + good),
        ({"duplicate": (1,)}, lambda answer, good: answer != good),
        ({"wrong_model": (1,)}, lambda answer, good: answer == good),
    ],
)
def test_an_answer_is_spoilt(faults, seen):
    assert seen(Bench(**faults).say(packet(1, Code.PING)), status(1, 0))


def test_a_late_answer_comes_after_whoever_asked_has_given_up():
    bench = Bench(late=1.0, **BARE)
    assert bench.timed(read(1, 36, 6))[1] == 12_200.0


def test_an_answer_in_pieces_has_a_pause():
    bench = Bench(pieces=1.0, **BARE)
    assert bench.timed(read(1, 36, 6))[1] == 700.0


def test_a_wrong_model_says_so():
    assert Bench(wrong_model=(1,)).words(1, 0, 1) == [18]
    assert Bench(wrong_model=(2,)).words(1, 0, 1) == [12]


def test_babbling_never_ends():
    bench = Bench(babbling=True)
    said = []
    for _ in range(20):
        bench.now = bench.bus.next_due() or bench.now
        said.append(bench.bus.poll(bench.now))
    assert sum(bool(data) for data in said) >= 19


@given(st.lists(st.tuples(st.binary(max_size=160), st.floats(0, 0.2)), max_size=8), st.sampled_from([None, 4, 5]))
def test_no_bytes_ever_raise(pieces, dongle):
    bench = Bench(dongle=dongle)
    for data, wait_s in pieces:
        bench.say(data, wait_s)
    for servo in bench.servos.values():
        servo.drive()


@given(
    st.lists(
        st.tuples(
            st.sampled_from([1, 2, 0xFD, 0xFE]),
            st.sampled_from([*Code, 0x92]),
            st.lists(st.integers(0, 255), max_size=12),
        ),
        max_size=12,
    )
)
def test_no_packet_ever_raises_nor_moves_a_limp_servo(packets):
    bench = Bench()
    for number, code, parameters in packets:
        answer = bench.say(packet(number, code, *parameters))
        assert not answer or answer.startswith(b"\xff\xff")
        for servo in bench.servos.values():
            assert servo.drive().torque <= 1.0


# On its port.


@pytest.fixture
def twin(tmp_path):
    device = Device(name="servo_bus", type="dynamixel", address=str(tmp_path / "bus"), settings={"usb2ax": None})
    twin = make(device, Surroundings(seed=1, now=0.0))
    twin.service(100.0)
    yield twin
    twin.close()


def test_serves_a_tty_at_the_rate_that_the_host_sets(twin):
    host = os.open(twin.port.path, os.O_RDWR | os.O_NOCTTY)
    try:
        for rate, answer in ((termios.B1000000, status(1, 0)), (termios.B57600, b"")):
            attributes = termios.tcgetattr(host)
            attributes[4] = attributes[5] = rate
            termios.tcsetattr(host, termios.TCSANOW, attributes)
            os.write(host, packet(1, Code.PING))
            assert twin.watched() is not None
            twin.service(101.0 + rate)
            assert twin.bus.poll(102.0 + rate) == answer
    finally:
        os.close(host)


def test_moves_a_body_and_feels_it(twin):
    assert isinstance(twin, ServoBus)
    assert set(twin.drives(1.0)) == set(range(1, 19))
    twin.feel_servos({4: ServoFelt(position_rad=0.1)}, 11.0, 1.0)
    assert twin.bus.servos[3].felt.position_rad == 0.1


def test_a_fault_of_no_servo_is_refused(twin):
    with pytest.raises(InputError, match="fault 'silent'"):
        twin.fault("silent", "300")
    with pytest.raises(InputError, match="fault 'silent'"):
        twin.fault("silent", "left")
    assert twin.fault("silent", "3, 4")["silent"] == (3, 4)
    assert twin.fault("silent", ("5",))["silent"] == (5,)
    assert twin.fault("silent", 6.0)["silent"] == (6,)
