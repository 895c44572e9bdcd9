"""The emulated UXA-90 against what is known of the real one's line."""

import termios
from math import radians
from time import monotonic

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.capability.context import Device
from lbr.errors import InputError
from lbr.robots.uxa90.twin import Uxa90Row, packets
from lbr.robots.uxa90.twin.board import MainBoard
from lbr.robots.uxa90.twin.firmware import Frame, Programme, shipped
from lbr.robots.uxa90.twin.packets import GAP_S, Packet, Reader, framed
from lbr.simulation.faults import changed
from lbr.simulation.measured import ImuReading, Sensed, ServoFelt
from lbr.simulation.twins import ServoBus, Surroundings, make
from tests.support.waiting import HANG_S

PREAMBLE = "FFFFAA55AA5537BA "
CONTROL = PREAMBLE + "10 00 00000001 01 01"
CONTROLLED = PREAMBLE + "10 04 00000001 01 01"
STAND = PREAMBLE + "14 00 00000001 07 07"
NO_PROGRAMME = PREAMBLE + "14 00 00000001 0F 0F"
BRAKE = "FF DF 20 7F"

ZEROS = {str(number): 127 for number in range(25)} | {"4": 48, "5": 206}
SAT = {"4": 150, "5": 104}
PROGRAMMES = {
    "7": Programme(frames=(Frame(duration_s=2, counts=SAT), Frame(duration_s=4, counts=ZEROS, smooth=True))),
    "21": Programme(frames=(Frame(duration_s=3, counts=SAT),), limp=True),
}
STEADY = {"reply_ms": 1.0, "jitter_ms": 0.0, "programmes": PROGRAMMES}


def hexed(data):
    return bytes.fromhex(data)


def operate(mode, number, second):
    first = mode << 5 | number
    return bytes((0xFF, first, second, (first ^ second) & 0x7F))


def move(number, counts, level=0):
    return operate(level, number, counts)


def read(number):
    return operate(5, number, 0)


def configure(number, command, first, second):
    inner = bytes((0xE0 | number, command, first, second))
    total = 0
    for byte in inner:
        total ^= byte
    return b"\xff" + inner + bytes((total & 0x7F,))


class Bench:
    """A main board and a clock; `say` waits for whatever comes."""

    def __init__(self, *, controlled=True, **settings):
        self.now = 100.0
        self.board = MainBoard(Uxa90Row(**(STEADY | settings)), seed=3)
        if controlled:
            self.say(CONTROL)

    def say(self, data, wait_s=0.2):
        return b"".join(said for said, _ in self.timed(data, wait_s))

    def timed(self, data=b"", wait_s=0.2):
        """Return what came, and after how many milliseconds."""
        begun, until = self.now, self.now + wait_s
        came = [(self.board.feed(hexed(data) if isinstance(data, str) else data, begun), 0.0)]
        while (due := self.board.next_due()) is not None and due <= until:
            came.append((self.board.poll(due), round((due - begun) * 1e3, 2)))
        self.now = until
        self.board.poll(until)
        return [(said, at) for said, at in came if said]

    def fault(self, name, value=True):
        self.board.faults = changed(self.board.faults, name, value)

    def position(self, number):
        return self.say(read(number))[1]


@pytest.fixture
def bench():
    return Bench()


# Frames and modes.


def test_answers_the_captured_frames():
    bench = Bench(controlled=False)
    assert bench.say(PREAMBLE + "12 01 00000001 01 01") == hexed(PREAMBLE + "12 01 00000002 C900 C9")
    serial = bench.say(PREAMBLE + "0C 01 00000001 01 01")
    assert serial == hexed(PREAMBLE + "0C 04 0000000D") + b"6012000010005" + b"\x31"
    zeros = bench.say(PREAMBLE + "0B 01 00000001 01 01")
    assert len(zeros) == 46
    assert zeros[14:20] == bytes((130, 129, 129, 131, 38, 214))
    assert zeros[-1] == 0xF4


def test_the_inertial_unit_says_what_the_body_feels_and_its_sum_may_be_wrong():
    bench = Bench(controlled=False, imu_lsb_per_g=256.0)
    bench.board.imu = ImuReading(accel_mps2=(0.0, -9.80665 / 2, 9.80665))
    asked = PREAMBLE + "1A 01 00000001 01 01"
    said = bench.say(asked)
    assert said == framed(0x1A, 4, hexed("0000 FF80 0100"))
    broken = Bench(controlled=False, imu_sum=False)
    assert len(broken.say(asked)) == 21
    assert broken.say(asked)[-1] != said[-1]


def test_says_nothing_to_servo_packets_before_it_is_controlled():
    bench = Bench(controlled=False)
    assert bench.say(read(0) + move(3, 90)) == b""
    assert bench.board.drives(bench.now)[3].torque == 0
    assert bench.say(CONTROL) == hexed(CONTROLLED)
    assert len(bench.say(read(0))) == 2


def test_passes_packets_on_only_once_control_is_taken():
    bench = Bench(controlled=False, settle_ms=50.0)
    assert bench.say(hexed(CONTROL) + read(0)) == hexed(CONTROLLED)


def test_taking_control_moves_nothing(bench):
    assert all(drive.torque == 0 for drive in bench.board.drives(bench.now).values())


def test_a_frame_with_a_wrong_sum_is_not_obeyed():
    bench = Bench(controlled=False)
    assert bench.say(PREAMBLE + "10 00 00000001 01 02") == b""
    assert bench.board.mode == "normal"


def test_control_is_given_back_on_demand(bench):
    assert bench.say("FF E0 FB 01 00 1A") == b""
    assert bench.board.mode == "normal"
    assert bench.say(read(0)) == b""


def test_hears_nothing_at_another_rate(bench):
    assert bench.board.feed(read(0), bench.now, 921_600) == b""
    bench.now += 1
    assert bench.board.poll(bench.now) == b""


def test_the_last_button_is_remembered():
    bench = Bench(controlled=False)
    bench.say(NO_PROGRAMME)
    assert bench.say(PREAMBLE + "19 01 00000001 01 01") == framed(0x19, 4, b"\x0f\x00")


# Servos.


def test_the_worked_moves_are_obeyed(bench):
    assert len(bench.say("FF 97 64 73", 5.0)) == 2
    assert bench.position(23) == 100
    bench.say("FF 17 14 03 FF 18 78 60", 5.0)
    assert (bench.position(23), bench.position(24)) == (20, 120)


def test_a_servo_answers_within_milliseconds_in_the_order_of_the_packets(bench):
    came = bench.timed(b"".join(read(number) for number in (4, 5, 22)))
    byte_ms = 10 / 115.2
    first = 4 * byte_ms + 1.0 + 2 * byte_ms
    assert [at for _, at in came] == pytest.approx([first, first + 4 * byte_ms, first + 8 * byte_ms], abs=0.02)
    places = [round(bench.board.servos[number].counts) for number in (4, 5, 22)]
    assert [said[1] for said, _ in came] == places


def test_twenty_three_motors_move_at_one_write(bench):
    ids = [number for number in range(25) if number not in (20, 21)]
    assert len(bench.say(b"".join(move(number, 120) for number in ids))) == 46


@pytest.mark.parametrize("level", range(5))
def test_a_weaker_level_is_slower_and_has_less_torque(level):
    bench = Bench()
    bench.say(move(23, 254, level), 0.1)
    drive = bench.board.drives(bench.now)[23]
    assert drive.torque == pytest.approx(1 - 0.2 * level)
    assert drive.speed_rps == pytest.approx(radians(400) * (1 - 0.2 * level))
    assert bench.board.servos[23].felt.speed_rps == pytest.approx(drive.speed_rps)


def test_a_wrong_sum_is_met_with_silence(bench):
    assert bench.say("FF 97 64 74") == b""
    assert not bench.board.servos[23].driven


def test_passive_lets_go_and_says_where(bench):
    bench.say(move(12, 90), 2.0)
    assert bench.say("FF CC 10 5C") == bytes((0x10, 90))
    assert bench.board.drives(bench.now)[12].torque == 0


def test_break_all_shorts_every_motor_until_it_is_moved(bench):
    bench.say(move(3, 90), 2.0)
    assert bench.say(BRAKE) == b"\x00\x00"
    drives = bench.board.drives(bench.now)
    assert all(drive.brake and drive.torque == 0 for drive in drives.values())
    bench.say(move(3, 91))
    assert bench.board.drives(bench.now)[3].torque == 1


def test_wheels_and_the_synchronous_move_of_a_relative_are_not_obeyed(bench):
    assert bench.say(operate(6, 12, 0x35) + operate(6, 12, 0x45) + hexed("FF 5F 04 7D 7F 66 96 72")) == b""
    assert not any(servo.driven for servo in bench.board.servos)


def test_bounds_clip(bench):
    assert bench.say(configure(23, 0x11, 100, 150)) == bytes((100, 150))
    assert bench.say("FF F7 12 00 00 65") == bytes((100, 150))
    bench.say(move(23, 20), 3.0)
    assert bench.position(23) == 100


def test_registers_are_kept_and_runtime_ones_forgotten_without_supply(bench):
    assert bench.say("FF E6 0A 01 01 6C") == bytes((60, 20))
    assert bench.say("FF E0 0B 64 64 6B") == bytes((100, 100))
    assert bench.say("FF E0 17 1E 64 0D") == b""
    assert bench.say(configure(0, 0x15, 4, 4)) == bytes((4, 4))
    assert bench.say(configure(0, 0x15, 4, 5)) == b""
    assert bench.say(configure(0, 0x0F, 250, 250)) == b""
    bench.fault("brown_out")
    assert bench.say(CONTROL) == b""
    bench.fault("brown_out", value=False)
    bench.say(CONTROL)
    assert bench.say(configure(0, 0x0A, 0, 0)) == bytes((30, 10))
    assert bench.say(configure(0, 0x16, 0, 0)) == bytes((4, 4))


def test_an_id_can_be_changed(bench):
    assert bench.say("FF E0 0C 1E 1E 6C") == bytes((30, 30))
    assert bench.say(read(0)) == b""
    assert len(bench.say(read(30))) == 2


def test_fine_positions_are_not_corrected_by_the_zeros(bench):
    bench.say("FF E0 C8 17 10 00 2F", 2.0)
    assert bench.say("FF E0 AD 17 00 00 5A") == bytes((2048 >> 7, 0))
    own, nominal = bench.board.zeros[23], 127
    assert bench.position(23) == 127 - (own - nominal)
    assert Bench(answers_fine=True).say("FF E0 C8 17 10 00 2F") == bytes((0x10, 0))


def test_a_body_says_where_servos_are_and_how_loaded(bench):
    bench.board.feel({7: ServoFelt(position_rad=radians(-269 / 254 * 27), load=-0.5)}, 18.5, bench.now)
    assert bench.say(read(7)) == bytes((127, 100))
    bench.board.feel({}, 3.0, bench.now)
    assert bench.say(read(7)) == b""
    assert bench.board.drives(bench.now)[7].torque == 0


# Motions.


def test_the_remote_control_s_motion_leaves_pc_control_and_is_answered_at_its_end(bench):
    duration_ms = bench.board.programmes[7].duration_s * 1e3
    [(said, at)] = bench.timed(STAND, 10.0)
    assert said == hexed(PREAMBLE + "14 04 00000001 07 07")
    assert at == pytest.approx(duration_ms, abs=10)
    assert bench.board.mode == "normal"
    assert bench.say(read(0)) == b""
    bench.say(CONTROL)
    assert (bench.position(4), bench.position(5), bench.position(23)) == (48, 206, 127)


def test_a_motion_may_say_nothing_at_its_end():
    assert Bench(reports_end=False).say(STAND, 10.0) == b""


def test_a_motion_in_pc_control_keeps_it_and_servo_packets_wait_for_nobody(bench):
    assert bench.say("FF E0 E1 00 07 06", 1.0) == b""
    assert bench.board.playing == 7
    assert bench.say(move(23, 20)) == b""
    bench.say(b"", 10.0)
    assert (bench.board.mode, bench.board.playing) == ("pc", None)
    assert bench.position(23) == 127


def test_pc_control_ends_a_motion_and_the_servos_stay_where_they_were_told_to_be(bench):
    bench.say(STAND, 3.0)
    bench.say(CONTROL)
    assert (bench.board.mode, bench.board.playing) == ("pc", None)
    knee = bench.position(4)
    assert bench.say(b"", 3.0) == b""
    assert bench.position(4) == pytest.approx(knee, abs=1)
    assert knee != 48


def test_a_board_that_does_not_abort_plays_to_the_end():
    bench = Bench(aborts=False)
    bench.say(STAND, 3.0)
    assert bench.say(CONTROL) == b""
    assert bench.board.playing == 7


def test_sitting_down_ends_limp():
    bench = Bench()
    bench.say(STAND, 10.0)
    assert all(servo.driven for servo in bench.board.servos)
    bench.say(PREAMBLE + "14 00 00000001 15 15", 20.0)
    assert not any(servo.driven for servo in bench.board.servos)
    bench.say(CONTROL)
    bench.say(move(23, 100), 2.0)
    assert bench.position(23) == 100


def test_a_second_button_during_a_motion_changes_nothing(bench):
    bench.say(STAND, 1.0)
    assert bench.say(NO_PROGRAMME) == b""
    assert bench.board.playing == 7


def test_an_empty_slot_is_over_at_once(bench):
    assert bench.say(NO_PROGRAMME) == hexed(PREAMBLE + "14 04 00000001 0F 0F")


def test_every_shipped_motion_plays_to_its_end_and_every_button_of_the_phone_has_one():
    assert {1, 7, 21} <= set(shipped())
    for slot, programme in shipped().items():
        bench = Bench(programmes={})
        assert bench.board.press(slot, bench.now)
        bench.say(b"", programme.duration_s + 0.1)
        assert bench.board.playing is None, slot
        counts = {servo.number: servo.counts for servo in bench.board.servos if servo.driven}
        assert counts == pytest.approx({n: c for n, c in programme.ends_at().items() if n in counts})


def test_a_row_s_motion_replaces_the_main_board_s():
    nod = {"frames": [{"figure": "nod", "times": 2}], "figures": {"nod": [{"duration_s": 0.5, "counts": {"24": 140}}]}}
    device = Device("main_board", "uxa90", "/nowhere/main_board", {"programmes": {"4": nod}})
    board = make(device, Surroundings(seed=1, now=0.0)).board
    assert board.press(4, 1.0)
    board.poll(1.5)
    assert board.servos[24].counts == 140
    assert board.playing == 4
    board.poll(2.1)
    assert board.playing is None


def test_switching_off_is_done_until_power_comes_back(bench):
    assert bench.say(PREAMBLE + "14 00 00000001 21 21") == b""
    assert bench.say(CONTROL) == b""
    bench.fault("brown_out")
    bench.fault("brown_out", value=False)
    assert bench.say(CONTROL) == hexed(CONTROLLED)


# Faults.


def test_power_lost_is_a_robot_that_is_limp_and_not_controlled(bench):
    bench.say(move(3, 90), 1.0)
    bench.fault("brown_out")
    assert bench.say(read(3)) == b""
    bench.fault("brown_out", value=False)
    assert bench.board.mode == "normal"
    assert not bench.board.servos[3].driven


def test_pc_control_can_be_lost_and_taken_again(bench):
    bench.fault("kills_pc")
    bench.say(b"", 1.0)
    assert bench.board.mode == "normal"
    assert bench.say(CONTROL) == hexed(CONTROLLED)
    assert len(bench.say(read(3))) == 2


def test_silence_obeys(bench):
    bench.fault("silent")
    assert bench.say(move(3, 90) + hexed(CONTROL), 1.0) == b""
    assert bench.board.servos[3].counts == 90


@pytest.mark.parametrize("fault", ["no_replies", "missing"])
def test_servos_fall_silent_while_the_board_answers(bench, fault):
    bench.fault(fault)
    assert bench.say(read(3)) == b""
    assert bench.say(CONTROL) == hexed(CONTROLLED)


def test_late_is_late(bench):
    sound = bench.timed(read(3))[-1][1]
    bench.fault("late_s", 0.05)
    assert bench.timed(read(3))[-1][1] == pytest.approx(sound + 50, abs=0.1)


def test_wrong_answers_are_wrong(bench):
    sound = bench.say(read(3))
    bench.fault("shifted")
    assert bench.say(read(3))[1:] == sound
    bench.fault("shifted", value=0.0)
    bench.fault("garbage")
    assert len(bench.say(read(3))) == 2
    assert {bench.say(read(3)) for _ in range(5)} != {sound}
    bench.fault("garbage", value=0.0)
    bench.fault("bit_flip")
    assert (int.from_bytes(bench.say(read(3))) ^ int.from_bytes(sound)).bit_count() == 1


def test_dead_stuck_and_frozen_servos(bench):
    bench.fault("dead", "3")
    assert bench.say(move(3, 90) + read(4))[1:2] == bytes((round(bench.board.servos[4].counts),))
    bench.fault("stuck", "5,6")
    before = bench.position(5)
    bench.say(move(5, 200), 2.0)
    assert bench.say(read(5)) == bytes((254, before))
    bench.fault("frozen")
    before = bench.position(12)
    bench.say(move(12, 200), 2.0)
    assert bench.position(12) == before
    bench.fault("frozen", value=False)
    assert bench.position(12) == 200


def test_babble_talks_by_itself(bench):
    bench.fault("babble")
    assert bench.say(b"", 0.5)


# Bytes of any kind.


@given(st.binary(max_size=200), st.lists(st.integers(1, 30), max_size=8))
def test_the_reader_finds_the_same_however_bytes_are_cut(data, cuts):
    data = hexed(CONTROL) + data + hexed("FF 97 64 73")
    whole = [heard[:-1] for heard in Reader().feed(data, 0.0)]
    pieces, reader, at = [], Reader(), 0
    for cut in (*cuts, len(data)):
        pieces += [heard[:-1] for heard in reader.feed(data[at : at + cut], 0.0)]
        at += cut
    assert pieces == whole
    assert whole[0] == (0x10, 0, b"\x01", True)


@given(st.lists(st.binary(max_size=60), max_size=12))
def test_nothing_that_is_sent_breaks_the_board(pieces):
    bench = Bench()
    for piece in pieces:
        bench.say(piece, 0.02)
    bench.fault("brown_out")
    bench.fault("brown_out", value=False)
    bench.say(CONTROL, 1.0)
    assert bench.board.mode == "pc"


def test_a_pause_within_a_packet_ends_it():
    reader = Reader()
    assert reader.feed(hexed("FF 97"), 1.0) == []
    assert reader.feed(hexed("64 73"), 1.0 + 2 * GAP_S) == []
    assert reader.feed(hexed("FF 00 FF 97 64 73"), 2.0) == [Packet(hexed("97 64"), sound=True, end=6)]
    assert reader.feed(hexed(STAND), 2.0) == [packets.Frame(0x14, 0, b"\x07", sound=True, end=16)]


# The twin.


def test_a_row_that_makes_no_sense_is_refused():
    with pytest.raises(InputError, match=r"device 'main_board' .*aborts"):
        make(Device("main_board", "uxa90", "/nowhere", {"aborts": 3}), Surroundings(seed=1, now=0.0))
    programmes = {"4": {"frames": [{"figure": "jump"}]}}
    device = Device("main_board", "uxa90", "/nowhere", {"programmes": programmes})
    with pytest.raises(InputError, match="figure 'jump'"):
        make(device, Surroundings(seed=1, now=0.0))


def test_speaks_on_a_tty_and_traces_every_byte(tmp_path):
    device = Device("main_board", "uxa90", str(tmp_path / "main_board"), {"trace": True, "settle_ms": 0.0})
    twin = make(device, Surroundings(seed=1, now=0.0))
    assert isinstance(twin, ServoBus)
    twin.service(monotonic())
    twin.sense(Sensed(battery_v=18.5))
    with (tmp_path / "main_board").open("r+b", buffering=0) as line:
        attributes = termios.tcgetattr(line)
        attributes[4] = attributes[5] = termios.B115200
        termios.tcsetattr(line, termios.TCSANOW, attributes)
        line.write(hexed(CONTROL))
        said = b""
        end = monotonic() + HANG_S
        while twin.board.mode != "pc" or twin.next_due() is not None:
            assert monotonic() < end
            twin.service(monotonic())
        said = line.read(16)
        assert said == hexed(CONTROLLED)
        line.write(move(23, 100, 4) + move(24, 120))
        twin.service(monotonic())
    twin.fault("unplug", True)
    twin.service(monotonic())
    assert twin.watched() is None
    twin.close()
    lines = [line.split(maxsplit=1)[1] for line in (tmp_path / "main_board.trace").read_text().splitlines()]
    assert lines[0] == "plugged"
    assert f"read {hexed(CONTROL).hex()}" in lines
    assert f"said {said.hex()}" in lines
    assert lines.index("mode pc 0") < lines.index("read ff976473ff187860")
    assert lines[-1] == "unplugged"
