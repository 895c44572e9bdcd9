"""The time from a twist on /cmd_vel to the motor controller's bytes, compared with lbr's own client, and the run-on of
wheels.

`python -m benchmarks ros2 --n 300 --kills 50`. The shipped robot is the router of ROS. A node publishes ever slower
turns, which take effect at once, in turns with lbr's client; a way ends at the controller's next different line. Then
nodes are killed and frozen while they drive, and last the router is killed and replaced. The node is one by pyzeros
where `LBR_ROS_SIDES` names a Python that has it, else zenoh alone.
"""

import argparse
import json
import os
import select
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from functools import partial
from pathlib import Path
from typing import Any

import lbr.client
from benchmarks import Measured
from lbr.client.motion import Motion
from lbr.errors import LbrError
from tests.support import programs, ros_judges
from tests.support.figures import Promise, Results, percentile
from tests.support.robot import Robot, free_port, prepare, running
from tests.support.robot import lbr as command
from tests.support.trace import Line, Trace
from tests.support.waiting import STOPS_S, until

SMOKE = "--n 10 --kills 1"
FASTEST_RPS, STEP_RPS, STEPS, TURN_RPS = 1.2, 0.02, 40, 0.6
SETTLE_S, PERIOD_S, GIVE_UP_S, STAYS_S = 0.8, 0.06, 0.5, 1.0
SIDES = os.environ.get("LBR_ROS_SIDES", "")
PROMISES = {
    "R1": Promise(what="a node of ROS killed while it drives: motors at zero", target=400.0, statistic="p99"),
    "R2": Promise(what="the same, frozen, and thawed later", target=400.0, statistic="p99"),
    "R3": Promise(what="the router of ROS killed while a node drives, and replaced", target=400.0, statistic="p99"),
    "R0": Promise(what="motion that resumed after any of these"),
}


def options(parser: argparse.ArgumentParser) -> None:
    """Add the amount."""
    parser.add_argument("--n", type=int, default=300, help="twists of each sender (default %(default)s)")
    parser.add_argument("--kills", type=int, default=50, help="of each way to go (default %(default)s)")


def measure(given: argparse.Namespace) -> Measured:
    """Measure ways, then deaths."""
    results = Results(PROMISES)
    with tempfile.TemporaryDirectory(prefix="lbr-") as folder:
        endpoint = f"tcp/127.0.0.1:{free_port()}"
        with _robot(Path(folder) / "a", listen=endpoint) as robot:
            trace = Trace(robot.trace)
            text = _ways(robot, endpoint, trace, given.n)
            for figure, go in (("R1", signal.SIGKILL), ("R2", signal.SIGSTOP)):
                for _ in range(given.kills):
                    with _node(endpoint) as node:
                        _death(results, figure, node, trace, partial(node.send_signal, go))
        endpoint = f"tcp/127.0.0.1:{free_port()}"
        with _robot(Path(folder) / "b", connect=endpoint) as robot, ExitStack() as stack:
            trace, router = Trace(robot.trace), stack.enter_context(_program(endpoint, "--router"))
            for _ in range(given.kills):
                until(lambda: robot.capability("ros2")["phase"] == "ready", "the router")
                with _node(endpoint) as node:
                    _death(results, "R3", node, trace, router.kill)
                    router.wait()
                    router = stack.enter_context(_program(endpoint, "--router"))
                    until(lambda: robot.capability("ros2")["phase"] == "ready", "the router again")
                    results.check("R0", _moved(trace, time.monotonic_ns()))
    return Measured(results=results.ordered(), text="\n".join(text))


@contextmanager
def _robot(home: Path, **settings: str) -> Iterator[Robot]:
    row = json.dumps({"token": "ros", "speed_mps": 1.0, "turn_rps": 3.0, **settings})
    edit = f"UPDATE capability SET enabled = 1, settings = '{row}' WHERE robot = 'lbr' AND name = 'ros2'"
    prepare(home, "ros2", edits=(edit,))
    assert command(home, "token", "add", "ros", "--role", "operate").returncode == 0
    os.environ["LBR_HOME"] = str(home)
    with running(home) as robot:
        yield robot


@contextmanager
def _program(endpoint: str, *words: str) -> Iterator["subprocess.Popen[str]"]:
    by_zenoh = [sys.executable, "-m", "tests.support.ros_side", endpoint, *words]
    by_pyzeros = [SIDES, str(Path(ros_judges.__file__).parent / "pyzeros_node.py"), endpoint]
    argv = by_pyzeros if SIDES and words == ("--lines",) else by_zenoh
    program = programs.start(argv, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    try:
        yield program
    finally:
        program.kill()
        program.communicate()


@contextmanager
def _node(endpoint: str) -> Iterator["subprocess.Popen[str]"]:
    with _program(endpoint, "--lines") as node:
        _read(node, "ready")
        yield node


def _read(node: "subprocess.Popen[str]", name: str) -> Any:
    assert node.stdout is not None
    while line := node.stdout.readline():
        said = json.loads(line)
        if name in said:
            return said[name]
    raise AssertionError("the node has ended")


def _publish(node: "subprocess.Popen[str]", vx: float, wz: float) -> int:
    assert node.stdin is not None
    node.stdin.write(json.dumps({"twist": [vx, wz]}) + "\n")
    node.stdin.flush()
    return int(_read(node, "sent_ns"))


def _ways(robot: Robot, endpoint: str, trace: Trace, n: int) -> list[str]:
    """Let both senders slow down in turns, and return a table of their ways."""
    ways: dict[str, list[float]] = {"lbr's client": [], "ROS": []}
    with lbr.client.connect(robot.name, at=robot.endpoints[0]) as client:
        while min(map(len, ways.values())) < n:
            with suppress(LbrError), client.borrow("drive/twist", wz_rps=FASTEST_RPS, ttl_s=1.0) as motion:
                ways["lbr's client"] += _ramp(trace, partial(_keep, motion))
            until(lambda: trace.now().zero, "standing still")
            with _node(endpoint) as node:
                ways["ROS"] += _ramp(trace, partial(_publish, node, 0.0))
                _publish(node, 0.0, 0.0)
            until(lambda: trace.now().zero, "standing still")
    ours = percentile(ways["lbr's client"], "p50")
    rows = [
        f"| {name} | {len(found)} | {percentile(found, 'p50'):.2f} | {percentile(found, 'p99'):.2f} | {percentile(found, 'p50') / ours:.2f} |"
        for name, found in ways.items()
    ]
    by = "pyzeros" if SIDES else "zenoh alone"
    return [
        f"| twist to bytes, ms (ROS by {by}) | N | p50 | p99 | to lbr's client, p50 |",
        "|---|--:|--:|--:|--:|",
        *rows,
    ]


def _keep(motion: Motion, wz: float) -> int:
    at_ns = time.monotonic_ns()
    motion.keep(wz_rps=wz)
    return at_ns


def _ramp(trace: Trace, send: Callable[[float], int]) -> Iterator[float]:
    """Slow down step by step, and yield each duration."""
    speed, end = FASTEST_RPS, time.monotonic() + SETTLE_S
    while time.monotonic() < end:
        send(speed)
        select.select([], [], [], PERIOD_S)
    for _ in range(STEPS):
        speed -= STEP_RPS
        trace.read()
        before = _last(trace)
        at_ns = send(speed)
        came = _changed(trace, before, at_ns)
        if came is not None:
            yield (came.at_ns - at_ns) / 1e6
        select.select([], [], [], PERIOD_S)


def _last(trace: Trace) -> str:
    return next(
        (one.text for one in reversed(trace.entries) if isinstance(one, Line) and one.text.startswith("!M")), ""
    )


def _changed(trace: Trace, before: str, since_ns: int) -> Line | None:
    end = time.monotonic() + GIVE_UP_S
    while time.monotonic() < end:
        trace.read()
        for one in trace.lines(since_ns):
            if one.text.startswith("!M") and one.text != before:
                return one
        select.select([], [], [], 0.001)
    return None


def _death(results: Results, figure: str, node: "subprocess.Popen[str]", trace: Trace, go: Callable[[], None]) -> None:
    """Let a node drive, end it, and check that the motors stop and stay so."""

    def drives() -> bool:
        _publish(node, 0.0, 0.0)  # for a node that lost the robot because a busy machine delayed it
        _publish(node, 0.0, TURN_RPS)
        end = time.monotonic() + GIVE_UP_S
        while trace.now().zero and time.monotonic() < end:
            select.select([], [], [], 0.01)
        return not trace.now().zero

    until(drives, "turning wheels")
    since_ns = time.monotonic_ns()
    go()
    zero = trace.first_zero(since_ns, STOPS_S)
    if zero is None:
        results.check(figure, ["the motors turned on"])
        return
    results.sample(figure, (zero.at_ns - since_ns) / 1e6)
    if figure == "R2":
        node.send_signal(signal.SIGCONT)
    results.check("R0", _moved(trace, zero.at_ns))


def _moved(trace: Trace, since_ns: int) -> list[str]:
    end = time.monotonic() + STAYS_S
    until(lambda: time.monotonic() > end)
    trace.read()
    return [f"{one.left:g} {one.right:g} at {one.at_ns}" for one in trace.outputs(since_ns) if not one.zero][:1]
