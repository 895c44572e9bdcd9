"""The duties of every driver of servos, tried on its twin, whose servos follow their goals.

    @pytest.mark.parametrize("check", lbr.testing.servos.CHECKS)
    def test_my_servos(check, tmp_path):
        with lbr.testing.servos.bench(KIND, tmp_path, ids=(1, 2)) as servos:
            check(servos)

The checks examine the twin's motors, not the driver's reports.
"""

import json
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from math import copysign
from pathlib import Path
from threading import Lock
from typing import Any

from lbr.capability.context import Device
from lbr.capability.kind import Kind
from lbr.capability.registry import find
from lbr.messages.joints import Joint
from lbr.messages.servos import ServoGoal, ServoSetpoint, ServosState
from lbr.simulation.measured import ServoFelt
from lbr.simulation.twins import ServoBus, Twin
from lbr.testing import driver, driver_process
from lbr.testing.device import SUPPLY_V, Plugged, elsewhere, plugged
from lbr.testing.driver import WITHIN_S, DriverBench

HOLD_S = RELEASE_S = 0.5
MOST_RPS = 0.6
"""The greatest speed of a servo on this bench, so that one without a speed register can also be stopped on its way."""
AT_RAD = 0.05
"""The tolerance of an arrival: a servo's margin and two degrees more."""
STOOD_RAD = 0.15
"""The way that a servo may continue after a stop was seen: a quarter of a second, as the machine may be busy."""
WATCHED_S = 0.6
WEAKENED = 0.8
"""A servo with less of its torque than this has begun to fade."""
GUARD_S = 8.0
"""By then, after the driver was killed, servos were held, faded and switched off."""
ABSENT = 200
SOURCE = "joints"
REACH_RAD = 1.5
BEGIN_RAD = 0.2


class Shafts:
    """The servos' shafts, without weight: one with torque turns to its goal, one without stays where it is.

    It is the `live` of a plugged-in twin. Each begins a little further than the one before, so that no register's
    default equals its angle.
    """

    def __init__(self, ids: Sequence[int]) -> None:
        self._lock = Lock()
        self._at = {servo: BEGIN_RAD + 0.05 * place for place, servo in enumerate(ids)}
        self._torque = dict.fromkeys(ids, 0.0)
        self._most = dict.fromkeys(ids, 0.0)
        self._weakened: set[int] = set()
        self._now = time.monotonic()

    def __call__(self, twin: Twin, now: float) -> None:
        """Let time pass: turn the servos with torque, and set the twin's measurements."""
        assert isinstance(twin, ServoBus), f"{twin.name}: its twin has neither `drives` nor `feel_servos`"
        drives = twin.drives(now)
        with self._lock:
            passed_s, self._now = now - self._now, now
            speeds = dict.fromkeys(self._at, 0.0)
            for servo, at in self._at.items():
                drive = drives.get(servo)
                torque = self._torque[servo] = drive.torque if drive is not None else 0.0
                self._most[servo] = max(self._most[servo], torque)
                if 0.0 < torque < WEAKENED * self._most[servo]:
                    self._weakened.add(servo)
                if drive is None or not drive.torque > 0.0:
                    continue
                way = drive.goal_rad - at
                step = copysign(min(abs(way), min(MOST_RPS, drive.speed_rps or MOST_RPS) * passed_s), way)
                self._at[servo] = at + step
                speeds[servo] = step / passed_s if passed_s > 0.0 else 0.0
            felt = {servo: ServoFelt(position_rad=at, speed_rps=speeds[servo]) for servo, at in self._at.items()}
        twin.feel_servos(felt, SUPPLY_V, now)

    def push(self, way_rad: float) -> None:
        """Turn all of them by hand."""
        with self._lock:
            self._at = {servo: at + way_rad for servo, at in self._at.items()}

    def at(self) -> dict[int, float]:
        """Return the angle of each servo, in radians from its middle."""
        with self._lock:
            return dict(self._at)

    def weakened(self) -> bool:
        """Return whether each servo had some torque at some time, but clearly less than before."""
        with self._lock:
            return len(self._weakened) == len(self._at)

    def torque(self) -> dict[int, float]:
        """Return the share of its torque that each servo's motor has."""
        with self._lock:
            return dict(self._torque)


class ServosBench(DriverBench):
    """A driver of servos beside its twin, and the sender of its setpoints: each step sends `goals`, None is silence."""

    def __init__(
        self, kind: Kind, settings: Mapping[str, object], device: Plugged, shafts: Shafts, *, fades: bool = True
    ) -> None:
        self.ids = tuple(shafts.at())
        self.fades = fades
        self.shafts = shafts
        self.row = {"device": device.device.name, "guard": False, "hold_s": HOLD_S, "release_s": RELEASE_S, **settings}
        super().__init__(kind, json.dumps(self.row), device, wired={"setpoint": (SOURCE,)}, given=joints(self.ids))
        self.goals: Callable[[], tuple[ServoGoal, ...]] | None = None
        self.halts = 0

    def until(self, condition: Callable[[], object], what: str) -> None:
        """Step until a condition holds; each step sends the setpoint."""

        def sent() -> object:
            if self.goals is not None:
                setpoint = ServoSetpoint(goals=self.goals(), halt=self.halts)
                self.ctx.arrive("setpoint", setpoint, source=SOURCE)
            return condition()

        super().until(sent, what)

    def steps(self, seconds: float) -> None:
        """Step for a while."""
        end = time.monotonic() + seconds
        self.until(lambda: time.monotonic() >= end, "time passes")

    def stay(self) -> None:
        """Give each servo torque at its present angle."""
        self.goals = lambda: tuple(ServoGoal(id=servo) for servo in self.ids)

    def turn(self, way_rad: float) -> None:
        """Move the goals of all servos by this angle."""
        goals = tuple(ServoGoal(id=servo, position_rad=at + way_rad) for servo, at in self.shafts.at().items())
        self.goals = lambda: goals

    def limp(self) -> None:
        """Give no servo torque."""
        self.goals = lambda: tuple(ServoGoal(id=servo, torque=0.0) for servo in self.ids)
        self.until(lambda: not any(self.shafts.torque().values()), f"none has torque: {self._torques()}")

    def energised(self) -> None:
        """Wait until each servo has torque."""
        self.works()
        self.stay()
        self.until(lambda: all(self.shafts.torque().values()), f"all have torque: {self._torques()}")

    def moved_rad(self, since: Mapping[int, float]) -> float:
        """Return the greatest movement of a servo."""
        return max(abs(at - since[servo]) for servo, at in self.shafts.at().items())

    @property
    def state(self) -> ServosState:
        """Return the newest state of the driver."""
        found = self.ctx.said("state")[-1]
        assert isinstance(found, ServosState)
        return found

    def _torques(self) -> str:
        return ", ".join(f"servo {servo} {torque:g}" for servo, torque in self.shafts.torque().items())


def joints(ids: Sequence[int]) -> tuple[Joint, ...]:
    """Return a joint row for each servo."""
    return tuple(
        Joint(name=f"joint_{servo}", device_id=servo, lower_rad=-REACH_RAD, upper_rad=REACH_RAD, speed_rps=3.0)
        for servo in ids
    )


@contextmanager
def bench(
    kind: Kind,
    folder: Path,
    *,
    ids: Sequence[int] = (1, 2),
    settings: Mapping[str, object] | None = None,
    device: Mapping[str, object] | None = None,
    fades: bool = True,
) -> Iterator[ServosBench]:
    """Plug in the twin of a kind's device, with servos that turn, and put the driver beside it.

    `settings` are the capability's besides the usual ones, `device` those of the twin's row. `fades` false: these
    servos have no torque limit, so their torque goes off at once.
    """
    shafts = Shafts(ids)
    with plugged(kind.device_type, folder, settings=dict(device or {}), live=shafts) as found:
        made = ServosBench(kind, settings or {}, found, shafts, fades=fades)
        try:
            yield made
        finally:
            made.close()


def moves_nothing_when_it_opens(servos: ServosBench) -> None:
    """Before the first setpoint no servo gets torque. The driver knows each servo's angle."""
    servos.works()
    began = servos.shafts.at()
    servos.until(lambda: _positions_known(servos), "each servo's position is reported")
    servos.steps(WATCHED_S)
    assert not any(servos.shafts.torque().values()), "a servo got torque that nobody wanted"
    assert servos.moved_rad(began) == 0.0
    for servo in servos.state.servos:
        true = began[servo.id]
        assert servo.position_rad is not None
        assert abs(servo.position_rad - true) < AT_RAD, (
            f"servo {servo.id} is at {true:.3f} rad and the driver reports {servo.position_rad:.3f}: driver and twin "
            "read the data sheet in two ways"
        )


def switches_torque_on_where_the_servos_are(servos: ServosBench) -> None:
    """Torque comes on without a jerk, even after a hand has turned servos with an old goal."""
    for way_rad in (0.0, 0.4):
        servos.shafts.push(way_rad)
        began = servos.shafts.at()
        servos.works()
        servos.until(lambda: _true(servos), "the driver reports their positions")
        servos.energised()
        servos.steps(WATCHED_S)
        assert all(servos.shafts.torque().values()), "a servo lost its torque again"
        gone = servos.moved_rad(began)
        assert gone < AT_RAD, (
            f"a servo turned by {gone:.3f} rad when it got torque: write where it is as its goal first"
        )
        servos.limp()


def follows_its_goals(servos: ServosBench) -> None:
    """Goals are followed to their end, and reported truly."""
    servos.energised()
    for way_rad in (0.5, -0.8):
        began = servos.shafts.at()
        servos.turn(way_rad)
        servos.until(
            lambda began=began, way_rad=way_rad: all(  # type: ignore[misc]
                abs(at - began[servo] - way_rad) < AT_RAD for servo, at in servos.shafts.at().items()
            ),
            f"all have turned by {way_rad:g} rad",
        )
        servos.until(lambda: _true(servos), "the driver reports their positions")


def stays_where_it_is_stopped(servos: ServosBench) -> None:
    """A stop holds each servo where it is, with torque."""
    servos.energised()
    began = servos.shafts.at()
    servos.turn(1.0)
    servos.until(lambda: servos.moved_rad(began) > 0.2, "they move")
    servos.stay()
    servos.halts += 1
    _stands(servos, "it was stopped")


def holds_in_an_emergency_stop(servos: ServosBench) -> None:
    """Once it has acknowledged, nothing moves, whatever setpoints still come."""
    servos.energised()
    began = servos.shafts.at()
    servos.turn(1.0)
    servos.until(lambda: servos.moved_rad(began) > 0.2, "they move")
    servos.ctx.estop.engaged = True
    servos.until(lambda: any(stopped for stopped, _ in servos.ctx.estop.acknowledged), "the stop is acknowledged")
    if servos.row.get("on_estop") == "release":
        assert not any(servos.shafts.torque().values()), "it acknowledged, and a servo has torque"
        return
    _stands(servos, "the emergency stop was acknowledged")


def lets_go_of_what_nobody_moves(servos: ServosBench) -> None:
    """When setpoints cease, servos hold for `hold_s`, fade for `release_s`, and then have no torque."""
    servos.energised()
    began = servos.shafts.at()
    servos.turn(1.0)
    servos.until(lambda: servos.moved_rad(began) > 0.2, "they move")
    servos.goals, ceased = None, time.monotonic()
    servos.until(lambda: servos.state.phase != "following", "the silence is noticed")
    stood = servos.shafts.at()
    servos.until(lambda: not any(servos.shafts.torque().values()), "all are without torque")
    _let_go_in_time(servos, ceased, stood)


def goes_on_without_a_servo_that_is_absent(servos: ServosBench) -> None:
    """A joint row whose servo does not answer is named, and delays none of the others."""
    servos.ctx.given = joints((*servos.ids, ABSENT))
    servos.driver = servos.kind.load()(servos.ctx)
    servos.energised()
    servos.until(lambda: any(one.id == ABSENT and one.reason for one in servos.state.servos), f"{ABSENT} is missed")
    said = " ".join(servos.ctx.health)
    assert f"joint_{ABSENT}" in said, f"nothing names joint_{ABSENT}: {said}"
    began = servos.shafts.at()
    servos.turn(0.4)
    servos.until(lambda: servos.moved_rad(began) > 0.3, "the others move")


def is_outlived_by_its_guard(servos: ServosBench) -> None:
    """When the driver is killed while servos move, its guard holds them where they are, and then takes their torque.

    The driver runs in a process of its own, so the kind must be installed.
    """
    row = {**servos.row, "guard": True}
    began = servos.shafts.at()
    process = driver_process.started({**servos.as_json(), "ids": servos.ids, "row": row}, "lbr.testing.servos")
    try:
        driver_process.wait_until_it_works(process, 2.0 * WITHIN_S)
        end = time.monotonic() + WITHIN_S
        while servos.moved_rad(began) < 0.2:
            assert time.monotonic() < end, "nothing moved"
            time.sleep(0.005)
    finally:
        driver_process.kill(process)
    killed = time.monotonic()
    time.sleep(HOLD_S / 2.0)
    stood = servos.shafts.at()
    held = all(servos.shafts.torque().values()) or time.monotonic() - killed > HOLD_S
    assert held, "a servo was let go at once: the guard is to hold it first"
    end = killed + GUARD_S
    while any(servos.shafts.torque().values()):
        assert time.monotonic() < end, f"servos have torque {GUARD_S:g} s after their driver was killed: no guard acted"
        time.sleep(0.005)
    _let_go_in_time(servos, killed, stood)


CHECKS: tuple[Callable[[ServosBench], None], ...] = (
    *driver.CHECKS,
    moves_nothing_when_it_opens,
    switches_torque_on_where_the_servos_are,
    follows_its_goals,
    stays_where_it_is_stopped,
    holds_in_an_emergency_stop,
    lets_go_of_what_nobody_moves,
    goes_on_without_a_servo_that_is_absent,
    is_outlived_by_its_guard,
)
"""All of these checks, with those of every driver."""


def _positions_known(servos: ServosBench) -> bool:
    return bool(servos.state.servos) and all(one.position_rad is not None for one in servos.state.servos)


def _true(servos: ServosBench) -> bool:
    at = servos.shafts.at()
    return all(
        one.position_rad is not None and abs(one.position_rad - at[one.id]) < AT_RAD for one in servos.state.servos
    )


def _stands(servos: ServosBench, why: str) -> None:
    stood = servos.shafts.at()
    servos.steps(WATCHED_S)
    gone = servos.moved_rad(stood)
    assert gone < STOOD_RAD, f"a servo went on by {gone:.3f} rad after {why}"
    assert all(servos.shafts.torque().values()), f"a servo has no torque after {why}: it is to hold"


def _let_go_in_time(servos: ServosBench, since: float, stood: Mapping[int, float]) -> None:
    passed_s, gone = time.monotonic() - since, servos.moved_rad(stood)
    assert passed_s > 0.8 * HOLD_S, f"servos were let go after {passed_s:.2f} s, and hold_s is {HOLD_S:g}"
    assert gone < STOOD_RAD, f"a servo went on by {gone:.3f} rad that nobody moved any more"
    assert servos.shafts.weakened() or not servos.fades, (
        "torque went at once, and an arm falls then: `write_limits` is to make it less before; or have the bench know "
        "that these servos cannot (fades=False)"
    )


def _drive_until_killed(bench_json: Mapping[str, Any]) -> None:
    kind = find(bench_json["kind"], Path("/nonexistent"))
    shafts = Shafts(bench_json["ids"])
    servos = ServosBench(kind, bench_json["row"], elsewhere(Device(**bench_json["device"])), shafts)
    servos.works()
    servos.stay()
    servos.until(lambda: servos.state.phase == "following" and _torque_known(servos), "torque")
    servos.turn(1.0)
    print(driver_process.WORKS, flush=True)
    while True:
        servos.steps(WATCHED_S)


def _torque_known(servos: ServosBench) -> bool:
    return all(one.torque for one in servos.state.servos)


if __name__ == "__main__":
    _drive_until_killed(json.loads(sys.argv[1]))
