"""S19: a base that turns by its attitude loses what it turns by, or whoever asked for it."""

import os
import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any

from lbr.errors import BusError
from tests.support.bench import Bench, bench
from tests.support.figures import Results
from tests.support.mover import RENEW_S
from tests.support.robot import Robot
from tests.support.trace import Output

ATTITUDE = "UPDATE capability SET enabled = 1 WHERE name IN ('imu', 'attitude')"
KNOWN_S = 15.0
TURNS_AT = 0.15
WHOLE = {"angle_deg": 360.0}
OLD = "the attitude is older than"
UNKNOWN = "the attitude is not known"
AFTERMATH_S = 0.3
ATTEMPTS = 4


class Turner:
    """Turns under a lease renewed at 10 Hz, and goes on renewing whatever the answers are, until told to cease."""

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._renew, daemon=True)
        self.lease = self.goal = ""

    def start(self) -> bool:
        """Ask once, and go on if it was accepted."""
        reply = self._robot.ask("drive/turn", WHOLE, source="bench")
        if reply is None or not reply["accepted"]:
            return False
        self.lease, self.goal = reply["lease"], reply["goal"]
        self._thread.start()
        return True

    def cease(self) -> None:
        """Send no more."""
        self._over.set()
        self._thread.join()

    def _renew(self) -> None:
        while not self._over.wait(RENEW_S):
            with suppress(BusError, Exception):
                self._robot.put("drive/turn", WHOLE | {"lease": self.lease}, source="bench")


@contextmanager
def robot_with_attitude(results: Results) -> Iterator[Bench]:
    """Run a robot that knows how it lies."""
    with bench(results, edits=(ATTITUDE,)) as under_test:
        yield under_test


def client_gone(under_test: Bench) -> None:
    """Whoever asked for the turn renews it no more."""
    _loses(under_test, lambda turner: turner.cease(), ("not renewed within",))


def imu_killed(under_test: Bench) -> None:
    """Kill the driver of the inertial unit."""
    _killed(under_test, "imu", signal.SIGKILL, (OLD, UNKNOWN))


def attitude_killed(under_test: Bench) -> None:
    """Kill the attitude."""
    _killed(under_test, "attitude", signal.SIGKILL, (OLD,))


def attitude_frozen(under_test: Bench) -> None:
    """Let the attitude stand still."""
    _killed(under_test, "attitude", signal.SIGSTOP, (OLD,))


def drive_killed(under_test: Bench) -> None:
    """Kill the drive operations: nobody is left to say why."""
    _killed(under_test, "drive", signal.SIGKILL, ())


def imu_unplugged(under_test: Bench) -> None:
    """Pull the inertial unit's cable, and plug it in again."""
    try:
        _loses(under_test, lambda _: _said(under_test, "/fault/imu/unplug"), (OLD, UNKNOWN))
    finally:
        _said(under_test, "/fault/imu/unplug/off")


WAYS: tuple[Callable[[Bench], None], ...] = (
    client_gone,
    imu_unplugged,
    attitude_frozen,
    imu_killed,
    attitude_killed,
    drive_killed,
)


def turns_lost(results: Results, n: int) -> None:
    """S19, all ways in turn; processes that are ended too often are not started again, so a robot bears a few rounds."""
    for _ in range(n):
        with robot_with_attitude(results) as under_test:
            for way in WAYS:
                way(under_test)


def _killed(under_test: Bench, name: str, number: int, reasons: tuple[str, ...]) -> None:
    pid = under_test.pid(name)
    _loses(under_test, lambda _: os.kill(pid, number), reasons)
    under_test.ready_again(name, pid, time.monotonic_ns(), limit_s=KNOWN_S)


def _loses(under_test: Bench, lose: Callable[[Turner], object], reasons: tuple[str, ...]) -> None:
    turner = _turning(under_test)
    fault_ns = time.monotonic_ns()
    lose(turner)
    zero = _stopped_after(under_test, fault_ns)
    under_test.pass_time(AFTERMATH_S)
    turner.cease()
    under_test.stays_at_rest(zero)
    if zero is not None and reasons:
        _gives_reason(under_test, turner, reasons)


def _turning(under_test: Bench) -> Turner:
    """Bring it to turn at full rate; on a busy machine a turn may end before it was meant to."""
    for _ in range(ATTEMPTS):
        under_test.until(lambda: _attitude(under_test)["valid"], KNOWN_S, "a valid attitude", every_s=0.02)
        turner = Turner(under_test.robot)
        if turner.start():
            with suppress(AssertionError):
                under_test.until(lambda: under_test.trace.now().least >= TURNS_AT, 1.5, "a turn")
                return turner
            turner.cease()
        under_test.pass_time(RENEW_S)
    raise AssertionError(f"the robot does not turn; {under_test.state()}")


def _stopped_after(under_test: Bench, fault_ns: int) -> Output | None:
    zero = under_test.trace.first_zero(fault_ns, 3.0)
    before = under_test.trace.at(fault_ns)
    if not before.least >= TURNS_AT:
        under_test.results.disturbed.append(f"S19: the motors were at {before.left:g} {before.right:g} before")
    elif zero is None:
        under_test.results.check("S19", ["the base still turns 3 s after the fault"])
    else:
        under_test.results.sample("S19", (zero.at_ns - fault_ns) * 1e-6)
    return zero


def _gives_reason(under_test: Bench, turner: Turner, reasons: tuple[str, ...]) -> None:
    result: dict[str, Any] = under_test.answer("drive/result")
    told = str(result["reason"])
    known = result["goal"] == turner.goal and any(reason in told for reason in reasons)
    if not known:
        under_test.results.disturbed.append(f"S19: the turn ended otherwise: {told}")


def _attitude(under_test: Bench) -> dict[str, Any]:
    return under_test.robot.ask("attitude/state", timeout_s=0.5) or {"valid": False}


def _said(under_test: Bench, line: str) -> None:
    said = under_test.robot.line(line)
    assert said["code"] == 0, said
