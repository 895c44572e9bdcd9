"""The emulated Roboteq against what the manual says of the real one."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.simulation.devices.roboteq import RoboteqFaults
from lbr.simulation.devices.roboteq.device import REBOOT_S, Measured, RoboteqDevice
from lbr.simulation.wire import BYTE_S


class Bench:
    """A controller and a clock; `say` waits long enough for the whole answer."""

    def __init__(self, **faults):
        self.heard = []
        self.device = RoboteqDevice(
            faults=RoboteqFaults(**faults), seed=3, on_command=lambda line, now: self.heard.append(line)
        )
        self.now = 100.0

    def say(self, line):
        self.device.feed(line.encode() + b"\r", self.now)
        self.now += 0.02
        return self.device.poll(self.now)

    def quiet(self, line):
        """Send a line and strip its echo off the answer."""
        answer = self.say(line)
        return answer.removeprefix(line.encode() + b"\r")

    @property
    def outputs(self):
        return self.device.outputs(self.now)


@pytest.fixture
def bench():
    return Bench()


def test_echoes_every_command_until_told_not_to(bench):
    assert bench.say("!M 100 200") == b"!M 100 200\r+\r"
    assert bench.say("^ECHOF 1") == b"^ECHOF 1\r+\r"
    assert bench.say("!M 100 200") == b"+\r"
    assert bench.say("^ECHOF 0") == b"+\r"
    assert bench.say("~ECHOF") == b"~ECHOF\rECHOF=0\r"


def test_underscore_ends_a_command_too(bench):
    bench.device.feed(b"^ECHOF 1_!G 1 500_", bench.now)
    assert bench.outputs == (0.5, 0.0)
    assert bench.device.poll(bench.now + 1) == b"^ECHOF 1_+\r+\r"


def test_presence_check_is_acknowledged(bench):
    bench.device.feed(b"\x05", bench.now)
    assert bench.device.poll(bench.now + 0.01) == b"\x06"


@pytest.mark.parametrize(
    ("line", "answer"),
    [
        ("!M 1000 -1000", b"+\r"),
        ("!m 1 2", b"+\r"),
        ("!M 1001 0", b"-\r"),
        ("!M 0 -1001", b"-\r"),
        ("!M 5", b"-\r"),
        ("!M nan 0", b"-\r"),
        ("!M 0.5 0", b"-\r"),
        ("!G 3 100", b"-\r"),
        ("!G 2 100", b"+\r"),
        ("!MS 1", b"+\r"),
        ("!WHAT", b"-\r"),
        ("!", b"-\r"),
        ("hello", b"-\r"),
        ("^RWD 250", b"+\r"),
        ("^RWD 65001", b"-\r"),
        ("^RWD", b"-\r"),
        ("^MXMD 3", b"-\r"),
        ("~NOPE", b"-\r"),
        ("%RESET 1", b"-\r"),
        ("%EESAV", b"+\r"),
        ("?X", b"-\r"),
        ("?A 3", b"-\r"),
        ("", b""),
    ],
)
def test_answers_plus_or_minus(bench, line, answer):
    assert bench.quiet(line) == answer


def test_a_refused_value_changes_nothing(bench):
    bench.say("!M 300 300")
    bench.say("!M 2000 0")
    assert bench.outputs == (0.3, 0.3)


@pytest.mark.parametrize(
    ("query", "answer"),
    [
        ("?V", b"V=135:126:4730\r"),
        ("?V 2", b"V=126\r"),
        ("?A", b"A=-51:12\r"),
        ("?BA", b"BA=20:10\r"),
        ("?C", b"C=130:-260\r"),
        ("?S", b"S=61:-60\r"),
        ("?T", b"T=28:30:30\r"),
        ("?FF", b"FF=0\r"),
        ("?FS", b"FS=1\r"),
        ("?FM", b"FM=0:0\r"),
        ("?FM 1", b"FM=0\r"),
        ("?M", b"M=0:0\r"),
        ("?TRN", b"TRN=RCB500:SDC2130\r"),
    ],
)
def test_reports_what_it_measures(bench, query, answer):
    bench.device.measured = Measured(
        internal_v=13.5,
        battery_v=12.6,
        output_v=4.73,
        amps_a=(-5.1, 1.2),
        battery_amps_a=(2.0, 1.0),
        counts=(130, -260),
        speeds_rpm=(61.0, -60.0),
    )
    assert bench.quiet(query) == answer


def test_names_its_firmware(bench):
    assert bench.quiet("?FID").startswith(b"FID=Roboteq")


def test_answers_take_the_time_of_their_bytes(bench):
    device, line = bench.device, b"?V\r"
    device.feed(line, bench.now)
    earliest = bench.now + (len(line) + len(b"?V\rV=120:126:5000\r")) * BYTE_S + 0.0005
    received, at = b"", bench.now
    while not received.endswith(b"5000\r"):
        at = device.next_due()
        received += device.poll(at)
    assert received == b"?V\rV=120:126:5000\r"
    assert at == pytest.approx(earliest, abs=1e-4)
    assert device.poll(at + 1) == b""


def test_watchdog_starts_at_one_second(bench):
    assert bench.quiet("~RWD") == b"RWD=1000\r"
    start = bench.now
    bench.say("!M 500 500")
    assert bench.device.outputs(start + 0.999) == (0.5, 0.5)
    assert bench.device.outputs(start + 1.0) == (0.0, 0.0)
    assert bench.device.cause(start + 1.0) == "watchdog"


def test_tells_when_the_watchdog_will_expire(bench):
    bench.say("^RWD 200")
    start = bench.now
    bench.say("!M 500 500")
    assert bench.device.next_due() == pytest.approx(start + 0.2)
    bench.now = start + 0.3
    assert bench.outputs == (0.0, 0.0)
    assert bench.device.next_due() is None


def test_only_runtime_commands_feed_the_watchdog(bench):
    bench.say("^RWD 200")
    bench.say("!M 500 500")
    for line in ["?V", "^MXMD 0", "~RWD", "?FF", "^RWD 200", "!NOPE", "!M 9999 0", "%EESAV", "?M", "?A", "?C"]:
        bench.say(line)
    assert bench.outputs == (0.0, 0.0)
    assert bench.quiet("?M") == b"M=0:0\r"


def test_zero_turns_the_watchdog_off(bench):
    bench.say("^RWD 0")
    bench.say("!M 500 500")
    bench.now += 3600
    assert bench.outputs == (0.5, 0.5)


@pytest.mark.parametrize(
    ("line", "resumed"),
    [
        ("!G 1 0", (0.0, 0.5)),
        ("!G 2 100", (0.5, 0.1)),
        ("!MS 1", (0.0, 0.5)),
        ("!D1 1", (0.5, 0.5)),
        ("!MG", (0.5, 0.5)),
        ("!C 1 0", (0.5, 0.5)),
        ("!M 0 0", (0.0, 0.0)),
        ("?V", (0.0, 0.0)),
        ("^RWD 0", (0.0, 0.0)),
        ("!M 1 1001", (0.0, 0.0)),
    ],
)
def test_the_next_valid_command_resumes_the_earlier_motion(bench, line, resumed):
    bench.say("!M 500 500")
    bench.now += 2
    assert bench.outputs == (0.0, 0.0)
    bench.say(line)
    assert bench.outputs == resumed


def test_emergency_stop_latches_until_released(bench):
    bench.say("!M 500 500")
    assert bench.quiet("!EX") == b"+\r"
    assert bench.outputs == (0.0, 0.0)
    assert bench.device.cause(bench.now) == "emergency_stop"
    assert bench.quiet("?FF") == b"FF=16\r"
    assert bench.quiet("!M 700 700") == b"+\r"
    assert bench.outputs == (0.0, 0.0)
    bench.say("!MG")
    assert bench.quiet("?FF") == b"FF=0\r"
    assert bench.outputs == (0.7, 0.7), "the trap: release resumes the last command"


def test_zero_before_release_stays_at_rest(bench):
    for line in ["!M 500 500", "!EX", "!M 0 0", "!MG"]:
        bench.say(line)
    assert bench.outputs == (0.0, 0.0)


def test_mixing_mode_changes_what_the_channels_do(bench):
    bench.say("^MXMD 1")
    bench.say("!M 500 200")
    assert bench.outputs == (0.7, 0.3)
    assert bench.quiet("~MXMD") == b"MXMD=1\r"


def test_reset_loses_what_was_not_saved_and_drops_the_port(bench):
    for line in ["^RWD 250", "%EESAV", "^RWD 100", "^MXMD 1", "^ECHOF 1", "!M 500 500"]:
        bench.say(line)
    reset_at = bench.now
    bench.say("%RESET 321654987")
    assert not bench.device.present(reset_at + 0.1)
    assert bench.device.cause(bench.now) == "reset"
    assert bench.outputs == (0.0, 0.0)
    bench.now = reset_at + REBOOT_S
    assert bench.device.present(bench.now)
    bench.device.poll(bench.now)
    assert bench.say("~RWD") == b"~RWD\rRWD=250\r"
    assert bench.quiet("~MXMD") == b"MXMD=0\r"
    bench.say("!G 1 0")
    assert bench.outputs == (0.0, 0.0), "no earlier motion is left to resume"


def test_repeats_the_history_of_queries_in_turn(bench):
    for line in ["^ECHOF 1", "?FF", "?M"]:
        bench.say(line)
    start = bench.now
    assert bench.say("# 100") == b""
    answers = b"".join(bench.device.poll(start + step / 100) for step in range(45))
    assert answers == b"FF=0\rM=0:0\rFF=0\rM=0:0\r"
    bench.now = start + 0.45
    bench.say("# C")
    assert bench.device.poll(bench.now + 1) == b""


def test_counts_can_be_set(bench):
    bench.device.measured = Measured(counts=(500, 20))
    bench.say("!C 1 0")
    bench.device.measured = Measured(counts=(530, 20))
    assert bench.quiet("?C") == b"C=30:20\r"


def test_tells_of_each_runtime_line(bench):
    for line in ["!M 1 2", "?V", "!BAD"]:
        bench.say(line)
    assert bench.heard == ["!M 1 2", "!BAD"]


@pytest.mark.parametrize(
    ("faults", "answer"),
    [
        ({"silent": True}, b""),
        ({"drop": 1.0}, b"!M 500 500\r"),
        ({"refuse": 1.0}, b"!M 500 500\r-\r"),
    ],
)
def test_faults_of_the_answers(faults, answer):
    assert Bench(**faults).say("!M 500 500") == answer


def test_a_silent_controller_still_obeys_and_a_refusing_one_does_not():
    silent, refusing = Bench(silent=True), Bench(refuse=1.0)
    for bench in (silent, refusing):
        bench.say("!M 500 500")
    assert silent.outputs == (0.5, 0.5)
    assert refusing.outputs == (0.0, 0.0)


def test_spoilt_answers_differ_and_repeat_with_the_seed():
    first, second = (Bench(bit_flip=1.0, garbage=1.0) for _ in range(2))
    answer = first.say("?V")
    assert answer != b"?V\rV=120:126:5000\r"
    assert answer == second.say("?V")


@pytest.mark.parametrize(("fault", "bits"), [("undervoltage", b"FF=4\r"), ("overheat", b"FF=1\r")])
def test_a_fault_bit_turns_the_power_stage_off(fault, bits):
    bench = Bench(**{fault: True})
    bench.say("!M 500 500")
    assert bench.quiet("?FF") == bits
    assert bench.quiet("?FS") == b"FS=9\r"
    assert bench.outputs == (0.0, 0.0)
    assert bench.device.cause(bench.now) == "fault"


def test_unplugged_it_goes_on_until_its_watchdog(bench):
    bench.say("!M 500 500")
    bench.device.faults = RoboteqFaults(unplug=True)
    assert not bench.device.present(bench.now)
    assert bench.outputs == (0.5, 0.5)
    bench.say("!M 100 100")
    assert bench.outputs == (0.5, 0.5), "nothing gets through a pulled cable"
    bench.now += 1
    assert bench.outputs == (0.0, 0.0)


def test_a_brown_out_forgets_everything(bench):
    bench.say("^RWD 50000")
    bench.say("!M 500 500")
    bench.device.faults = RoboteqFaults(brown_out=True)
    assert bench.outputs == (0.0, 0.0)
    bench.device.faults = RoboteqFaults()
    assert bench.quiet("~RWD") == b"RWD=1000\r"
    bench.say("!MG")
    assert bench.outputs == (0.0, 0.0)


@given(st.lists(st.binary(max_size=80), max_size=8))
def test_any_bytes_are_survived(chunks):
    bench = Bench()
    for chunk in chunks:
        bench.device.feed(chunk, bench.now)
        bench.now += 0.05
        bench.device.poll(bench.now)
        assert all(-1 <= power <= 1 for power in bench.outputs)
    bench.device.feed(b"\r^ECHOF 1\r", bench.now)
    bench.now += 1
    bench.device.poll(bench.now)
    bench.device.feed(b"# C\r~RWD\r", bench.now)
    assert bench.device.poll(bench.now + 1).startswith(b"RWD=")


@given(st.lists(st.sampled_from(["!M 300 -200", "?V", "!EX", "!MG", "~RWD", "^MXMD 1", "?FF"])), st.integers(1, 9))
def test_answers_do_not_depend_on_how_the_bytes_are_cut(lines, size):
    whole, pieces = RoboteqDevice(), RoboteqDevice()
    data = "".join(f"{line}\r" for line in lines).encode()
    whole.feed(data, 1.0)
    for start in range(0, len(data), size):
        pieces.feed(data[start : start + size], 1.0)
    assert whole.outputs(1.0) == pieces.outputs(1.0)
    assert whole.poll(2.0) == pieces.poll(2.0)
