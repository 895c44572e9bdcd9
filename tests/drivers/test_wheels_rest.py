"""Drive and driver of wheels in one virtual time: a base that rested moves as one that is told zero all the time."""

from itertools import pairwise
from math import inf
from random import Random

import pytest
from msgspec.structs import replace

from lbr.drivers.wheels.capability import BEGINS_S
from lbr.messages.motors import MotorsState
from lbr.operations.drive.capability import Drive
from tests.drivers.wheel_line import WheelBench
from tests.operations.drive.drive_bench import ranges
from tests.operations.drive.drive_context import DriveContext

STEP_S = 0.001
ACCEL_PER_S = 2.0
ROUND = 25
"""A round of the loop, and what the controller's answers take, in steps."""
STEP = ACCEL_PER_S * ROUND * STEP_S


class Restless(Drive):
    """A drive that says zero fifty times a second."""

    def rests(self) -> bool:
        return False


class Pair:
    """A drive and its driver, each stepped when it is due or woken."""

    def __init__(self, kind: type[Drive], lost: float = 0.0, seed: int = 0, band: int = 2) -> None:
        self.bench = WheelBench(f'"guard": false, "still_counts": {band}')
        self.bench.motors.open()
        self.ctx = DriveContext(accel_per_s=ACCEL_PER_S)
        self.ctx.now = self.bench.ctx.now
        self.drive = kind(self.ctx)
        self.drive.open()
        self.now = self.ctx.now
        self.said = 0
        self.powers: list[float] = []
        self.lease = ""
        self.lost = lost
        self.silent = False
        self._random = Random(seed)
        self._drive_due = self._driver_due = self._sense_at = -inf

    def order(self, word: str) -> None:
        call = self.ctx.stop() if word == "stop" else self.ctx.command(0.4, lease=self.lease)
        self.drive.command(call)
        self.lease = call.answer.lease or (self.lease if call.answer.accepted and word != "stop" else "")
        self._drive_due = -inf

    def pass_time(self, seconds: float) -> None:
        until = self.now + seconds
        while self.now < until:
            self.now += STEP_S
            self.ctx.now = self.now
            self._sense()
            self._drive_step()
            self._driver_step()
            left, right = self.bench.line.device.outputs(max(self.now, self.bench.ctx.now))
            assert left == right
            self.powers.append(left)

    def _sense(self) -> None:
        if self.now >= self._sense_at:
            self._sense_at = self.now + 0.1
            self.ctx.arrive("ranges", ranges())

    def _drive_step(self) -> None:
        if self.silent:
            return
        if self.now >= self._drive_due:
            self.drive.step()
            self._drive_due = self.now + 1.0 / self.drive.rate_hz
        setpoints = self.ctx.said("setpoint")
        for setpoint in setpoints[self.said :]:
            self.said += 1
            if self._random.random() >= self.lost:
                self.bench.ctx.now = max(self.bench.ctx.now, self.now)
                self.bench.ctx.arrive("setpoint", setpoint, source="drive")
                self._driver_due = -inf

    def _driver_step(self) -> None:
        if self.bench.ctx.now > self.now or self.now < self._driver_due:
            return
        self.bench.ctx.now, told = self.now, len(self.bench.ctx.published)
        self.bench.motors.step()
        self._driver_due = self.now + 1.0 / self.bench.motors.rate_hz
        for _, state in self.bench.ctx.published[told:]:
            assert isinstance(state, MotorsState)
            self.ctx.arrive("motors", state)
            self._drive_due = -inf


def history(seed: int) -> list[tuple[str, float]]:
    random, told = Random(seed), [("", 1.0)]
    for _ in range(5):
        told.append(("go", random.choice([0.05, 0.2])))
        told += [("renew", 0.1)] * random.randrange(4)
        told.append((random.choice(["stop", "", ""]), random.choice([0.02, 0.3, 0.7, 1.3, 2.6])))
    return told


def live(pair: Pair, told: list[tuple[str, float]]) -> Pair:
    for word, seconds in told:
        if word:
            pair.order(word)
        pair.pass_time(seconds)
    return pair


def largest_step(pair: Pair) -> float:
    return max(after - before for before, after in zip(pair.powers, pair.powers[1:], strict=False))


@pytest.mark.parametrize("seed", range(2))
def test_a_base_that_rests_moves_when_one_does_that_is_told_zero_all_the_time(seed: int) -> None:
    rests, restless = live(Pair(Drive), history(seed)), live(Pair(Restless), history(seed))
    assert max(rests.powers) > 0.09
    for at, power in enumerate(rests.powers):
        around = restless.powers[max(0, at - ROUND) : at + ROUND + 1]
        assert min(around) - STEP <= power <= max(around) + STEP, f"after {at * STEP_S:.3f} s"
    assert largest_step(rests) <= largest_step(restless) + ACCEL_PER_S * 5 * STEP_S
    assert rests.said < 0.85 * restless.said
    assert rests.bench.state.trips == restless.bench.state.trips == 0


@pytest.mark.parametrize("seed", range(3))
def test_lost_setpoints_leave_no_jump_after_a_rest(seed: int) -> None:
    pair = live(Pair(Drive, lost=0.6, seed=seed), history(seed))
    assert (
        0.0 < largest_step(pair) <= ACCEL_PER_S * 0.121
    )  # a setpoint is obeyed for 0.1 s after the last one that was heard


@pytest.mark.parametrize("after_s", [0.0, 0.05, 0.3])
def test_a_drive_that_falls_silent_in_motion_is_zero_in_a_tenth_of_a_second_and_at_rest_a_loss(after_s: float) -> None:
    pair = live(Pair(Drive), [("", 2.0), ("go", after_s)])
    pair.silent = True
    pair.pass_time(0.125)
    assert pair.bench.line.device.outputs(pair.bench.ctx.now) == (0.0, 0.0)
    rests = live(Pair(Drive), [("", 2.0)])
    rests.silent = True
    rests.pass_time(1.4)
    assert (rests.bench.state.armed, rests.bench.state.trips) == (False, 0)


def test_motors_at_rest_tell_their_state_twice_a_second_and_a_motion_at_once() -> None:
    pair = live(Pair(Drive), [("", BEGINS_S)])
    assert not any(state.rests for _, state in pair.bench.ctx.published)
    pair.pass_time(1.0)
    published, written = pair.bench.ctx.published, pair.bench.line.written
    published.clear()
    written.clear()
    pair.pass_time(3.0)
    assert 5 <= len(published) <= 7
    for sort in (b"!", b"?~"):  # the controller is fed in half of its watchdog's time, and asked as often
        at = [each for each, data in written if data[:1] in sort]
        assert {round(after - before, 2) for before, after in pairwise(at)} == {0.1}
    assert all(state.rests for _, state in published)
    pair.order("go")
    pair.pass_time(0.03)
    assert not pair.bench.state.rests
    published.clear()
    pair.pass_time(0.2)
    assert len(published) >= 3


@pytest.mark.parametrize(("counts", "band", "ends"), [(2, 2, False), (3, 2, True), (3, 3, False), (1, 0, True)])
def test_wheels_that_are_pushed_end_the_rest_and_an_encoder_that_flickers_does_not(
    counts: int, band: int, ends: bool
) -> None:
    pair = Pair(Drive, band=band)
    device = pair.bench.line.device
    device.measured = replace(device.measured, counts=(1000, 1000))
    live(pair, [("", BEGINS_S + 1.0)])
    device.measured = replace(device.measured, counts=(1000, 1000 + counts))
    told = len(pair.bench.ctx.published)
    pair.pass_time(0.3)  # less than the period of the state at rest
    assert any(not state.rests for _, state in pair.bench.ctx.published[told:]) is ends
    pair.pass_time(0.9)
    assert abs(pair.bench.state.counts_right) == 1000 + counts


def test_a_drive_whose_process_is_gone_at_rest_is_a_loss_at_once() -> None:
    rests = live(Pair(Drive), [("", 2.0)])
    rests.bench.ctx.gone.add("drive")
    rests.pass_time(0.11)
    assert not rests.bench.state.armed
    assert "'drive' is not on the bus" in rests.bench.state.reason
