"""The stops of wheels, each layer alone, measured by the power of the twin, not by the driver's report.

`pytest.mark.parametrize("check", CHECKS)`, then `check(bench)`, beside those of `lbr.testing.driver`. The twin has the
fault `no_watchdog`, with which the controller does not stop by itself.
"""

import os
import signal
import subprocess
import time
from collections.abc import Callable, Mapping
from typing import Any

import msgspec

from lbr.simulation.twins import MotorDrive, WheelDrive
from lbr.testing import driver_process
from lbr.testing.driver import POWER, STOPS_WITHIN_S, WITHIN_S, DriverBench

STARTS_S = 20.0
"""The time for a process and its guard to begin: nothing moves before."""
BEYOND_WATCHDOG_S = 0.5
"""The delay that the controller may have after its own watchdog's time, on a busy machine."""


def turns_each_motor_its_own_way(bench: DriverBench) -> None:
    """Each motor by itself turns in the direction of its setpoint, reversed if its row mounts it so.

    There is no guard, since it would end this process after a delay.
    """
    alone = {"guard": False} if hasattr(bench.ctx.settings, "guard") else {}
    _each_way(bench.again(**alone), {})
    for side in ("left", "right"):
        mounted = msgspec.to_builtins(getattr(bench.ctx.settings, side, None))
        if isinstance(mounted, dict) and "direction" in mounted:
            turned = bench.again(**alone, **{side: mounted | {"direction": -mounted["direction"]}})
            _each_way(turned, {side: -1.0})


def stops_by_its_guard_alone(bench: DriverBench) -> None:
    """With the controller's watchdog broken, the guard stops every motor after a driver was killed or frozen."""
    assert bench.faults().get("no_watchdog") is False, f"the twin of {bench.kind.name} needs the fault 'no_watchdog'"
    bench.device.fault("no_watchdog")
    guarded = bench.again(guard=True)
    _stops(guarded, signal.SIGKILL, STOPS_WITHIN_S, "its guard, after it was killed")
    frozen = _stops(guarded, signal.SIGSTOP, STOPS_WITHIN_S, "its guard, while it was frozen")
    assert frozen == -signal.SIGKILL, f"{bench.kind.name}: its guard leaves a frozen driver alive"
    bench.device.fault("no_watchdog", value=False)


def stops_by_its_watchdog_alone(bench: DriverBench) -> None:
    """There is no guard: after a driver that is killed or frozen the controller's watchdog stops every motor in
    time."""
    alone = bench.again(guard=False)
    watchdog_ms = getattr(alone.ctx.settings, "watchdog_ms", None)
    limit_s = STOPS_WITHIN_S if watchdog_ms is None else watchdog_ms / 1000.0 + BEYOND_WATCHDOG_S
    _stops(alone, signal.SIGKILL, limit_s, "its controller's watchdog, after it was killed")
    _stops(alone, signal.SIGSTOP, limit_s, "its controller's watchdog, while it was frozen")


def _each_way(bench: DriverBench, mounted: Mapping[str, float]) -> None:
    """Turn each motor alone, both ways; `mounted` has -1 for one that turns against its setpoint."""
    motors = _powers(bench, time.monotonic())
    for name in motors:
        for way in (1.0, -1.0):
            powers = dict.fromkeys(motors, 0.0) | {name: way * POWER}
            wanted = {motor: _sign(power * mounted.get(motor, 1.0)) for motor, power in powers.items()}
            bench.drives(powers)

            def turns(powers: dict[str, float] = powers, wanted: dict[str, int] = wanted) -> bool:
                bench.drive(powers)
                return {motor: _sign(power) for motor, power in _powers(bench, time.monotonic()).items()} == wanted

            bench.until(turns, f"of its motors '{name}' alone turns, in the commanded direction ({way:+g})")
    bench.close()


def _stops(bench: DriverBench, number: signal.Signals, limit_s: float, by: str) -> int | None:
    """Send a signal to a driver in a process of its own while all motors turn, each opposite to the one before.

    Return the exit code of a frozen driver once all motors stand still; None without one, or for a killed driver.
    """
    ways = (1.0, -1.0) if number is signal.SIGKILL else (-1.0, 1.0)
    powers = {name: POWER * ways[n % 2] for n, name in enumerate(_powers(bench, time.monotonic()))}
    process = driver_process.started(bench.as_json(powers))
    try:
        driver_process.wait_until_it_works(process, STARTS_S)
        _wait(lambda now: all(_powers(bench, now).values()), WITHIN_S, f"{bench.kind.name}: its motors do not all turn")
        os.kill(process.pid, number)
        text = f"{bench.kind.name}: its motors turn on, and are to be stopped by {by}"
        _wait(lambda now: not any(_powers(bench, now).values()), limit_s, text)
        return _ended(process) if number is signal.SIGSTOP else None
    finally:
        driver_process.kill(process)


def _ended(process: "subprocess.Popen[str]") -> int | None:
    try:
        return process.wait(STOPS_WITHIN_S)
    except subprocess.TimeoutExpired:
        return None


def _wait(condition: Callable[[float], object], within_s: float, text: str) -> None:
    end = time.monotonic() + within_s
    while not condition(now := time.monotonic()):
        assert now < end, text
        time.sleep(0.005)


def _powers(bench: DriverBench, now: float) -> dict[str, float]:
    """Return the power that the twin gives each motor, forward positive."""
    twin: Any = bench.device.twin
    if isinstance(twin, WheelDrive):
        return dict(zip(("left", "right"), twin.wheels(now), strict=True))
    assert isinstance(twin, MotorDrive), f"the twin of {bench.kind.name} turns no motors"
    return dict(twin.motors(now))


def _sign(power: float) -> int:
    return (power > 0.0) - (power < 0.0)


CHECKS: tuple[Callable[[DriverBench], None], ...] = (
    turns_each_motor_its_own_way,
    stops_by_its_guard_alone,
    stops_by_its_watchdog_alone,
)
"""All of these checks."""
