"""Measures how soon the motors stand when an operator on another machine is lost, and whether delayed messages move
them.

`python -m benchmarks lan --n 20 --json FILE`; S9 and F1 need root, for two network namespaces and a cable between them.
Exit code 1 if a hard value is broken.
"""

import argparse
import random
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path

from benchmarks import Measured
from benchmarks.instruments.stalling import Stalling, Way
from tests.support.door import Door, opened
from tests.support.figures import Promise, Results
from tests.support.netns import Network, network, why_not
from tests.support.robot import prepare
from tests.support.waiting import until

SMOKE = "--n 1"

PROMISES: dict[str, Promise] = {
    "S8 LAN": Promise(what="client on another machine killed, to motor zero", hard=300),
    "S9": Promise(what="cable to the client's machine pulled, to motor zero", target=350, statistic="p99", hard=400),
    "S10": Promise(
        what="connection to the client stalls, to the robot or both ways, to motor zero", target=400, hard=500
    ),
    "F1": Promise(what="what a cut of 0.3 to 8 s or a stalled connection held back moves nothing when it is delivered"),
    "A8": Promise(what="token revoked in the rows, to motor zero", target=1000, hard=1500),
}
MANNERS = ("quoting", "stamped", "asking")
WAYS: tuple[Way, ...] = ("to the robot", "both ways")
STANDS_S = 1.0
CUTS_S = (0.3, 8.0)


def options(parser: argparse.ArgumentParser) -> None:
    """Add the number."""
    parser.add_argument("--n", type=int, default=20, help="tries of each (default %(default)s)")


def measure(given: argparse.Namespace) -> Measured:
    """Lose the operator on the other machine, repeatedly."""
    results, dice = Results(PROMISES), random.Random(1)
    with tempfile.TemporaryDirectory(prefix="lbr-") as folder:
        near(results, Path(folder) / "near", given.n, dice)
        if why_not():
            print(f"S9 is left out: {why_not()}", file=sys.stderr)
        else:
            far(results, Path(folder) / "far", given.n, dice)
    return Measured(results=results.ordered())


def near(results: Results, home: Path, n: int, dice: random.Random) -> None:
    """Run S8, S10 and A8, with client and robot on one machine."""
    with opened(prepare(home)) as door:
        for turn in range(n):
            _stop_by(results, "S8 LAN", door, MANNERS[turn % 3], lambda client: client.kill(), dice)
        for turn in range(n):
            _stalled(results, door, WAYS[turn % 2], MANNERS[turn // 2 % 3], dice)
        for turn in range(n):
            name = f"guest{turn}"
            door.add(name, "operate")
            _stop_by(results, "A8", door, "quoting", partial(_revoke, door, name), dice, name)


def far(results: Results, home: Path, n: int, dice: random.Random) -> None:
    """Run S9 and F1, with a cable between client and robot."""
    with network() as net, opened(prepare(home), net.address, prefix=net.robot, elsewhere=net.client) as door:
        for turn in range(n):
            _cut(results, door, net, MANNERS[turn % 3], dice)


def _stop_by(
    results: Results,
    figure: str,
    door: Door,
    manner: str,
    end: Callable[["subprocess.Popen[str]"], None],
    dice: random.Random,
    name: str = "phone",
) -> None:
    with _driven(door, name, manner, dice) as client:
        began_ns = time.monotonic_ns()
        end(client)
        _stood(results, figure, door, began_ns)


def _stalled(results: Results, door: Door, way: Way, manner: str, dice: random.Random) -> None:
    between = Stalling(int(door.endpoint.rpartition(":")[2]))
    through = Door(door.robot, f"tls/127.0.0.1:{between.port}", door.tokens)
    try:
        with _driven(through, "phone", manner, dice):
            began_ns = time.monotonic_ns()
            between.stall(way)
            _stood(results, "S10", through, began_ns)
            _wait(dice.uniform(*CUTS_S) / 4)
            _nothing_moves(results, through, between.release, f"{manner}, {way}")
    finally:
        between.close()


def _cut(results: Results, door: Door, net: Network, manner: str, dice: random.Random) -> None:
    with _driven(door, "phone", manner, dice):
        began_ns = time.monotonic_ns()
        net.cut()
        try:
            _stood(results, "S9", door, began_ns)
            _wait(dice.uniform(*CUTS_S) - (time.monotonic_ns() - began_ns) / 1e9)
        finally:
            _nothing_moves(results, door, net.heal, manner)


@contextmanager
def _driven(door: Door, name: str, manner: str, dice: random.Random) -> Iterator["subprocess.Popen[str]"]:
    """Let a client drive from afar; the caller decides its actions, from a random moment on."""
    with door.plain(name, manner) as client:
        until(door.moving, limit_s=20.0, what="it drives")
        _wait(0.3 + dice.uniform(0.0, 0.3))
        yield client
    door.rest()


def _nothing_moves(results: Results, door: Door, deliver: Callable[[], None], how: str) -> None:
    """Check that delayed messages move nothing. A client that asks again may begin anew; all other leases are dead."""
    since_ns = time.monotonic_ns()
    deliver()
    _wait(STANDS_S)
    door.trace.read()
    moved = [output for output in door.trace.outputs(since_ns) if not output.zero]
    asked_anew = how.startswith("asking")
    results.check("F1", [f"{how}: {moved[0]}"] if moved and not asked_anew else [])


def _stood(results: Results, figure: str, door: Door, began_ns: int) -> None:
    zero = door.trace.first_zero(began_ns, 3.0)
    if zero is None:
        results.check(figure, ["still turns 3 s after"])
    else:
        results.sample(figure, max(0.0, (zero.at_ns - began_ns) / 1e6))


def _revoke(door: Door, name: str, _client: object) -> None:
    door.robot.edit("UPDATE user_token SET revoked_at = '2026-01-02T00:00:00Z' WHERE name = ?", name)


def _wait(seconds: float) -> None:
    if seconds > 0:
        time.sleep(seconds)
