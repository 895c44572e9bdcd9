from math import inf, nan

import pytest

from lbr.drivers.roboteq import KIND, Wheel
from lbr.drivers.roboteq import protocol as wire
from lbr.drivers.roboteq.controller import Controller, wire_value
from lbr.errors import DeviceError
from lbr.simulation.devices.roboteq.device import RoboteqDevice
from tests.drivers.memory_line import MemoryLine
from tests.drivers.peers import RoboteqScript

NOISE = {"junk": b"junk\r" * 4, "line ends": b"\r" * 20, "no line ends": b"\xff" * 20}
STAND = "!M 0 0"
MIRRORED = '{"device": "motors", "left": {"channel": 1, "direction": -1}, "right": {"channel": 2}'


def repeat(times, action):
    for _ in range(times):
        action()


@pytest.fixture
def peer():
    return RoboteqScript()


@pytest.fixture
def line(peer):
    return MemoryLine(peer)


@pytest.fixture
def bring_up(line):
    def build(more="", wheels=MIRRORED):
        return Controller(line, KIND.parse(wheels + more + "}"), line.clock)

    return build


def test_opening_identifies_then_writes_zero_then_sets_and_reads_back(bring_up, peer):
    controller = bring_up()
    controller.open()
    expected = ["?FID", "?TRN", "!M 0 0", "^ECHOF 0", "^RWD 200", "~RWD", "~MXMD", "?FF"]
    assert peer.log == expected
    assert peer.settings["RWD"] == 200
    assert controller.firmware.startswith("Roboteq")
    assert controller.telemetry.faults == ()


@pytest.mark.parametrize("echo_before", [0, 1])
@pytest.mark.parametrize("echo", ["true", "false"])
def test_echo_may_be_on_or_off_before_and_after(bring_up, peer, echo_before, echo):
    peer.settings["ECHOF"] = echo_before
    controller = bring_up(f', "echo": {echo}')
    controller.open()
    assert peer.settings["ECHOF"] == (0 if echo == "true" else 1)
    controller.drive(0.5, 0.5)
    assert controller.applied == (0.5, 0.5)
    for _ in range(12):
        controller.poll()
    measured = controller.telemetry.measured()
    assert measured["voltage_v"] == 12.6
    assert measured["internal_v"] == 13.5
    assert measured["output_v"] == 4.73
    assert (measured["amps_left_a"], measured["amps_right_a"]) == (5.1, 1.2)
    assert (measured["counts_left"], measured["counts_right"]) == (-130, -260)
    assert measured["temperature_c"] == 30.0
    assert (controller.lost, controller.refused) == (0, 0)


def test_a_controller_that_echoes_against_its_setting_is_understood(bring_up, peer):
    peer.echo_always = True
    controller = bring_up(', "echo": false')
    controller.open()
    assert controller.stop()


@pytest.mark.parametrize(
    ("left", "right", "told"),
    [
        (0.5, 0.5, "!M -500 500"),
        (0.2, -0.2, "!M -200 -200"),
        (1.0, -1.0, "!M -1000 -1000"),
        (9.0, -9.0, "!M -1000 -1000"),
        (nan, 0.5, "!M 0 0"),
        (0.5, inf, "!M 0 0"),
    ],
)
def test_powers_become_wire_values(bring_up, peer, left, right, told):
    controller = bring_up()
    controller.open()
    controller.drive(left, right)
    assert peer.motor_commands()[-1] == told


@pytest.mark.parametrize(
    ("power", "wheel", "value"),
    [
        (0.5, Wheel(channel=1), 500),
        (0.5, Wheel(channel=1, direction=-1), -500),
        (0.5, Wheel(channel=1, trim=1.1), 550),
        (1.0, Wheel(channel=1, trim=1.5), 1000),
        (-1.0, Wheel(channel=1, trim=1.5, max_power=0.4), -400),
        (nan, Wheel(channel=1), 0),
        (inf, Wheel(channel=1), 0),
    ],
)
def test_trim_and_limit_hold_for_each_wheel(power, wheel, value):
    assert wire_value(power, wheel) == value


def test_swapped_channels_swap_wire_and_telemetry(bring_up, peer):
    controller = bring_up(wheels='{"device": "motors", "left": {"channel": 2}, "right": {"channel": 1}')
    controller.open()
    controller.drive(0.1, 0.3)
    assert peer.motor_commands()[-1] == "!M 300 100"
    assert controller.applied == (0.1, 0.3)
    for _ in range(3):
        controller.poll()
    assert controller.telemetry.measured()["counts_left"] == -260


def test_wheels_that_turn_alike_are_doubted_and_mirrored_ones_are_not():
    assert KIND.parse(MIRRORED + "}").doubts() == ()
    assert len(KIND.parse('{"device": "motors"}').doubts()) == 1


def test_a_watchdog_that_reads_back_otherwise_is_refused(bring_up, peer):
    peer.deaf_to_settings = True
    with pytest.raises(DeviceError, match=r"'motors'.*~RWD with 1000, expected 200"):
        bring_up().open()


@pytest.mark.parametrize("watchdog_ms", [0, 251, 1000])
def test_a_longer_watchdog_than_a_quarter_second_cannot_be_set(watchdog_ms):
    with pytest.raises(Exception, match=r"watchdog_ms"):
        KIND.parse(MIRRORED + f', "watchdog_ms": {watchdog_ms}}}')


def test_mixed_channels_are_refused_unless_the_row_says_otherwise(bring_up, peer):
    peer.settings["MXMD"] = 1
    with pytest.raises(DeviceError, match="~MXMD with 1, expected 0"):
        bring_up().open()


class Babbled(MemoryLine):
    """A line on which there is always something to read, once there is noise."""

    noise = b""

    def read(self, wait_s=0.0):
        if self.noise:
            self.time.now += 0.001
            return self.noise
        return super().read(wait_s)


class Late:
    """An emulated controller whose answers come late."""

    def __init__(self, delay_s=0.0):
        self.delay_s, self.due, self.misread = delay_s, [], iter(())
        self.real = RoboteqDevice()

    def feed(self, data, now):
        self.due.append((now + self.delay_s, data))
        return b""

    def poll(self, now):
        if not self.due or self.due[0][0] > now:
            return self.real.poll(now)
        _, asked = self.due.pop(0)
        if asked == b"~RWD\r" and (misread := next(self.misread, b"")):
            return misread
        return self.real.feed(asked, now - self.delay_s / 6) + self.real.poll(now)


def opened_on(line, reply_timeout_s=0.03):
    settings = KIND.parse(f'{{"device": "motors", "reply_timeout_s": {reply_timeout_s}}}')
    controller = Controller(line, settings, line.clock)
    controller.open()
    return controller


@pytest.mark.parametrize("delay_s", [0.06, 0.099])
def test_a_controller_that_is_set_up_may_take_longer_for_its_answers_than_one_that_drives(delay_s):
    line = MemoryLine(Late(delay_s))
    controller = opened_on(line)
    assert [line.asked(b"%s\r" % query) for query in (b"?FID", b"?TRN", b"~RWD", b"?FF")] == [1, 1, 1, 1]
    assert not controller.stop()


@pytest.mark.parametrize(
    ("identity", "told"),
    [
        ("Frobnicator 3000", "Frobnicator 3000"),
        ("Roboteq v1.6 RIOX 2015", r"RIOX.*is an inertial unit \(kind riox\); correct the address"),
    ],
)
def test_the_wrong_device_is_named_and_never_told_to_move(bring_up, peer, identity, told):
    peer.answers["FID"] = identity
    controller = bring_up()
    with pytest.raises(DeviceError, match=told):
        controller.open()
    controller.close()
    assert peer.motor_commands() == []


def test_the_wrong_model_is_refused(bring_up):
    with pytest.raises(DeviceError, match=r"SDC21xx:SDC2130.*HDC"):
        bring_up(', "model": "HDC"').open()


def test_a_half_line_left_by_somebody_else_does_not_stop_the_opening(bring_up, peer, line):
    controller = bring_up()
    line.write(b"!M 700 7")
    peer.answer = lambda line: b"-\r" if line.startswith("!M 700") else None
    controller.open()
    assert peer.motor == (0, 0)


def test_a_silent_controller_is_an_error_within_a_second(bring_up, peer):
    peer.answer = lambda line: b""
    with pytest.raises(DeviceError, match="does not answer"):
        bring_up().open()


@pytest.mark.parametrize("noise", NOISE.values(), ids=NOISE)
def test_a_babbling_controller_is_an_error_that_says_so(noise):
    line = Babbled(Late())
    controller = opened_on(line)
    line.noise = noise
    with pytest.raises(
        DeviceError, match=r"babbles \([0-9]+ bytes that answer nothing\) and left 4 commands unanswered"
    ):
        repeat(1000, lambda: controller.drive(0.4, 0.4))


@pytest.mark.parametrize("noise", NOISE.values(), ids=NOISE)
def test_what_babbles_from_the_beginning_is_no_controller_and_opening_ends(noise):
    line = Babbled(Late())
    line.noise = noise
    with pytest.raises(DeviceError, match=r"babbles .* does not answer \?FID"):
        opened_on(line)


@pytest.mark.parametrize("reply_timeout_s", [0.03, 0.1])
@pytest.mark.parametrize(
    ("urgent", "told"),
    [
        (Controller.emergency_stop, b"!EX\r"),
        (Controller.stop, wire.STOP),
        (Controller.close, wire.STOP),
    ],
)
def test_a_babbling_controller_is_told_to_stop_soon(urgent, told, reply_timeout_s):
    line = Babbled(Late())
    controller = opened_on(line, reply_timeout_s)
    line.noise = NOISE["junk"]
    controller.drive(0.3, 0.3)  # its answer is still due
    line.written.clear()
    began = line.clock()
    assert not urgent(controller)
    assert line.written[0] == (pytest.approx(began, abs=0.032), told)


def test_one_lost_answer_is_counted_and_the_next_command_goes_on(bring_up, peer):
    controller = bring_up()
    controller.open()
    lost = []
    peer.answer = lambda line: b"" if line.startswith("!M") and not lost and not lost.append(line) else None
    controller.drive(0.2, 0.2)
    repeat(200, lambda: controller.drive(0.3, 0.3))
    assert controller.applied == (0.3, 0.3)
    assert controller.lost == 1


@pytest.mark.parametrize("echo", ["true", "false"])
def test_a_late_answer_is_not_taken_for_the_stops(bring_up, peer, echo):
    controller = bring_up(f', "echo": {echo}')
    controller.open()
    late = []

    def answer(line):
        if line == "!M -200 200":
            late.append(line)
            return b""
        if line == "!EX":  # the answer to the command before comes only now, and none to this one
            return b"+\r"
        return None

    peer.answer = answer
    controller.drive(0.2, 0.2)
    assert not controller.emergency_stop()
    assert late


def test_refusals_are_counted_and_too_many_are_an_error(bring_up, peer):
    controller = bring_up()
    controller.open()
    peer.answer = lambda line: line.encode() + b"\r-\r" if line.startswith("!M") else None
    with pytest.raises(DeviceError, match="refused 5 commands"):
        repeat(10, lambda: controller.drive(0.1, 0.1))
    assert controller.refused == 5
    assert controller.applied == (0.0, 0.0)


def test_after_a_gap_as_long_as_the_watchdog_zero_goes_first(bring_up, peer, line):
    controller = bring_up(', "watchdog_ms": 50')
    controller.open()
    controller.drive(0.4, 0.4)
    line.time.now += 0.051
    controller.drive(0.4, 0.4)
    controller.drive(0.4, 0.4)
    assert peer.motor_commands()[-3:] == ["!M -400 400", "!M 0 0", "!M -400 400"]


def test_a_controller_that_stops_reading_is_never_fed_more_than_one_command(bring_up, peer):
    controller = bring_up()
    controller.open()
    controller.drive(0.4, 0.4)
    peer.reads = False
    with pytest.raises(DeviceError, match="unanswered"):
        repeat(1000, lambda: controller.drive(0.4, 0.4))
    controller.close()
    assert peer.unread.endswith(wire.STOP)
    assert peer.unread.count(b"!M -400 400") == 1
    assert len(peer.unread) < 50


def test_a_reset_that_brings_back_the_long_watchdog_is_noticed_once_it_is_read_twice_in_a_row():
    line = MemoryLine(Late())
    controller = opened_on(line)
    before = line.asked(b"~RWD\r")
    line.device.real.feed(b"^RWD 1000\r", line.clock())
    repeat(10, controller.poll)
    assert line.asked(b"~RWD\r") == before + 1
    with pytest.raises(DeviceError, match="watchdog of 1000 ms"):
        controller.poll()
    assert line.asked(b"~RWD\r") == before + 2


def test_a_misread_watchdog_is_asked_for_again_and_forgiven_each_time():
    line = MemoryLine(Late())
    controller = opened_on(line)
    line.written.clear()
    line.device.misread = iter((b"RWD=300\r", b"", b"RWD=300\r"))
    repeat(25, controller.poll)
    assert line.asked(b"~RWD\r") == 4


def test_closing_writes_zero_and_waits_for_it(bring_up, peer):
    controller = bring_up()
    controller.open()
    controller.drive(0.4, 0.4)
    controller.close()
    assert peer.motor == (0, 0)


def unplugged(_data):
    raise DeviceError("went away", "unplugged")


def test_closing_tells_whether_somebody_may_still_be_moving(bring_up, peer, line, monkeypatch):
    controller = bring_up()
    controller.open()
    peer.answer = lambda line: b""
    assert not controller.close()
    peer.answer = lambda line: None
    controller = bring_up()
    controller.open()
    assert controller.close()
    controller = bring_up()
    controller.open()
    unheard = iter(range(2))
    peer.answer = lambda line: b"" if line == STAND and next(unheard, None) is not None else None
    assert controller.close(), "the third is answered"
    controller = bring_up()
    assert controller.close()  # never opened
    controller = bring_up()
    controller.open()
    monkeypatch.setattr(line, "write", unplugged)
    assert controller.close()


def test_an_emergency_stop_cuts_then_zeroes_and_release_zeroes_first(bring_up, peer):
    controller = bring_up()
    controller.open()
    controller.drive(0.4, 0.4)
    assert controller.emergency_stop()
    assert peer.motor_commands()[-2:] == ["!EX", STAND]
    assert controller.asked == (0.0, 0.0)
    assert controller.release()
    assert peer.motor_commands()[-2:] == ["!M 0 0", "!MG"]
    assert not peer.latched


def test_faults_are_unknown_after_a_release_until_they_are_read_again(bring_up, peer):
    controller = bring_up()
    controller.open()
    peer.answer = lambda line: b"" if line == "?FF" else None
    assert controller.release()
    assert controller.faults is None


def test_garbage_between_the_answers_does_no_harm(bring_up, peer, line):
    controller = bring_up()
    controller.open()
    line.say(b"\xff\x00V=1:\r\rA=zz\r+\r-\r" + b"x" * 2000)
    peer.answer = lambda line: b"\r" + line.encode() + b"\r+\r" if line.startswith("!M") else None
    controller.drive(0.1, 0.1)
    assert controller.applied == (0.1, 0.1)


def test_what_the_controller_does_not_answer_any_more_becomes_unknown(bring_up, peer):
    now = [0.0]
    controller = bring_up()
    controller.telemetry._clock = lambda: now[0]
    controller.open()
    for _ in range(12):
        controller.poll()
    assert controller.telemetry.measured()["voltage_v"] == 12.6
    now[0] = 1.0
    measured = controller.telemetry.measured()
    assert (controller.telemetry.faults, measured["counts_left"], measured["voltage_v"]) == (None, None, 12.6)
    now[0] = 2.5
    assert controller.telemetry.measured()["voltage_v"] is None
