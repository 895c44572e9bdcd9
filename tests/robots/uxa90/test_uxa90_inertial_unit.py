"""The main board's inertial unit as the driver asks it, against the emulated board; the time between them is the test's."""

from itertools import pairwise

import pytest

from lbr.robots.uxa90.driver import ImuSettings, frames
from lbr.robots.uxa90.driver.bus import Bus
from lbr.robots.uxa90.driver.frames import Frame, FrameParser
from lbr.robots.uxa90.driver.inertial_unit import AGAIN_S, MISSES, NOT_ASKED, SILENT, UNMEASURED, InertialUnit
from lbr.simulation.measured import ImuReading
from tests.robots.uxa90.test_uxa90_with_twin import IDS, Rig

LIES = (-9.81, 0.0, 0.5)
"""What is felt on its face."""


class Unit(Rig):
    """Servos that are swept, and between them the inertial unit."""

    def __init__(self, imu=None, **row):
        super().__init__(**row)
        self.bus = Bus(self.line, 0.03, clock=lambda: self.line.now, unsummed=(frames.IMU,))
        self.board.imu = ImuReading(accel_mps2=LIES)
        self.unit = InertialUnit(imu or ImuSettings(asked="simulated"), simulated=True)
        self.samples = []

    def turn(self, seconds):
        until_s = self.line.now + seconds
        while self.line.now < until_s:
            unit_s = self.unit.turn(self.bus, self.line.now)
            self.line.now += min(unit_s, self.poller.turn(self.bus), 0.01)
            while self.bus.board_frames:
                self.take(self.unit.hear(self.bus.board_frames.popleft(), self.line.now))
            self.take(self.unit.missed(self.line.now))

    def take(self, sample):
        self.samples += [] if sample is None else [sample]


def test_it_is_asked_between_servos_which_are_all_believed_meanwhile():
    rig = Unit()
    rig.turn(2.0)
    assert all(sample.valid for sample in rig.samples)
    assert 15 <= len(rig.samples) <= 21
    assert all(one.time_s < other.time_s for one, other in pairwise(rig.samples))
    assert rig.samples[-1].accel_mps2 == pytest.approx(LIES, abs=0.03)
    assert rig.samples[-1].gyro_rps is None
    assert sorted(rig.believed()) == list(IDS)
    assert rig.bus.counts.timeouts == 0


def test_a_unit_of_another_make_is_a_matter_of_settings():
    rig = Unit(ImuSettings(asked="always", gravity_sign=-1, lsb_per_g=512.0), imu_sum=False)
    rig.turn(0.5)
    assert rig.samples[-1].accel_mps2 == pytest.approx([-part / 2.0 for part in LIES], abs=0.03)
    unit = InertialUnit(ImuSettings(asked="always", order="little", lsb_per_g=1.0), simulated=False)
    heard = unit.hear(Frame(frames.IMU, 4, bytes((1, 0, 0xFE, 0xFF, 0, 1))), 5.0)
    assert heard.accel_mps2 == pytest.approx([9.80665, -2 * 9.80665, 256 * 9.80665])


@pytest.mark.parametrize("contents", [bytes(6), b"\xff" * 6, b"\x80\x00" * 3, b"\x7f\xff\x00\x01\x00\x01"])
def test_what_no_unit_measures_is_no_sample(contents):
    heard = InertialUnit(ImuSettings(asked="always"), simulated=False).hear(Frame(frames.IMU, 4, contents), 5.0)
    assert not heard.valid
    assert heard.reason == UNMEASURED


def test_one_that_does_not_answer_is_asked_seldom_and_again_once_it_does():
    rig = Unit()
    rig.suffer(silent=True)
    rig.poller.reading = False
    rig.turn(3.0)
    assert [sample.reason for sample in rig.samples] == [SILENT] * MISSES
    rig.suffer()
    rig.turn(AGAIN_S)
    assert rig.samples[-1].valid
    assert len([one for one in rig.samples if one.valid]) > 1


def test_on_hardware_it_is_not_asked_unless_the_row_says_so():
    rig = Unit()
    rig.unit = InertialUnit(ImuSettings(asked="simulated"), simulated=False)
    assert not rig.unit.asked
    assert [rig.unit.missed(now) is None for now in (10.0, 10.5, 11.0)] == [False, True, False]
    assert rig.unit.missed(12.0).reason == NOT_ASKED
    assert InertialUnit(ImuSettings(asked="always"), simulated=False).asked
    assert not InertialUnit(ImuSettings(), simulated=True).asked


def test_a_sum_that_is_wrong_counts_only_where_sums_are_right():
    data = frames.encode(Frame(frames.IMU, 4, b"\x01\x02\x03\x04\x05\x06"))
    spoilt = data[:-1] + bytes((data[-1] ^ 0x5A,))
    assert FrameParser((frames.IMU,)).feed(spoilt)[0] == [Frame(frames.IMU, 4, b"\x01\x02\x03\x04\x05\x06")]
    assert FrameParser().feed(spoilt)[0] == []
