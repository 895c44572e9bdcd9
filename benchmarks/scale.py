"""The cost of a growing robot: capabilities at 10 Hz, words, channels, and clients at the door to other machines.

`python -m benchmarks scale --capabilities 0,10,20,40,80 --seconds 5`. Beside the base of lbr (motors, ranges, drive,
world) it runs that many trivial capabilities, each of which publishes a number ten times a second to nobody. For each
size it measures time to ready, processor time of the executive and of all, private memory of the executive and of a
trivial capability, and the executive's descriptors. It also measures the time from the commit of a row until a new word
is known and a new setting is in force. With `--share 20` twenty capabilities share each process, and the memory of one
is its share of that. `--words`, `--channels` and `--clients` are the numbers in the three last runs; 0 skips one. Exit
code 1 if a hard value is broken.
"""

import argparse
import contextlib
import json
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import plotille
import psutil
import zenoh

from benchmarks import Measured
from lbr.bus import session
from lbr.errors import BusError
from tests.support.bench import Bench, let_go, processes_of, temporary_home
from tests.support.door import opened
from tests.support.figures import Promise, Results
from tests.support.robot import Robot, start

SMOKE = "--capabilities 0,2 --seconds 0.5 --words 50 --channels 20 --clients 2"

PROMISES = {
    "ready": Promise(what="80 trivial capabilities: `lbr run` to ready", unit="s", target=5.0, hard=60.0),
    "word": Promise(what="80 trivial capabilities: row edit to effect", unit="s", target=1.0, hard=10.0),
}
LARGEST = 80
LONGEST_S = 60.0
ENDS = 10
"""Outputs and inputs of each capability that channels connect."""
TRIVIAL = '''"""A capability that does next to nothing."""

from typing import Annotated

from msgspec import Meta, Struct

from lbr.capability.base import Capability
from lbr.capability.kind import Kind


class Number(Struct, frozen=True, kw_only=True):
    """A number."""

    number: int


class Settings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How often it tells, and what it adds."""

    hz: Annotated[float, Meta(gt=0.0, le=100.0)] = 10.0
    quiet: bool = False
    add: int = 1


class Trivial(Capability[Settings]):
    """Counts."""

    woken_by_streams = False

    def __init__(self, ctx):
        super().__init__(ctx)
        self.rate_hz = ctx.settings.hz
        self._number = 0

    def step(self):
        if self.ctx.on_tick and not self.ctx.settings.quiet:
            self._number += self.ctx.settings.add
            self.ctx.publish("o0", Number(number=self._number))


KIND = Kind(
    name="trivial",
    summary="counts",
    family="app",
    entry=Trivial,
    settings=Settings,
    inputs={f"i{n}": Number for n in range(10)},
    outputs={f"o{n}": Number for n in range(10)},
)
'''


class Cost(NamedTuple):
    """The cost of a robot of some size; nan if it is not measured."""

    ready_s: float
    executive_percent: float
    all_percent: float
    executive_mib: float
    trivial_mib: float
    descriptors: int
    word_s: float
    setting_s: float

    def row(self, name: str) -> str:
        """Return it as a row of a table."""
        shown = f"{self.ready_s:.2f} | {self.executive_percent:.1f} | {self.all_percent:.1f} | {self.executive_mib:.1f}"
        return f"| {name} | {shown} | {self.trivial_mib:.1f} | {self.descriptors} | {self.word_s:.2f} | {self.setting_s:.2f} |"


def options(parser: argparse.ArgumentParser) -> None:
    """Add the amounts."""
    parser.add_argument(
        "--capabilities", default="0,10,20,40,80", help="how many, one after the other (default %(default)s)"
    )
    parser.add_argument("--share", type=int, default=1, help="how many share a process (default: none do)")
    parser.add_argument("--seconds", type=float, default=5.0, help="how long each is idle (default %(default)s)")
    parser.add_argument("--words", type=int, default=10_000, help="rows of words (default %(default)s)")
    parser.add_argument("--channels", type=int, default=5_000, help="rows of channels (default %(default)s)")
    parser.add_argument("--clients", type=int, default=50, help="clients at the door (default %(default)s)")


def measure(given: argparse.Namespace) -> Measured:
    """Run robots of each size."""
    results = Results(PROMISES)
    sizes = [int(size) for size in given.capabilities.split(",") if size]
    costs: dict[str, Cost] = {}
    for size in sizes:
        with _robot(_capabilities(size, given.share)) as (robot, ready_s):
            cost = costs[f"{size} capabilities"] = _cost(robot, ready_s, given.seconds, edits=size > 0)
        if size >= LARGEST:
            results.sample("ready", cost.ready_s)
            results.sample("word", cost.word_s)
    if given.words:
        with _robot(_words(given.words)) as (robot, ready_s):
            costs[f"{given.words} words"] = _cost(robot, ready_s, given.seconds)
    if given.channels:
        with _robot(_channels(given.channels)) as (robot, ready_s):
            costs[f"{given.channels} channels"] = _cost(robot, ready_s, given.seconds)
    if given.clients:
        costs[f"{given.clients} clients at the door"] = _at_the_door(given.clients, given.seconds)
    plotted = [(size, costs[f"{size} capabilities"]) for size in sizes]
    return Measured(results=results.ordered(), load=f"idle for {given.seconds:g} s", text=_text(costs, plotted))


# -- rows -------------------------------------------------------------------------------------------------------------


def _capabilities(count: int, share: int) -> list[str]:
    processes = [f"many{n // share}" if share > 1 else "" for n in range(count)]
    return [
        f"INSERT INTO capability (robot, name, kind, process) VALUES ('lbr', 't{n}', 'trivial', '{process}')"
        for n, process in enumerate(processes)
    ]


def _words(count: int) -> list[str]:
    words = ", ".join(
        f"('lbr', 'word{n}', 'word{n}', 'executive.report', '{{\"name\": \"health\"}}')" for n in range(count)
    )
    return [f"INSERT INTO verb (robot, word, pattern, target, payload) VALUES {words}"] if count else []


def _channels(count: int) -> list[str]:
    """Return rows of the fewest silent capabilities with so many pairs of outputs and inputs."""
    names = 1
    while names * names * ENDS * ENDS < count:
        names += 1
    ends = [(name, end) for name in range(names) for end in range(ENDS)]
    pairs = [(source, target) for source in ends for target in ends][:count]
    silent = ", ".join(f"('lbr', 't{n}', 'trivial', '{{\"quiet\": true}}')" for n in range(names))
    rows = ", ".join(f"('lbr', 't{a}.o{b}', 't{c}.i{d}')" for (a, b), (c, d) in pairs)
    return [
        f"INSERT INTO capability (robot, name, kind, settings) VALUES {silent}",
        f"INSERT INTO channel (robot, source, target) VALUES {rows}",
    ]


@contextmanager
def _robot(edits: Sequence[str], *arguments: str) -> Iterator[tuple[Robot, float]]:
    with temporary_home(edits=tuple(edits)) as home:
        _add_kind(home)
        began = time.monotonic()
        robot = start(home, *arguments, limit_s=LONGEST_S)
        ready_s = time.monotonic() - began
        try:
            yield robot, ready_s
        finally:
            let_go(robot)
            print(f"{robot.home}: ended", file=sys.stderr, flush=True)


def _add_kind(home: Path) -> None:
    file = home / "capabilities" / "trivial.py"
    file.write_text(TRIVIAL)
    file.chmod(0o600)


# -- figures ----------------------------------------------------------------------------------------------------------


def _cost(robot: Robot, ready_s: float, seconds: float, *, edits: bool = False) -> Cost:
    Bench.pass_time(1.0)
    executive = psutil.Process(robot.popen.pid)
    units = {unit["name"]: unit["pid"] for unit in robot.line("/report/health")["data"]["capabilities"]}
    pids = [pid for name, pid in units.items() if name.startswith("t") and name[1:].isdigit()]
    trivial = [psutil.Process(pid) for pid in set(pids)]
    everyone = [executive, *processes_of(robot.home)]
    before = [_cpu_s(process) for process in everyone]
    began = time.monotonic()
    Bench.pass_time(seconds)
    spent_s = time.monotonic() - began
    spent = [(_cpu_s(process) - was) / spent_s * 100 for process, was in zip(everyone, before, strict=True)]
    return Cost(
        ready_s=ready_s,
        executive_percent=spent[0],
        all_percent=sum(spent),
        executive_mib=_private_mib(executive),
        trivial_mib=sum(map(_private_mib, trivial)) / len(pids) if trivial else float("nan"),
        descriptors=executive.num_fds(),
        word_s=_until_word(robot),
        setting_s=_until_setting(robot) if edits else float("nan"),
    )


def _until_word(robot: Robot) -> float:
    robot.edit(
        "INSERT INTO verb (robot, word, pattern, target, payload) "
        """VALUES ('lbr', 'fresh', 'fresh', 'executive.report', '{"name": "health"}')"""
    )
    return _until(lambda: robot.line("fresh")["code"] == 0)


def _until_setting(robot: Robot) -> float:
    """Return the time until a capability runs again with another setting, and is ready."""
    uptime_s = robot.capability("t0")["uptime_s"]
    robot.edit("UPDATE capability SET settings = '{\"add\": 2}' WHERE robot = 'lbr' AND name = 't0'")

    def there() -> bool:
        unit = robot.capability("t0")
        return bool(unit["phase"] == "ready" and unit["uptime_s"] < uptime_s)

    return _until(there)


def _until(there: Callable[[], bool]) -> float:
    began = time.monotonic()
    while not there():
        if time.monotonic() - began > LONGEST_S:
            return float("inf")
        Bench.pass_time(0.01)
    return time.monotonic() - began


def _at_the_door(count: int, seconds: float) -> Cost:
    """Return the cost of a robot with so many clients that receive the drive's state; ready: all are connected."""
    with temporary_home() as home, opened(home) as door, contextlib.ExitStack() as stack:
        began = time.monotonic()
        for _ in range(count):
            client = stack.enter_context(_client(door.settings(door.tokens["eye"], timeout_s=10.0)))
            client.declare_subscriber("lbr/drive/state", zenoh.handlers.RingChannel(1))
        return _cost(door.robot, time.monotonic() - began, seconds)


@contextmanager
def _client(settings: dict[str, object]) -> Iterator[session.Session]:
    try:
        found = zenoh.open(zenoh.Config.from_json5(json.dumps(settings)))
    except zenoh.ZError as err:
        raise BusError(f"the door lets no more in: {err}") from err
    try:
        yield found
    finally:
        found.close()


def _text(costs: dict[str, Cost], plotted: list[tuple[int, Cost]]) -> str:
    lines = [
        "",
        (
            "| robot | ready, s | executive, % of a core | all, % of a core | executive private, MiB | trivial private, MiB "
            "| executive's descriptors | new word after, s | new setting after, s |"
        ),
        "|---|--:|--:|--:|--:|--:|--:|--:|--:|",
        *(cost.row(name) for name, cost in costs.items()),
    ]
    for label, value in (
        ("seconds to ready", lambda cost: cost.ready_s),
        ("executive, % of a core", lambda cost: cost.executive_percent),
        ("seconds from a row to its word", lambda cost: cost.word_s),
    ):
        if len(plotted) > 1:
            lines += ["", f"{label}, by the number of trivial capabilities", _plot(plotted, value)]
    return "\n".join(lines)


def _plot(plotted: list[tuple[int, Cost]], value: Callable[[Cost], float]) -> str:
    figure = plotille.Figure()
    figure.width, figure.height = 60, 12
    figure.set_x_limits(0, max(size for size, _ in plotted))
    figure.set_y_limits(0, max(0.1, *(value(cost) for _, cost in plotted)))
    figure.plot([size for size, _ in plotted], [value(cost) for _, cost in plotted])
    return str(figure.show())


def _cpu_s(process: psutil.Process) -> float:
    times = process.cpu_times()
    return float(times.user + times.system)


def _private_mib(process: psutil.Process) -> float:
    return float(process.memory_full_info().uss) / 2**20
