"""Measures the rates of reading and commanding the UXA-90's servos, and counts readings attributed to the wrong servo.

`python -m benchmarks uxa90_line [--bytes N] [--json FILE]`. The driver runs in this process. At the other end of a pty,
in a process of its own, is the emulated main board with 25 servos at 115200 baud (a servo answers after 1 to 1.3 ms),
or servos at the end of a bad line that knows the truth. Exit code 1 if a false reading was accepted, or after a crash.
"""

import argparse
import random
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from itertools import count
from pathlib import Path
from typing import Any

import msgspec

from benchmarks import Measured
from lbr.capability.context import Device
from lbr.messages.joints import Joint
from lbr.messages.servos import ServoGoal, ServoSetpoint, ServosState
from lbr.robots.uxa90.driver import KIND
from lbr.robots.uxa90.driver.capability import Uxa90
from lbr.robots.uxa90.driver.packets import position_rad
from lbr.robots.uxa90.driver.plausibility import TOLERANCE
from lbr.testing.driver import RealTimeContext
from tests.fuzzing.uxa90_answers import Fuzzer, wrong
from tests.support import programs
from tests.support.figures import Promise, Results, percentile
from tests.support.uxa90_wire import chunks, packets

SMOKE = "--bytes 1000 --share 0.1"

SERVOS = range(25)
API_MOTORS = [servo for servo in SERVOS if servo not in (20, 21)]
TICK_S = 0.01
PROMISES = {"uxa90 line": Promise(what="places that the driver trusted on a spoilt line, each where the servo is")}


def options(parser: argparse.ArgumentParser) -> None:
    """Add the amount."""
    parser.add_argument("--bytes", type=int, default=100_000, help="how many spoilt bytes the driver is to meet")
    parser.add_argument("--share", type=float, default=1.0, help="of the time for all else (default %(default)s)")
    parser.add_argument("--seed", type=int, default=1, help="of chance (default %(default)s)")


def measure(given: argparse.Namespace) -> Measured:
    """Read, command, move all, and check every reading."""
    results = Results(PROMISES)
    figures: dict[str, Any] = {
        f"read, {together} in a write": reading(together, 4.0 * given.share) for together in (5, 1)
    }
    figures["told"] = telling(max(10, round(150 * given.share)))
    figures["all moving"] = streaming(5.0 * given.share)
    figures["fuzz"] = found = fuzzing(given.bytes, given.seed, 15.0 * given.share)
    result = results.of("uxa90 line")
    result.checks = found["believed"]
    result.violations = [f"believed of servo {lie[0]}: {lie[1]}, it is at {lie[2]}" for lie in found["wrong"]]
    result.violations += ["the driver crashed"] * found["crashes"]
    return Measured(results=results.ordered(), load=f"{given.bytes} spoilt bytes, seed {given.seed}", figures=figures)


class Driver:
    """The driver in this process, with a setpoint in every step."""

    def __init__(self, path: Path, **settings: Any) -> None:
        row = msgspec.json.encode({"device": "board", "guard": False} | settings).decode()
        self.goals: dict[int, int] = {}
        joints = tuple(
            Joint(name=f"joint_{servo}", device_id=servo, lower_rad=-2.0, upper_rad=2.0, speed_rps=3.0)
            for servo in SERVOS
        )
        device = Device("board", "uxa90", str(path), {})
        self.ctx = RealTimeContext(KIND, KIND.parse(row), name="servos", device=device, given=joints)
        self.ctx.wired["setpoint"] = ("joints",)
        self.driver = Uxa90(self.ctx)
        self.driver.open()

    @property
    def state(self) -> ServosState:
        """Return its last state of the servos."""
        said = [message for _, message in self.ctx.published[-20:] if isinstance(message, ServosState)]
        del self.ctx.published[:-20]
        return said[-1] if said else ServosState(sweep=0, measured_s=0.0, armed=False, phase="released", servos=())

    def tell(self, torque: float = 1.0) -> None:
        """Send the goals and step, as when a setpoint wakes the driver."""
        goals = tuple(
            ServoGoal(id=servo, position_rad=position_rad(self.goals[servo]), torque=torque)
            if servo in self.goals
            else ServoGoal(id=servo, torque=0.0)
            for servo in SERVOS
        )
        self.ctx.arrive("setpoint", ServoSetpoint(goals=goals, lease="a" if self.goals else ""), source="joints")
        self.driver.step()

    def run(self, seconds: float, each: Callable[[], object] = lambda: None) -> None:
        """Run for a while at the joints' rate."""
        until = time.monotonic() + seconds
        while (now := time.monotonic()) < until:
            each()
            self.tell()
            time.sleep(max(0.0, now + TICK_S - time.monotonic()))


def reading(together: int, seconds: float) -> dict[str, float]:
    """Return how often all servos are read while nothing else happens."""
    with _peer("good") as path:
        driver = Driver(path, together=together, sweep_hz=50.0)
        driver.run(seconds)
        driver.driver.close()
    bus = driver.state.bus
    return {"sweeps_hz": bus.sweeps_hz, "sweep_ms": bus.sweep_ms, "states_hz": bus.states_hz}


def telling(times: int) -> dict[str, float]:
    """Return the time of a goal from the driver's step to the main board, and the number of writes for 23 motors."""
    waits_ms, whole, rng = [], 0, random.Random(1)
    with _peer("good") as path:
        trace = path.with_name(path.name + ".trace")
        driver = Driver(path)
        driver.run(1.5)
        places = {state.id: state.raw or 127 for state in driver.state.servos}
        driver.goals = dict(places)
        driver.run(1.0)
        for turn in range(times):
            motors = API_MOTORS if turn % 10 == 9 else [23]
            for servo in motors:
                driver.goals[servo] = places[servo] + 1 + turn % 3
            at = time.monotonic()
            driver.tell()
            driver.run(0.05 + 0.02 * rng.random())
            moves = [(chunk.at, _moved(chunk.data)) for chunk in chunks(trace) if chunk.at >= at]
            told = [(when, servos) for when, servos in moves if servos]
            if len(motors) > 1:
                whole += any(servos == motors for _, servos in told)
            elif told:
                waits_ms.append((told[0][0] - at) * 1000.0)
        driver.driver.close()
    return {
        "p50_ms": round(percentile(waits_ms, "p50"), 2),
        "p99_ms": round(percentile(waits_ms, "p99"), 2),
        "max_ms": round(max(waits_ms), 2),
        "moves": len(waits_ms),
        "multi_moves": times // 10,
        "multi_moves_in_one_write": whole,
    }


def streaming(seconds: float) -> dict[str, float]:
    """Return the age of positions while every servo gets a new goal in each cycle."""
    ages: list[float] = []
    with _peer("good") as path:
        driver = Driver(path)
        driver.run(1.5)
        places = {state.id: state.raw or 127 for state in driver.state.servos}
        driver.goals = dict(places)
        driver.run(1.0)
        turns = count()

        def sway() -> None:
            turn = next(turns)
            driver.goals = {servo: place + abs(turn % 20 - 10) for servo, place in places.items()}
            ages.extend(state.age_s for state in driver.state.servos if state.age_s is not None)

        driver.run(seconds, sway)
        bus, mode = driver.state.bus, driver.state.mode
        driver.driver.close()
    assert mode == "pc"
    return {
        "sweeps_hz": bus.sweeps_hz,
        "states_hz": bus.states_hz,
        "age_p50_ms": round(percentile(ages, "p50") * 1000.0, 1),
        "age_p99_ms": round(percentile(ages, "p99") * 1000.0, 1),
        "strays": bus.strays,
        "timeouts": bus.timeouts,
    }


def fuzzing(enough: int, seed: int, good_s: float) -> dict[str, Any]:
    """Return the accepted readings on a line until this many bytes were spoilt, and those after it is good again."""
    truth = Fuzzer(seed=seed).truth
    lies: set[tuple[int, int, int]] = set()
    crashes, looks, began = 0, 0, time.monotonic()
    with _peer("bad", str(seed)) as path:
        spoilt = path.with_name("spoilt")
        driver = Driver(path, reply_s=0.01)
        while _number(spoilt) < enough:
            try:
                driver.run(0.1)
            except Exception as err:  # noqa: BLE001  that is what is counted
                print(f"crash: {err!r}", file=sys.stderr)
                crashes += 1
                driver.driver.close()
                driver.driver.open()
            believed = {state.id: state.raw for state in driver.state.servos if state.trusted}
            looks += len(believed)
            lies |= set(wrong(believed, truth, TOLERANCE))
        path.with_name("good").touch()
        driver.run(good_s)
        after = {state.id: state.raw for state in driver.state.servos if state.trusted}
        driver.driver.close()
        found = _number(spoilt)
    return {
        "spoilt_bytes": found,
        "seconds": round(time.monotonic() - began, 1),
        "crashes": crashes,
        "believed": looks,
        "wrong": sorted(lies),
        "believed_when_good_again": sum(after.get(servo) == place for servo, place in truth.items()),
    }


@contextmanager
def _peer(*words: str) -> Iterator[Path]:
    """Start the other end of a line, and yield the line's path."""
    with tempfile.TemporaryDirectory(prefix="lbr-") as folder:
        path = Path(folder) / "tty"
        argv = [sys.executable, "-m", "benchmarks.instruments.uxa90_peers", words[0], str(path), *words[1:]]
        process = programs.start(argv)
        try:
            while not path.exists():
                time.sleep(0.01)
            yield path
        finally:
            process.kill()
            process.wait()


def _moved(data: bytes) -> list[int]:
    return [packet.servo for packet in packets(data)[0] if packet.kind == "move"]


def _number(path: Path) -> int:
    with suppress(OSError, ValueError):
        return int(path.read_text())
    return 0
