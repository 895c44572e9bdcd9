"""Measures how soon the wheels stand when an agent's program is gone, and counts unsafe calls of agents that were obeyed.

`python -m benchmarks mcp --n 50`. The agent is the official client of MCP, by a pipe and over HTTP, in its newest protocol and in the
one before. It is killed, frozen, or cancels its call. To a server a frozen client and a network that is cut look the same.
"""

import argparse
import asyncio
import json
import math
import os
import random
import signal
import sys
import time
from contextlib import suppress
from pathlib import Path
from typing import Any

from benchmarks import Measured
from tests.scenarios import promises
from tests.support import programs, robot
from tests.support.bench import Bench, NoMotionError, bench
from tests.support.figures import Promise, Results
from tests.support.waiting import until

SMOKE = "--n 1 --calls 30 --ends killed"
ENDS = ("killed", "frozen", "cancelled")
WAYS = ("pipe", "http")
MODES = {"auto": "2026-07-28", "legacy": "2025-11-25"}
PROMISES = {
    **{
        f"{end} {way} {mode}": Promise(
            what=f"agent {end}, {way}, {version}: wheels zero", target=400.0, statistic="p99"
        )
        for end in ENDS
        for way in WAYS
        for mode, version in MODES.items()
    },
    "obeyed": Promise(what="unsafe calls of tools, obeyed", unit="", hard=0.0),
    **{name: promises.PROMISES[name] for name in ("F6", "S14")},
}
AGENT = Path(robot.__file__).parent / "clients" / "agent.py"
SPIN = {"power": 0.4, "angle_deg": 90, "seconds": 5}
ATTEMPTS, REST_S = 4, 0.4
UNSAFE_POWER: tuple[Any, ...] = (0.51, 1.0, 1e9, -0.3, math.nan, math.inf, "0.4", None, True, [0.3], {"power": 0.3})
UNSAFE_LINES = (
    *("reset", "Shutdown", "/r/0.4/90", "/torque/on", "enable", "!print(1)", "/restart/motors", "/pair/admin", "open"),
    *("/s/a\n/r/0.4/90", "/record/0", "clock", "/twist/1/0/0", "//r/0.4/90", "/agent/x", "s\x00/r/0.4/90"),
)
UNSAFE_TOOLS = ("publish", "reset", "torque", "setpoint", "__init__", "drive ", "../drive", "x" * 5000)
KEYS = ("lease", "take_over", "ttl_s", "key", "role", "token", "distance_cm", "interval_s")


def options(parser: argparse.ArgumentParser) -> None:
    """Add how many."""
    parser.add_argument("--n", type=int, default=10, help="of each way to be gone (default %(default)s)")
    parser.add_argument("--calls", type=int, default=1000, help="unsafe calls (default %(default)s)")
    parser.add_argument("--ends", nargs="+", choices=ENDS, default=ENDS, help="which (default: all)")
    parser.add_argument("--seed", type=int, default=1, help="of chance (default %(default)s)")


def measure(given: argparse.Namespace) -> Measured:
    """Run agents and end them, then have one ask for what it must not."""
    results, port = Results(PROMISES), robot.free_port()
    settings = json.dumps({"port": port, "ask": []})
    row = f"INSERT INTO capability (robot, name, kind, settings) VALUES ('lbr', 'agents', 'mcp', '{settings}')"
    with bench(results, edits=(row,)) as under_test:
        until(lambda: (under_test.robot.ask("agents/state") or {}).get("urls"), what="the server for agents")
        for number in range(given.n):
            for end in given.ends:
                for way in WAYS:
                    for mode in MODES:
                        _try(under_test, end, way, mode, port)
            print(f"{number + 1} of {given.n}", file=sys.stderr, flush=True)
        answers = _unsafe(under_test, given.calls, random.Random(given.seed))
    return Measured(
        results=results.ordered(),
        text=f"unsafe calls by what they were answered: {answers}",
        disturbed=results.disturbed,
    )


def _try(under_test: Bench, end: str, way: str, mode: str, port: int) -> None:
    for _ in range(ATTEMPTS):
        with suppress(NoMotionError):
            _end(under_test, end, way, mode, port)
            return
    under_test.results.disturbed.append(f"{end} {way} {mode}: the motors did not come to 40 %")


def _end(under_test: Bench, end: str, way: str, mode: str, port: int) -> None:
    under_test.robot.line("stop")
    where = [*robot.LBR, "mcp"] if way == "pipe" else [f"http://127.0.0.1:{port}/mcp"]
    argv = [sys.executable, str(AGENT), mode, "drive", json.dumps(SPIN), *where]
    popen = programs.start(argv, env=robot.environment(under_test.robot.home), stdin=-1, stdout=-3, stderr=-3)
    try:
        under_test.wait_for_motion(20.0)
        at_ns = time.monotonic_ns()
        if end == "cancelled":
            assert popen.stdin is not None
            os.write(popen.stdin.fileno(), b"\n")
        else:
            popen.send_signal(signal.SIGKILL if end == "killed" else signal.SIGSTOP)
        zero = under_test.stopped_after(f"{end} {way} {mode}", at_ns, limit_s=4.5)
        under_test.pass_time(REST_S)
        under_test.stays_at_rest(zero)
    finally:
        popen.send_signal(signal.SIGCONT)
        popen.kill()
        popen.wait()


def _unsafe(under_test: Bench, count: int, dice: random.Random) -> dict[str, int]:
    """Have an agent make unsafe calls; return how often it was answered by which code."""
    began_ns = time.monotonic_ns()
    codes, obeyed = asyncio.run(_calls(robot.environment(under_test.robot.home), count, dice))
    under_test.trace.read()
    moved = [entry for entry in under_test.trace.outputs(began_ns) if not entry.zero]
    under_test.results.sample("obeyed", float(len(obeyed) + bool(moved)))
    under_test.results.check(
        "obeyed", obeyed[:3] + [f"the motors were at {one.left:g} {one.right:g}" for one in moved[:1]]
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
