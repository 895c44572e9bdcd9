import re
from math import radians

import pytest

from lbr.drivers.inertial import LifeSigns
from lbr.drivers.riox import KIND
from lbr.drivers.riox.capability import MOST_ALIKE, Riox
from lbr.drivers.riox.controller import QUIET_S, AhrsUnit
from lbr.errors import DeviceError
from tests.drivers.peers import DriverContext
from tests.support.waiting import until

TICK_S = 0.01


class Wire:
    """A line and the unit at its end: answers at the next poll, or as told."""

    def __init__(self, *, echo=False, refused=()):
        self.echo = echo
        self.refused = refused
        self.silent = self.frozen = False
        self.asked = []
        self.turns = 0
        self.coming = b""
        self.said = None
        self.orientation = (16384, 0, 0, 0)

    def read(self, wait_s=0.0):
        data, self.coming = self.coming, b""
        return data

    def write(self, data):
        name = data.decode().strip("?\r")
        self.asked.append(name)
        self.turns += not self.frozen
        if not self.silent:
            answer = b"-\r" if name in self.refused else self.answer(name)
            self.coming += (data if self.echo else b"") + answer
        return len(data)

    def answer(self, name):
        if self.said is not None:
            return self.said
        counts = self.orientation if name == "QO" else (0, 0, 16384, 0, 0, 0, self.turns, 100, 0, -100)
        return f"{name}={':'.join(map(str, counts))}\r".encode()

    def drop_input(self):
        self.coming = b""

    def drop_output(self):
        pass

    def close(self):
        pass


class Bench:
    def __init__(self, wire=None, **settings):
        self.now = 100.0
        self.told = []
        self.wire = wire or Wire()
        row = KIND.settings(device="imu", **settings)
        signs = LifeSigns(MOST_ALIKE)
        self.unit = AhrsUnit(self.wire, row, lambda kind, text: self.told.append((kind, text)), signs, lambda: self.now)
        self.unit.open()
        self.run(QUIET_S + TICK_S)
        self.wire.asked.clear()

    def run(self, seconds, tick_s=TICK_S):
        samples = []
        for _ in range(round(seconds / tick_s)):
            self.now += tick_s
            samples += self.unit.poll()
        return samples


@pytest.mark.parametrize("echo", [False, True])
def test_samples_come_at_the_rate_set_with_one_query_at_a_time(echo):
    bench = Bench(Wire(echo=echo), echo=echo)
    samples = bench.run(2.0)
    assert len(samples) == pytest.approx(100, abs=5)
    assert all(sample.valid for sample in samples)
    assert samples[0].accel_mps2 == pytest.approx((0.0, 0.0, 9.80665))
    assert samples[0].orientation == (1.0, 0.0, 0.0, 0.0)
    assert bench.wire.asked[:4] in (["QO", "ML", "QO", "ML"], ["ML", "QO", "ML", "QO"])
    assert bench.told == []


def test_a_sample_was_taken_when_it_was_asked_for():
    bench = Bench(orientation=False)
    first = bench.run(0.2)[-1]
    assert first.time_s == pytest.approx(bench.now - TICK_S, abs=TICK_S + 1e-6)
    assert set(bench.wire.asked) == {"ML"}


def test_without_orientation_it_is_null():
    assert Bench(orientation=False).run(0.2)[-1].orientation is None


def test_an_echo_that_was_not_announced_does_no_harm():
    bench = Bench(Wire(echo=True))
    assert all(sample.valid for sample in bench.run(1.0))


def test_with_echo_an_answer_without_it_does_not_count():
    bench = Bench(echo=True)
    assert not any(sample.valid for sample in bench.run(0.4))


def test_an_orientation_of_another_length_is_null_and_told(wording):
    bench = Bench()
    bench.wire.orientation = (8192, 0, 0, 0)
    sample = bench.run(0.1)[-1]
    assert sample.valid
    assert sample.orientation is None
    wording(bench.told[0][1])


def test_a_unit_that_refuses_orientation_is_not_asked_for_it_for_ever():
    bench = Bench(Wire(refused=("QO",)))
    samples = bench.run(1.0)
    assert samples
    assert all(sample.valid and sample.orientation is None for sample in samples)
    assert bench.wire.asked.count("QO") == 2  # and once before
    assert [kind for kind, _ in bench.told] == ["orientation"]


def test_a_unit_that_refuses_motion_measures_nothing():
    bench = Bench(Wire(refused=("ML",)), orientation=False)
    with pytest.raises(DeviceError, match="nothing usable"):
        bench.run(1.0)
    assert bench.told[0][1] == "device 'imu': the unit refuses ?ML; is it a RIOX-1216AHRS?"


def test_a_lost_answer_is_one_invalid_sample_and_a_late_one_is_nobodys():
    bench = Bench()
    bench.run(0.5)
    bench.wire.silent = True
    lost = bench.run(0.12)
    assert [sample.valid for sample in lost][-1] is False
    assert lost[-1].reason.startswith("device 'imu': no answer to ?")
    assert lost[-1].gyro_rps is None
    bench.wire.silent = False
    bench.wire.coming = b"ML=9:9:9:9:9:9:9:9:9:9\r"  # while the line falls quiet
    samples = bench.run(0.5)
    assert all(sample.valid and sample.accel_mps2[0] == 0.0 for sample in samples)


def test_silence_is_a_device_error_after_the_time_set():
    bench = Bench(timeout_s=0.5)
    bench.run(0.5)
    bench.wire.silent = True
    began = bench.now
    with pytest.raises(DeviceError, match=r"'imu': nothing usable for 0\.5 s; check its cable, power and the setting"):
        bench.run(2.0)
    assert 0.45 < bench.now - began < 0.65


def test_a_unit_that_never_answered_has_one_reason_and_is_told_of_once():
    wire = Wire()
    wire.silent = True
    bench = Bench(wire)
    reasons = {re.sub(r"\d", "", sample.reason) for sample in bench.run(0.4)}
    with pytest.raises(DeviceError) as err:
        bench.run(2.0)
    assert reasons == {re.sub(r"\d", "", str(err.value))}
    assert not bench.unit.measured
    assert bench.told == []


def test_noise_counts_as_silence_and_is_told():
    bench = Bench()
    bench.wire.said = b"ML=1:2\xff:4\r"
    with pytest.raises(DeviceError, match=r"\d+ lines"):
        bench.run(2.0)
    assert "bad_lines" in {kind for kind, _ in bench.told}


@pytest.mark.parametrize(
    ("said", "reason"),
    [(b"ML=0:0:0:0:0:0:0:5:5:5\r", "asleep"), (b"ML=-1:-1:-1:-1:-1:-1:-1:-1:-1:-1\r", "ones")],
)
def test_a_reading_that_is_none_is_invalid(said, reason):
    bench = Bench(orientation=False)
    bench.run(0.2)
    bench.wire.said = said
    sample = bench.run(0.1)[-1]
    assert not sample.valid
    assert reason in sample.reason


def test_a_frozen_unit_is_invalid_and_then_an_error():
    bench = Bench(orientation=False)
    bench.wire.frozen = True
    samples = bench.run((MOST_ALIKE + 4) * 0.02)
    assert samples[5].valid
    assert not samples[-1].valid
    assert "frozen" in samples[-1].reason
    with pytest.raises(DeviceError):
        bench.run(1.0)


def test_after_this_process_was_held_up_silence_is_counted_anew():
    bench = Bench()
    bench.run(0.5)
    bench.now += 3.0
    assert any(sample.valid for sample in bench.run(0.5))


def test_over_a_real_line_it_asks_and_publishes_and_tells_when_the_cable_is_pulled(board):
    ctx = DriverContext(KIND, KIND.settings(device="imu"), board.path, "riox")
    imu = KIND.load()(ctx)
    assert isinstance(imu, Riox)
    assert imu.rate_hz == 100.0
    imu.open()
    assert not imu.answers()

    def converse():
        imu.step()
        heard = board.waiting()
        if heard.endswith(b"?QO\r"):
            board.say(b"QO=16384:0:0:0\r")
        elif heard.endswith(b"?ML\r"):
            board.say(b"ML=0:0:163")
            board.say(b"84:0:33:0:0:100:0:-100\r")
        return bool(ctx.published)

    until(converse)
    assert imu.answers()
    output, sample = ctx.published[0]
    assert output == "sample"
    assert sample.gyro_rps[0] == pytest.approx(radians(33 / 32.75))
    assert sample.orientation == (1.0, 0.0, 0.0, 0.0)
    board.unplug()
    with pytest.raises(DeviceError, match="went away"):
        until(imu.step)
    imu.degraded("it went away")
    assert (ctx.state.valid, ctx.state.reason) == (False, "it went away")
    imu.close()
