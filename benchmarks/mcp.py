"""Measures how soon the wheels stand when an agent's program is gone, and counts unsafe calls that were obeyed.

`python -m benchmarks mcp --n 50`. One robot serves agents with the official client of MCP, by a pipe and over HTTP with
TLS and a token, in the newest protocol and in the one before. They are killed, frozen and thawed, or cancel their call.
As root, the cable between them and the robot is also pulled and plugged in again. A wheel that turns later without a
new call counts as resumed.
"""

import argparse
import asyncio
import json
import math
import os
import random
import select
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext, suppress
from pathlib import Path
from typing import Any

from benchmarks import Measured
from tests.scenarios import promises
from tests.support import programs, robot
from tests.support.bench import Bench, NoMotionError, bench
from tests.support.door import add_token
from tests.support.figures import Promise, Results
from tests.support.netns import Network, network, why_not
from tests.support.waiting import until

SMOKE = "--n 1 --calls 30 --ends cancelled killed"
ENDS = ("frozen", "cancelled", "cut", "killed")
WAYS = ("pipe", "http")
MODES = {"auto": "2026-07-28", "legacy": "2025-11-25"}
PROMISES = {
    **{
        f"M {end} {way} {version[:4]}": Promise(
            what=f"agent {end}, by {way}, protocol {version}: motors at zero", target=400.0, statistic="p99"
        )
        for end in ENDS
        for way in WAYS
        for version in MODES.values()
    },
    "M resumed": Promise(what="agents that were gone, and came back: motion that resumed"),
    "M unsafe": Promise(what="unsafe calls of tools, obeyed", unit="", hard=0.0),
    "F6": promises.PROMISES["F6"],
}
AGENT = Path(robot.__file__).parent / "clients" / "agent.py"
SPIN = {"power": 0.4, "angle_deg": 90, "seconds": 5}
ATTEMPTS, BEGINS_S, GIVES_UP_S, REST_S = 4, 1.5, 20.0, 0.4
UNSAFE_POWER: tuple[Any, ...] = (0.51, 1.0, 1e9, -0.3, math.nan, math.inf, "0.4", None, True, [0.3], {"power": 0.3})
UNSAFE_LINES = (
    *("reset", "Shutdown", "/r/0.4/90", "/torque/on", "enable", "!print(1)", "/restart/motors", "/pair/admin", "open"),
    *("/s/a\n/r/0.4/90", "/record/0", "clock", "/twist/1/0/0", "//r/0.4/90", "/agent/x", "s\x00/r/0.4/90"),
)
UNSAFE_TOOLS = ("publish", "reset", "torque", "setpoint", "__init__", "drive ", "../drive", "x" * 5000)
KEYS = ("lease", "take_over", "ttl_s", "key", "role", "token", "distance_cm", "interval_s")


def options(parser: argparse.ArgumentParser) -> None:
    """Add the number."""
    parser.add_argument("--n", type=int, default=10, help="of each way to be gone (default %(default)s)")
    parser.add_argument("--calls", type=int, default=1000, help="unsafe calls (default %(default)s)")
    parser.add_argument("--ends", nargs="+", choices=ENDS, default=ENDS, help="which (default: all)")
    parser.add_argument("--ways", nargs="+", choices=WAYS, default=WAYS, help="which (default: both)")
    parser.add_argument("--seed", type=int, default=1, help="of chance (default %(default)s)")


def measure(given: argparse.Namespace) -> Measured:
    """Run agents and end them, then let one make forbidden calls."""
    results, dice = Results(PROMISES), random.Random(given.seed)
    if reason := why_not():
        print(f"no cable is pulled: {reason}", file=sys.stderr)
    begun = os.getloadavg()[0]
    with nullcontext() if reason else network() as net:
        address, port = net.address if net else "127.0.0.1", robot.free_port()
        settings = json.dumps({"host": address, "port": port, "ask": [], "tls": True})
        row = f"INSERT INTO capability (robot, name, kind, settings) VALUES ('lbr', 'agents', 'mcp', '{settings}')"
        with bench(results, edits=(row,), prefix=net.robot if net else ()) as under_test:
            until(lambda: (under_test.robot.ask("agents/state") or {}).get("urls"), what="the server for agents")
            with _agents(under_test, given.ways, f"https://{address}:{port}/mcp", net) as agents:
                for number in range(given.n):
                    for agent in agents:
                        for end in sorted(given.ends, key=ENDS.index):
                            any(agent.go(end) for _ in range(ATTEMPTS))
                    print(f"{number + 1} of {given.n}", file=sys.stderr, flush=True)
            answers = _unsafe(under_test, given.calls, dice)
    return Measured(
        results=[found for found in results.ordered() if found.figure != "F6" or found.violations],
        text=f"unsafe calls by what they were answered: {answers}",
        load=f"beside other programs: load average {begun:.1f} at its beginning, {os.getloadavg()[0]:.1f} at its end",
        disturbed=results.disturbed,
    )


class Agent:
    """An agent's program, which is ended repeatedly, and restarted after a kill."""

    def __init__(
        self, under_test: Bench, way: str, mode: str, argv: list[str], net: Network | None, **more: str
    ) -> None:
        self._bench = under_test
        self._way, self._mode, self._net = way, mode, net
        self._argv = [sys.executable, str(AGENT), mode, "status", "{}", *argv]
        if net is not None and way == "http":
            self._argv = [*net.client, *self._argv]
        self._environment = robot.environment(under_test.robot.home) | more
        self._start()

    def go(self, end: str) -> bool:
        """Let it drive, and end that; measure until the motors are at zero, and whether they stay there.

        Return False if the machine had stopped them before.
        """
        if end == "cut" and (self._net is None or self._way == "pipe"):
            return True
        figure = f"M {end} {self._way} {MODES[self._mode][:4]}"
        if not self._drives():
            self._bench.results.disturbed.append(f"{figure}: the motors did not come to 40 %")
            return False
        disturbed = len(self._bench.results.disturbed)
        at_ns = time.monotonic_ns()
        self._end(end)
        zero = self._bench.stopped_after(figure, at_ns, limit_s=4.5)
        self._bench.pass_time(REST_S)
        self._come_back(end)
        self._bench.pass_time(REST_S)
        self._bench.stays_at_rest(zero, "M resumed")
        return len(self._bench.results.disturbed) == disturbed

    def close(self) -> None:
        """End its program."""
        self._popen.kill()
        self._popen.communicate()

    def _end(self, end: str) -> None:
        if end == "cut":
            assert self._net is not None
            self._net.cut()
        elif end == "cancelled":
            self._say("")
        else:
            self._popen.send_signal(signal.SIGKILL if end == "killed" else signal.SIGSTOP)

    def _come_back(self, end: str) -> None:
        if end == "frozen":
            self._popen.send_signal(signal.SIGCONT)
        elif end == "cut":
            assert self._net is not None
            self._net.heal()
        elif end == "killed":
            self.close()
            self._start()

    def _start(self) -> None:
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.DEVNULL}
        self._popen = programs.start(self._argv, env=self._environment, bufsize=0, **pipes)
        self._calls, self._rest = True, b""

    def _drives(self) -> bool:
        """Let it call `drive` until the motors turn at 40 %: the base is not armed at once after each end."""
        until_s = time.monotonic() + GIVES_UP_S
        while time.monotonic() < until_s:
            if self._calls and not self._answered(until_s - time.monotonic()):
                self.close()
                self._start()
                continue
            self._say(f"drive {json.dumps(SPIN)}")
            self._calls = True
            with suppress(NoMotionError):
                self._bench.wait_for_motion(BEGINS_S)
                return True
        return False

    def _answered(self, limit_s: float) -> bool:
        """Wait for the answer to its last call; return False if none comes, or its program has ended."""
        assert self._popen.stdout is not None
        until_s = time.monotonic() + limit_s
        while select.select([self._popen.stdout], [], [], max(0.0, until_s - time.monotonic()))[0]:
            told = os.read(self._popen.stdout.fileno(), 65536)
            if not told:
                return False
            *lines, self._rest = (self._rest + told).split(b"\n")
            if any(line != b"calls" for line in lines):
                self._calls = False
                return True
        return False

    def _say(self, line: str) -> None:
        assert self._popen.stdin is not None
        with suppress(BrokenPipeError):  # it has ended, so it gives no answer
            os.write(self._popen.stdin.fileno(), f"{line}\n".encode())


@contextmanager
def _agents(under_test: Bench, ways: list[str], url: str, net: Network | None) -> Iterator[list[Agent]]:
    """Run an agent for each way and protocol; those over HTTP have a token, and trust only the robot's certificate."""
    home = under_test.robot.home
    token = add_token(home, "agent", "operate", good_for="web")
    pinned = {"LBR_TOKEN": str(token), "LBR_CA": str(home / "credentials" / "bus.crt")}
    agents = []
    try:
        for way in ways:
            for mode in MODES:
                where, more = ([*robot.LBR, "mcp"], {}) if way == "pipe" else ([url], pinned)
                agents.append(Agent(under_test, way, mode, where, net, **more))
        yield agents
    finally:
        for agent in agents:
            agent.close()


def _unsafe(under_test: Bench, count: int, dice: random.Random) -> dict[str, int]:
    """Let an agent make unsafe calls; return the number of answers by code."""
    began_ns = time.monotonic_ns()
    codes, obeyed = asyncio.run(_calls(robot.environment(under_test.robot.home), count, dice))
    under_test.trace.read()
    moved = [entry for entry in under_test.trace.outputs(began_ns) if not entry.zero]
    under_test.results.sample("M unsafe", float(len(obeyed) + bool(moved)))
    under_test.results.check(
        "M unsafe", obeyed[:3] + [f"the motors were at {one.left:g} {one.right:g}" for one in moved[:1]]
    )
    return codes


async def _calls(environment: dict[str, str], count: int, dice: random.Random) -> tuple[dict[str, int], list[str]]:
    from mcp import Client, StdioServerParameters
    from mcp.client.stdio import stdio_client

    server = StdioServerParameters(command=robot.LBR[0], args=[*robot.LBR[1:], "mcp"], env=environment)
    codes: dict[str, int] = {}
    obeyed = []
    async with Client(stdio_client(server)) as client:
        for _ in range(count):
            tool, arguments = _unsafe_call(dice)
            answer = (await client.call_tool(tool, arguments)).structured_content
            codes[answer["code"]] = codes.get(answer["code"], 0) + 1
            if answer["code"] == "done":
                obeyed.append(f"{tool} {arguments}")
    return codes, obeyed


def _unsafe_call(dice: random.Random) -> tuple[str, dict[str, Any]]:
    fine: dict[str, Any] = {"power": 0.4, "angle_deg": 90}
    match dice.randrange(5):
        case 0:
            return "drive", fine | {"power": dice.choice(UNSAFE_POWER)}
        case 1:
            return "drive", fine | {"seconds": dice.choice((0, -1, 5.1, 1e6, math.nan, "1"))}
        case 2:
            return dice.choice(("drive", "turn", "go")), fine | {dice.choice(KEYS): dice.choice(("x", True, 1.0))}
        case 3:
            return "say", {"line": dice.choice(UNSAFE_LINES)}
        case _:
            return dice.choice(UNSAFE_TOOLS), fine
