"""Measures the black box: the losses by kills, its cost at rest and while driving, and motion with and without it.

`python -m benchmarks box --n 200 --seconds 60 --lines 200`. A kill is `kill -9` of the box at a random moment. Every
message counts that another client received, from the box's first to those a second old at the kill. `--only
kills,cost,latency` runs some. Exit code 1 if one in a hundred messages older than a second was lost.
"""

import argparse
import random
import time
from contextlib import suppress
from pathlib import Path

import psutil

from benchmarks import Measured, listed
from benchmarks.latency import STEPS, _slow_down, _spin
from lbr.apps.recorder.recording import selection
from lbr.apps.recorder.recording.shelf import Shelf
from tests.scenarios.promises import PROMISES as SAFETY
from tests.support.bench import Bench, bench, let_go, temporary_home
from tests.support.figures import Promise, Results, percentile
from tests.support.mover import Mover
from tests.support.robot import start
from tests.support.witness import Witness

SMOKE = "--n 1 --seconds 2 --lines 3"
SWITCH = "UPDATE capability SET enabled = {} WHERE robot = 'lbr' AND name = 'box'"
PROMISES = {
    "BB1": Promise(what="messages older than 1 s that are gone after kill -9, of all of them", unit="%", hard=1.0),
    "BB2": Promise(what="processor time of the box at rest", unit="% of a core", target=2.0, statistic="max"),
    "BB3": Promise(what="processor time of the box while driving", unit="% of a core", target=2.0, statistic="max"),
    "BB4": Promise(what="bytes a minute at rest, without cameras", unit="MB", target=8.0, statistic="max"),
    "BB5": Promise(what="bytes a minute while driving, without cameras", unit="MB", target=8.0, statistic="max"),
}
OLD_S = 1.0
EVERY = 4
"""A process that ends six times within 30 s is given up; a restart of its row resets the count."""


def options(parser: argparse.ArgumentParser) -> None:
    """Add the amount, and the parts."""
    parser.add_argument("--n", type=int, default=20, help="kills (default %(default)s)")
    parser.add_argument("--seconds", type=float, default=30.0, help="at rest, and driving (default %(default)s)")
    parser.add_argument(
        "--lines", type=int, default=100, help="console lines with it, and without (default %(default)s)"
    )
    parser.add_argument("--only", type=listed, default=["kills", "cost", "latency"], metavar="kills,cost,latency")


def measure(given: argparse.Namespace) -> Measured:
    """Kill it, measure its cost, and run without it."""
    results, text = Results(PROMISES), []
    if "kills" in given.only:
        text += _kills(results, given.n)
    if "cost" in given.only:
        text += _cost(results, given.seconds)
    if "latency" in given.only:
        text += _latency(given.lines)
    return Measured(results=results.ordered(), text="\n".join(text))


def _kills(results: Results, n: int) -> list[str]:
    dice, older, gone, holes, younger_s = random.Random(1), 0, 0, 0, []
    with bench(Results(SAFETY), edits=(SWITCH.format(1),)) as under_test:
        place, witness = Shelf(under_test.robot.home, "lbr"), Witness(under_test)
        mover, known = under_test.drive(), set[Path]()
        for turn in range(n):
            if turn and turn % EVERY == 0:
                known = set(place.files())
                under_test.forget_deaths("box")
            file = _new_file(under_test, place, known)
            begun_ns = time.monotonic_ns()
            under_test.pass_time(dice.uniform(2.0, 4.0))
            pid = under_test.pid("box")
            known = set(place.files())
            at_ns = under_test.kill(pid)
            under_test.pass_time(0.05)
            wanted = witness.between(begun_ns, at_ns - int(OLD_S * 1e9))
            written = list(selection.messages([file]))
            there = {(one.topic, one.sequence) for one in written}
            lost = wanted - there
            older, gone = older + len(wanted), gone + len(lost)
            newest_of = {topic: max(number for name, number in there if name == topic) for topic, _ in there}
            holes += sum(number < newest_of.get(topic, 0) for topic, number in lost)
            offset = time.time_ns() - time.monotonic_ns()
            newest = max((one.publish_ns for one in written), default=0)
            younger_s.append((at_ns + offset - newest) / 1e9)
            with suppress(AssertionError):
                under_test.ready_again("box", pid, at_ns)
        mover.cease()
        witness.close()
    results.sample("BB1", 100 * gone / max(1, older))
    return [
        "",
        f"{n} kills: {older} messages were older than {OLD_S:g} s, {gone} of them are gone ({100 * gone / max(1, older):.3f} %)",
        f"{holes} of these had not come to the box at all: newer ones of their stream are there",
        f"the newest message that is there was {percentile(younger_s, 'p50'):.2f} s old at the kill (p50), {max(younger_s):.2f} s at most",
    ]


def _new_file(under_test: Bench, place: Shelf, known: set[Path]) -> Path:
    """Wait until the box writes another file with streams in it, and return it."""

    def heard() -> bool:
        files = [path for path in place.files()[-1:] if path not in known]
        return any(one.topic == "motors/setpoint" for one in selection.messages(files))

    under_test.until(heard, 15.0, "a file with streams in it", every_s=0.05)
    return place.files()[-1]


def _cost(results: Results, seconds: float) -> list[str]:
    with temporary_home(whole=True) as home:
        robot = start(home)
        under_test = Bench(robot, results)
        try:
            robot.line("/camera/off")
            under_test.until(lambda: robot.ask("box/state") is not None, 15.0, "the state of the box")
            under_test.pass_time(3.0)
            rest = _costs(under_test, seconds)
            mover = Mover(robot, 90.0).start()
            driving = _costs(under_test, seconds)
            mover.cease()
            state = under_test.answer("box/state")
        finally:
            let_go(robot)
    for figures, names in ((rest, ("BB2", "BB4")), (driving, ("BB3", "BB5"))):
        results.sample(names[0], figures[0])
        results.sample(names[1], figures[1])
    lines = [
        "",
        "| | CPU, % of a core | MB/min | messages/s | wake-ups/s | private memory, MiB |",
        "|---|--:|--:|--:|--:|--:|",
    ]
    for name, found in (("at rest", rest), ("driving", driving)):
        lines.append(f"| {name} | " + " | ".join(f"{value:.2f}" for value in found) + " |")
    return [*lines, f"\nlost: {state['lost']} of {state['messages']}"]


def _costs(under_test: Bench, seconds: float) -> tuple[float, ...]:
    """Return CPU in percent, MB a minute, messages and switches of the main thread a second, and private MiB."""
    process = psutil.Process(under_test.pid("box"))
    place = under_test.robot.home / "box"

    def look() -> tuple[float, float, float, float]:
        times = process.cpu_times()
        size = sum(path.stat().st_size for path in place.rglob("*.mcap") if "kept" not in path.parts)
        said = under_test.answer("box/state")["messages"]
        return times.user + times.system, size, said, process.num_ctx_switches().voluntary

    before, began = look(), time.monotonic()
    under_test.pass_time(seconds)
    after, spent = look(), time.monotonic() - began
    cpu, size, messages, switches = (b - a for a, b in zip(before, after, strict=True))
    memory = process.memory_full_info().uss / 2**20
    return cpu / spent * 100, size / spent * 60 / 1e6, messages / spent, switches / spent, memory


def _latency(lines: int) -> list[str]:
    series: dict[bool, list[float]] = {True: [], False: []}
    with bench(Results(SAFETY), edits=(SWITCH.format(1),)) as under_test:
        turn = 0
        while min(map(len, series.values())) < lines:
            with_box = turn % 2 == 0
            turn += 1
            under_test.robot.edit(SWITCH.format(int(with_box)))
            wanted = "ready" if with_box else "absent"
            _until(under_test, wanted)
            under_test.pass_time(1.5)
            for _ in range(5):
                _spin(under_test)
                for power in STEPS:
                    measured = _slow_down(under_test, power)
                    if measured is None:
                        break
                    series[with_box].append(measured[0])
                    under_test.pass_time(0.02)
    text = ["", "| console line to motor bytes, ms | N | p50 | p99 | max |", "|---|--:|--:|--:|--:|"]
    for with_box, found in series.items():
        name = "with the box" if with_box else "without it"
        text.append(
            f"| {name} | {len(found)} | "
            + " | ".join(f"{percentile(found, s):.2f}" for s in ("p50", "p99", "max"))
            + " |"
        )
    return text


def _until(under_test: Bench, phase: str) -> None:
    under_test.until(lambda: under_test.robot.capability("box")["phase"] == phase, 10.0, f"the box {phase}")
