"""The stages of a command from a plain client to the motor controller's bytes, compared with bare Zenoh.

`python -m benchmarks path --n 300`. The shipped robot gets commands in turns with three programs of zenoh-python alone,
which do the same work through a router of their own and have the same rank (`instruments/bare.py`). The robot spins,
and each command slows it down, which takes effect at once. A way ends when the driver's bytes are written. Then the
same beside pictures and streams at 100 Hz on both buses; then the cost of 20 commands a second; then a stream at 1 kHz.
rospy and dora are reported as skipped if they are requested: neither is installed with lbr.
"""

import argparse
import importlib.util
import json
import os
import pty
import shutil
import subprocess
import sys
import tempfile
import threading
import time
import tty
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any, Self

import msgspec
import psutil
import zenoh

from benchmarks import FOLDER, Measured
from benchmarks.instruments import bare
from benchmarks.instruments.stages import FOLDER_VARIABLE, Stages
from lbr.bus.access import TOOLS
from lbr.executive.processes.scheduling import Rank
from lbr.testing.robot import Robot
from tests.support import programs
from tests.support.bench import prepare
from tests.support.figures import percentile
from tests.support.robot import start

SMOKE = "--n 8 --seconds 3"
MOST, STEP = 400, 10
PERIOD_S = 0.05
GIVE_UP_S = 0.5
LEAST_HEARD = 50
"""The least number of messages of a stream: fewer give no figure."""
SAME_S = 0.4
"""The time to wait for a command of another power."""
EDITS = (
    "INSERT INTO capability (robot, name, kind, settings) VALUES ('lbr', 'hop_source', 'hop_source', '{}')",
    "INSERT INTO capability (robot, name, kind, settings) VALUES ('lbr', 'hop_sink', 'hop_sink', '{}')",
    "INSERT INTO channel (robot, source, target, history) VALUES ('lbr', 'hop_source.ticks', 'hop_sink.ticks', 64)",
)
SHOWN = (
    ("client", "arrived", "client, routers and wire, to the drive's process"),
    ("arrived", "woken", "wake-up of its loop"),
    ("woken", "decoded", "decode, stamp"),
    ("decoded", "decided", "what came before, chain and kernel"),
    ("decided", "sent", "what is said before the setpoint"),
    ("sent", "given", "encode, seal, hand to Zenoh"),
    ("given", "heard", "router and wire, to the driver's process"),
    ("heard", "stepped", "wake-up of its loop"),
    ("stepped", "gated", "seal, decode, gate"),
    ("gated", "written", "the controller's exchange, write"),
)
Way = dict[str, int]
APART = "UPDATE capability SET process = '' WHERE robot = 'lbr'"


def options(parser: argparse.ArgumentParser) -> None:
    """Add the amount."""
    parser.add_argument("--n", type=int, default=300, help="commands of each way (default %(default)s)")
    parser.add_argument("--seconds", type=float, default=10.0, help="of processor time and of the stream")
    parser.add_argument("--calm", action="store_true", help="leave out what is beside pictures and streams")
    parser.add_argument("--apart", action="store_true", help="give drive and motor driver a process each")
    parser.add_argument("--commands", action="store_true", help="measure commands alone, no stream")


def measure(given: argparse.Namespace) -> Measured:
    """Run both in turns."""
    text: list[str] = []
    broken: list[str] = []
    with ExitStack() as stack:
        place = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="lbr-")))
        ours = stack.enter_context(_robot(place / "h", place, apart=given.apart))
        theirs = stack.enter_context(_bare(place))
        clients = [
            stack.enter_context(_Client("lbr, at the local door", _plain(ours.endpoints[0]), "lbr/drive/command")),
            stack.enter_context(_Client("lbr, at the core", _owner(ours), "lbr/drive/command")),
            stack.enter_context(_Client("bare zenoh", _plain(theirs.endpoint), "bare/command")),
        ]
        units = _units(ours)
        _rank_alike(zip([ours.popen.pid, units["drive"], units["motors"]], theirs.pids, strict=True))
        text += _ways(clients, given.n, place / "stages", "", broken)
        text += _cost(clients[0], clients[2], ours, theirs, given.seconds)
        if not given.calm:
            with _program("load", ours.endpoints[0]), _program("load", theirs.endpoint):
                text += _ways(clients, given.n, place / "stages", ", beside pictures and streams", broken)
    if not given.commands:
        text += _stream(given.seconds, broken)
    text += [""]
    for other, package in (("rospy", "rospy"), ("dora", "dora")):
        there = importlib.util.find_spec(package) is not None
        text.append(f"{other}: skipped, {'no graph of it is part of this' if there else 'it is not installed'}")
    return Measured(text="\n".join(text), broken=broken)


class _Client:
    """A plain client that drives: it asks, quotes its lease, and waits for the answer."""

    def __init__(self, name: str, config: zenoh.Config, key: str) -> None:
        self.name = name
        self.ways: list[Way] = []
        self.sent: list[tuple[int, int, int]] = []
        self.answers_ms: list[float] = []
        self._config, self._key, self._lease = config, key, ""

    def __enter__(self) -> Self:
        self._session = zenoh.open(self._config)
        return self

    def __exit__(self, *_: object) -> None:
        self._session.close()

    def ask(self, power: int) -> bool:
        """Send a command, `power` in thousandths; return whether it was accepted."""
        command = {"power": power / 1000, "angle_deg": 90.0, "ttl_s": 1.0, "lease": self._lease, "take_over": True}
        payload = json.dumps(command)
        at_ns = time.monotonic_ns()
        replies = [reply.ok for reply in self._session.get(self._key, payload=payload, timeout=2.0)]
        answered_ns = time.monotonic_ns()
        said = json.loads(replies[0].payload.to_bytes()) if replies and replies[0] is not None else {}
        if not said.get("accepted"):
            self._lease = ""
            return False
        self._lease = said["lease"]
        self.sent.append((at_ns, answered_ns, power))
        return True

    def hold(self, power: int, seconds: float) -> None:
        """Repeat a command until it stays accepted for so long."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            if not self.ask(power):
                end = time.monotonic() + seconds
            time.sleep(PERIOD_S)


def _rank_alike(pairs: Iterable[tuple[int, int]]) -> None:
    """Give each process of the second kind the scheduler's rank of the first."""
    for like, other in pairs:
        Rank(other).set(os.getpriority(os.PRIO_PROCESS, like))


def _ways(clients: list[_Client], n: int, folder: Path, where: str, broken: list[str]) -> list[str]:
    """Let each client send its commands, in turns, and return a table of their ways."""
    for client in clients:
        client.ways.clear()
        client.answers_ms.clear()
    for _ in range(50):
        if min(len(client.ways) for client in clients) >= n:
            break
        for ramp in (clients[:1] + clients[2:], clients[1:]):  # two of them drive the same robot
            _ramp(ramp, folder)
    found = {client.name: client for client in clients}
    broken += [
        f"{name}{where}: {len(one.ways)} of {n} commands were seen whole"
        for name, one in found.items()
        if len(one.ways) < n
    ]
    least = clients[-1].ways
    lines = [
        "",
        f"| command to bytes{where}, ms | N | p50 | p99 | to bare, p50 | p99 | answer, p50 |",
        "|---|--:|--:|--:|--:|--:|--:|",
    ]
    whole = _spans(least, "client", "written")
    for name, client in found.items():
        spans = _spans(client.ways, "client", "written")
        row = [f"{percentile(spans, which):.3f}" for which in ("p50", "p99")]
        row += [f"{percentile(spans, which) / percentile(whole, which):.2f}" for which in ("p50", "p99")]
        lines.append(f"| {name} | {len(spans)} | {' | '.join(row)} | {percentile(client.answers_ms, 'p50'):.3f} |")
    lines += [
        "",
        f"| stage{where}, ms | {' | '.join(f'{name}, p50' for name in found)} |",
        "|---|" + "--:|" * len(found),
    ]
    for begin, end, what in SHOWN:
        cells = [_cell(client.ways, begin, end) for client in clients]
        lines.append(f"| {what} | {' | '.join(cells)} |")
    return lines


def _cell(ways: list[Way], begin: str, end: str) -> str:
    spans = _spans(ways, begin, end)
    if spans:
        return f"{percentile(spans, 'p50'):.3f}"
    if begin == "arrived" or end == "written":  # within one callback, from here to there
        begin, end = {"arrived": ("arrived", "sent"), "gated": ("heard", "written")}[begin]
        spans = _spans(ways, begin, end)
        return f"{percentile(spans, 'p50'):.3f} (all until then)" if spans else ""
    return ""


def _spans(ways: list[Way], begin: str, end: str) -> list[float]:
    return [(way[end] - way[begin]) * 1e-6 for way in ways if begin in way and end in way]


def _ramp(clients: list[_Client], folder: Path) -> None:
    """Bring all up to speed, then let each ask for less in turns, and read the stages."""
    for client in clients:
        client.hold(MOST, 0.0)
    holding = time.monotonic() + SAME_S
    while time.monotonic() < holding:
        for client in clients:
            client.ask(MOST)
        time.sleep(PERIOD_S)
    for client in clients:
        client.sent.clear()
    for power in range(MOST - STEP, STEP, -STEP):
        for client in clients:
            client.ask(power)
            time.sleep(PERIOD_S / len(clients))
    noted = {name: Stages(folder / name) for name in ("lbr", "bare")}
    for client in clients:
        stages = noted[client.name[:4].strip(",")]
        found = [(_way(stages, *sent), sent) for sent in client.sent]
        client.ways += [way for way, _ in found if way]
        client.answers_ms += [(answered - at) * 1e-6 for _, (at, answered, _) in found]


def _way(stages: Stages, at_ns: int, _answered_ns: int, power: int) -> Way:
    """Return the times of a command's stages; empty if it was not seen to arrive."""
    limit = at_ns + int(GIVE_UP_S * 1e9)
    written = stages.first("written", at_ns, power, limit)
    sent = stages.first("sent", at_ns, power, limit)
    if written is None or sent is None or sent > written:
        return {}
    way = {"client": at_ns, "written": written, "sent": sent}
    before = written
    for stage in ("gated", "stepped", "heard"):
        if (found := stages.last(stage, before)) is not None and found > sent:
            way[stage] = before = found
    given = stages.first("given", sent, power, limit)
    if given is not None:
        way["given"] = min(given, way.get("heard", given))  # within one process it arrives before all is handed over
    before = sent
    for stage in ("decided", "decoded", "woken", "arrived"):
        if (found := stages.last(stage, before)) is not None and found > at_ns:
            way[stage] = before = found
    return way


def _cost(ours: _Client, theirs: _Client, robot: Robot, other: "_Bare", seconds: float) -> list[str]:
    """Return the share of a core that each graph takes, at rest and at twenty commands a second."""
    units = _units(robot)
    graphs = {
        "lbr: executive, drive, motors": sorted({robot.popen.pid, units["drive"], units["motors"]}),
        "bare zenoh: router, drive, motors": other.pids,
    }
    table = ["", "| processor time, % of a core | at rest | at 20 commands a second |", "|---|--:|--:|"]
    rest = _shares(graphs, seconds, lambda: time.sleep(PERIOD_S))

    def both() -> None:
        ours.ask(100)
        theirs.ask(100)
        time.sleep(PERIOD_S)

    busy = _shares(graphs, seconds, both)
    return [*table, *(f"| {name} | {rest[name]:.1f} | {busy[name]:.1f} |" for name in graphs)]


def _units(robot: Robot) -> dict[str, int]:
    return {unit["name"]: unit["pid"] for unit in robot.ask("@status")["capabilities"]}


def _shares(graphs: dict[str, list[int]], seconds: float, once: Callable[[], None]) -> dict[str, float]:
    def spent(pids: list[int]) -> float:
        return sum(sum(psutil.Process(pid).cpu_times()[:2]) for pid in pids)

    before, began = {name: spent(pids) for name, pids in graphs.items()}, time.monotonic()
    while time.monotonic() < began + seconds:
        once()
    passed = time.monotonic() - began
    return {name: (spent(pids) - before[name]) / passed * 100 for name, pids in graphs.items()}


def _stream(seconds: float, broken: list[str]) -> list[str]:
    """Send a thousand messages a second both ways at once, and return their ages at their processing."""
    with ExitStack() as stack:
        place = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="lbr-")))
        home = prepare(place / "h", edits=EDITS)
        for kind in ("hop_source", "hop_sink"):
            copied = home / "capabilities" / f"{kind}.py"
            shutil.copy(FOLDER / "instruments" / "kinds" / copied.name, copied)
            copied.chmod(0o600)
        robot = start(home)
        stack.callback(robot.close)
        endpoint = f"unixsock-stream/{place}/bare"
        router = stack.enter_context(_program("router", endpoint))
        sink = stack.enter_context(_program("sink", endpoint, str(place / "bare.txt")))
        source = stack.enter_context(_program("source", endpoint))
        units = _units(robot)
        pairs = ((robot.popen.pid, router), (units["hop_source"], source), (units["hop_sink"], sink))
        _rank_alike((like, other.pid) for like, other in pairs)
        graphs = {
            "lbr: source": [units["hop_source"]],
            "lbr: sink": [units["hop_sink"]],
            "bare: source": [source.pid],
            "bare: sink": [sink.pid],
            "bare: router": [router.pid],
        }
        shares = _shares(graphs, seconds, lambda: time.sleep(PERIOD_S))
        ages = {"lbr": _numbers(home / "hops.txt"), "bare": _numbers(place / "bare.txt")}
    broken += [
        f"the stream of {name}: {len(found)} messages in {seconds:g} s"
        for name, found in ages.items()
        if len(found) < LEAST_HEARD
    ]
    if not all(ages.values()):
        return []
    lines = [
        "",
        "| stream at 1 kHz, publication to step, us | N | p50 | p99 | cpu of source, % | cpu of sink, % |",
        "|---|--:|--:|--:|--:|--:|",
    ]
    for name, found in ages.items():
        cells = [f"{percentile(found, which):.0f}" for which in ("p50", "p99")]
        lines.append(
            f"| {name} | {len(found)} | {' | '.join(cells)} | {shares[f'{name}: source']:.1f} | {shares[f'{name}: sink']:.1f} |"
        )
    p50, p99 = (percentile(ages["lbr"], which) / percentile(ages["bare"], which) for which in ("p50", "p99"))
    lines.append(
        f"| to bare | | {p50:.2f} | {p99:.2f} | {shares['lbr: source'] / shares['bare: source']:.2f} |"
        f" {shares['lbr: sink'] / shares['bare: sink']:.2f} |"
    )
    return lines


def _numbers(path: Path) -> list[float]:
    lines = path.read_text().split("\n")[:-1]
    return [float(line) for line in lines][len(lines) // 10 :]


class _Bare:
    """The programs of bare Zenoh that run."""

    def __init__(self, endpoint: str, pids: list[int]) -> None:
        self.endpoint = endpoint
        self.pids = pids


@contextmanager
def _bare(place: Path) -> Iterator[_Bare]:
    """Run router, drive and motors, with an obstacle published at 20 Hz, and read the line."""
    endpoint = f"unixsock-stream/{place}/bare"
    folder = place / "stages" / "bare"
    folder.mkdir(parents=True, exist_ok=True)
    master, slave = pty.openpty()
    tty.setraw(slave)
    threading.Thread(target=_drain, args=(master,), daemon=True).start()
    with ExitStack() as stack:
        router = stack.enter_context(_program("router", endpoint))
        drive = stack.enter_context(_program("drive", endpoint, stages=folder))
        motors = stack.enter_context(_program("motors", endpoint, os.ttyname(slave), stages=folder))
        session = stack.enter_context(zenoh.open(_plain(endpoint)))
        over = threading.Event()
        stack.callback(over.set)

        def near() -> None:
            while not over.wait(PERIOD_S):
                session.put("bare/ranges", msgspec.json.encode(bare.Ranges(forward_cm=120.0)))

        threading.Thread(target=near, daemon=True).start()
        yield _Bare(endpoint, [router.pid, drive.pid, motors.pid])


def _drain(master: int) -> None:
    while os.read(master, 4096):
        pass


@contextmanager
def _program(role: str, endpoint: str, *more: str, stages: Path | None = None) -> Iterator[Any]:
    """Run one of the programs, until it is no longer needed."""
    environment = os.environ | {"PYTHONPATH": str(FOLDER.parent)}
    environment.pop("ZENOH_RUNTIME", None)
    if stages is not None:
        environment[FOLDER_VARIABLE] = str(stages)
    argv = [sys.executable, str(Path(bare.__file__)), role, endpoint, *more]
    popen = programs.start(
        argv, env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, start_new_session=True
    )
    assert popen.stdout is not None
    try:
        if popen.stdout.readline().strip() != "ready":
            raise AssertionError(f"'{role}' did not start")
        yield popen
    finally:
        popen.communicate()


@contextmanager
def _robot(home: Path, place: Path, *, apart: bool) -> Iterator[Robot]:
    """Run the shipped base, whose processes note stages; `apart`: drive and motor driver have a process each."""
    folder = place / "stages" / "lbr"
    folder.mkdir(parents=True)
    paths = os.pathsep.join((str(FOLDER / "instruments" / "staged"), str(FOLDER.parent)))
    before = {name: os.environ.get(name) for name in ("PYTHONPATH", FOLDER_VARIABLE)}
    os.environ |= {"PYTHONPATH": paths, FOLDER_VARIABLE: str(folder)}
    try:
        robot = start(prepare(home, edits=(APART,) if apart else ()))
    finally:
        for name, value in before.items():
            os.environ.pop(name, None)
            if value is not None:
                os.environ[name] = value
    try:
        yield robot
    finally:
        robot.close()


def _plain(endpoint: str) -> zenoh.Config:
    return bare.settings("client", endpoint)


def _owner(robot: Robot) -> zenoh.Config:
    """Return its owner's connection to the core, past the local door."""
    running = json.loads((robot.home / "run" / f"{robot.name}.json").read_text())
    config = bare.settings("client", running["core"])
    config.insert_json5("transport/auth/usrpwd", json.dumps({"user": TOOLS, "password": running["password"]}))
    return config
