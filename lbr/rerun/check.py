"""Runs a recording through the robot's own processes, and says where they did something else than then."""

import contextlib
import os
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import msgspec
from msgspec import Struct

from lbr import home
from lbr.bus import access, keys, session, wire
from lbr.bus import stamp as stamps
from lbr.bus.session import Session
from lbr.errors import BusError, InputError
from lbr.messages.recorded import RecordedRows
from lbr.messages.system import Event
from lbr.recording import lines, selection
from lbr.recording.chunks import Message
from lbr.rerun import alike, rows
from lbr.rerun.ends import Asked, Clock, Ends
from lbr.rerun.feed import Feed, Said

READY_S = 60.0
STOP_S = 10.0
AFTER_S = 0.3
ROUND_S = 0.002
REASON_NS = 1_000_000_000
"""So far apart the same event may be: a state that is told once a second."""
RENEWED_NS = 300_000_000
"""A goal that ends so much earlier or later ends as it did: leases are renewed ten times a second."""
SETTLED_NS = 200_000_000
EXECUTIVE = "executive"
ONE_IN = 50
"""Samples of which one may be another: a pulse of a turn's last, creeping steps."""
RESULT = "/result"
ESTOP, RESET = "estop", "estop_reset"

Tell = Callable[[str], None]


class Recorded(Struct, kw_only=True):
    """What of a recording is run again."""

    robot: str
    rows: RecordedRows
    taken: lines.Taken
    start_ns: int
    end_ns: int
    streams: dict[str, list[tuple[int, dict[str, Any]]]] = {}
    events: tuple[tuple[int, Event], ...] = ()
    ended: dict[str, int] = {}
    """When each goal ended."""


class Outcome(Struct, kw_only=True):
    """What came of it. `setpoints` has the samples of each stream, `differences` where they were others."""

    seconds: float
    runs: tuple[str, ...]
    left_out: Mapping[str, str]
    setpoints: dict[str, int]
    differences: dict[str, list[alike.Difference]]
    said: int
    answered_otherwise: list[Said]
    begun_before: int
    reasons: int
    missing: list[alike.Happened]
    new: list[alike.Happened]
    late_s: float
    asked: dict[str, Asked] = {}

    @property
    def same(self) -> bool:
        """Say whether setpoints, answers and reasons were as recorded."""
        return not (any(map(self.differs, self.setpoints)) or self.answered_otherwise or self.missing or self.new)

    def differs(self, topic: str) -> bool:
        """Say whether a stream of setpoints was another, but for a sample in `ONE_IN`."""
        return len({one.at_ns for one in self.differences[topic]}) * ONE_IN > self.setpoints[topic]


class _Reader:
    """Sorts the messages of a recording."""

    def __init__(self) -> None:
        self.rows: RecordedRows | None = None
        self.edited = False
        self.robot = ""
        self.taped: list[Message] = []
        self.streams: dict[str, list[tuple[int, dict[str, Any]]]] = {}
        self.events: list[tuple[int, Event]] = []
        self.ended: dict[str, int] = {}

    def take(self, one: Message) -> None:
        """Take a message."""
        if one.topic.startswith(lines.TAPED):
            self.taped.append(one)
        elif one.topic == selection.EVENT:
            event = _decoded(one.data, Event)
            if event is not None:
                self.events.append((one.log_ns, event))
        elif one.topic == "@rows":
            found = _decoded(one.data, RecordedRows)
            self.edited |= self.rows is not None and found is not None and found.revision != self.rows.revision
            self.rows = found or self.rows
        elif one.topic == "@status":
            self.robot = str((_decoded(one.data, dict[str, Any]) or {}).get("robot", self.robot))
        elif one.topic.endswith(RESULT):
            message = _decoded(one.data, dict[str, Any])
            if message is not None:
                self.ended.setdefault(str(message.get("goal", "")), one.log_ns)
        elif one.topic.endswith("/setpoint"):
            message = _decoded(one.data, dict[str, Any])
            if message is not None:
                self.streams.setdefault(one.topic, []).append((one.log_ns, message))


def read(files: tuple[Path, ...], start_ns: int, end_ns: int) -> Recorded:
    """Take what is needed out of a recording; InputError says what it lacks."""
    found = _Reader()
    for one in selection.messages(files, 0, end_ns):
        found.take(one)
    if not found.taped:
        raise InputError("the recording has no bytes of lines: it was made without 'lbr record --lines'", "bad_value")
    if found.rows is None or not found.robot:
        raise InputError("the recording has no rows: it is cut, or was made by another program", "bad_value")
    if found.edited:
        raise InputError("rows were edited while it was recorded: say which part with --from and --to", "not_possible")
    opened_ns = max((one.log_ns for one in found.taped if lines.is_opening(one)), default=0)
    begin, last_ns = max(opened_ns + SETTLED_NS, start_ns), found.taped[-1].log_ns
    if begin >= last_ns:
        raise InputError("nothing was recorded in that time", "bad_value")
    return Recorded(
        robot=found.robot,
        rows=found.rows,
        taken=lines.taken(found.taped),
        start_ns=begin,
        end_ns=last_ns,
        streams=found.streams,
        events=tuple(found.events),
        ended=found.ended,
    )


def run(recorded: Recorded, tell: Tell) -> Outcome:
    """Run it; InputError if it cannot run here, BusError if it does not come up."""
    with tempfile.TemporaryDirectory(prefix="lbr-replay-") as folder:
        place = Path(folder)
        place.chmod(0o700)
        made = rows.prepare(place, recorded.robot, recorded.rows, recorded.taken.lines)
        if not made.devices:
            raise InputError("none of the recorded lines belongs to a capability that can run here", "not_possible")
        clock = Clock(recorded.start_ns, recorded.end_ns)
        ends = Ends(clock, {address: recorded.taken.lines[device] for device, address in made.devices.items()})
        try:
            with _running(made, recorded.robot) as bus:
                tell("up, on the recorded bytes")
                outcome = _compare(recorded, made, clock, bus, tell)
        finally:
            asked = ends.close()
        outcome.asked = {device: asked[address] for device, address in made.devices.items() if address in asked}
        return outcome


def _compare(recorded: Recorded, made: rows.Place, clock: Clock, bus: Session, tell: Tell) -> Outcome:
    setpoints = [f"{name}/{port}" for name, kind in made.runs.items() for port in kind.setpoints]
    heard = {topic: wire.Subscription(bus, f"{recorded.robot}/{topic}", depth=100_000) for topic in setpoints}
    happened = wire.Subscription(bus, keys.event(recorded.robot), depth=10_000)
    outside = [one for one in recorded.taken.commands if one.source not in made.runs and one.to in made.runs]
    within = [one for one in outside if recorded.start_ns <= one.at_ns <= recorded.end_ns and one.source != EXECUTIVE]
    stops = [
        (at, event.kind == ESTOP)
        for at, event in recorded.events
        if recorded.start_ns <= at <= recorded.end_ns and event.subject == EXECUTIVE and event.kind in {ESTOP, RESET}
    ]
    results = [f"{name}{RESULT}" for name, kind in made.runs.items() if RESULT[1:] in kind.outputs]
    feed = Feed(bus, recorded.robot, within, stops, recorded.ended, results)
    clock.start()
    rest = threading.Event()
    told = 0.0
    while (now_ns := clock.now_ns()) < recorded.end_ns:
        feed.step(now_ns)
        rest.wait(ROUND_S)
        if time.monotonic() - told > 1.0:
            told = time.monotonic()
            tell(f"{(now_ns - recorded.start_ns) / 1e9:.0f} of {(recorded.end_ns - recorded.start_ns) / 1e9:.0f} s")
    until = time.monotonic() + STOP_S
    while not feed.finish(recorded.end_ns) and time.monotonic() < until:
        rest.wait(ROUND_S)

    def dated(mono_ns: int) -> int:
        return mono_ns - clock.began_ns + recorded.start_ns

    now = {topic: _samples(one, dated) for topic, one in heard.items()}
    window_ns = alike.WINDOW_NS + feed.late_ns
    differences = {}
    counts = {}
    inner = recorded.start_ns + window_ns, recorded.end_ns - window_ns
    for topic in setpoints:
        then = [(at, alike.numbers(message)) for at, message in recorded.streams.get(topic, [])]
        counts[topic] = sum(inner[0] <= at <= inner[1] for at, _ in then)
        found = alike.differences(then, now[topic], window_ns)
        differences[topic] = [one for one in found if inner[0] <= one.at_ns <= inner[1]]
    then_events = _happened(recorded.events, made.runs, recorded)
    now_events = _happened(_events(happened, dated), made.runs, recorded)
    missing, new = alike.unmatched(then_events, now_events, REASON_NS + window_ns)
    edge = REASON_NS + window_ns

    def inside(one: alike.Happened) -> bool:
        return recorded.start_ns + edge <= one.at_ns <= recorded.end_ns - edge

    return Outcome(
        seconds=(recorded.end_ns - recorded.start_ns) / 1e9,
        runs=tuple(made.runs),
        left_out=made.left_out,
        setpoints=counts,
        differences=differences,
        said=len(feed.said),
        answered_otherwise=feed.otherwise(window_ns + RENEWED_NS),
        begun_before=feed.begun_before,
        reasons=len(then_events),
        missing=[one for one in missing if inside(one)],
        new=[one for one in new if inside(one)],
        late_s=feed.late_ns / 1e9,
    )


def _samples(heard: wire.Subscription, dated: Callable[[int], int]) -> list[tuple[int, dict[str, float]]]:
    found = []
    for raw in heard.take():
        message = _decoded(raw.payload, dict)
        stamp = stamps.read(raw.attachment)
        if isinstance(message, dict):
            at_ns = stamp.mono_ns if stamp is not None and stamp.mono_ns else int(raw.arrived * 1e9)
            found.append((dated(at_ns), alike.numbers(message)))
    return sorted(found, key=lambda one: one[0])


def _events(heard: wire.Subscription, dated: Callable[[int], int]) -> Iterator[tuple[int, Event]]:
    for raw in heard.take():
        event = _decoded(raw.payload, Event)
        if event is not None:
            yield dated(int(raw.arrived * 1e9)), event


def _happened(
    events: "Iterator[tuple[int, Event]] | tuple[tuple[int, Event], ...]", runs: Mapping[str, Any], recorded: Recorded
) -> list[alike.Happened]:
    return [
        alike.Happened(at, event.subject, event.kind, event.code)
        for at, event in events
        if event.code and event.subject in runs and recorded.start_ns <= at <= recorded.end_ns
    ]


@contextlib.contextmanager
def _running(made: rows.Place, robot: str) -> Iterator[Session]:
    """Run the robot for the time of a `with`; raise BusError with its own words if it does not come up."""
    environment = os.environ | {"LBR_HOME": str(made.home)}
    command = [sys.executable, "-m", "lbr.cli", "run", str(made.profile), "--db", str(made.home / "robot.db")]
    with (made.home / "said.txt").open("w+b") as said:
        process = subprocess.Popen([*command, "--no-console"], env=environment, stdout=said, stderr=said)
        try:
            found = _up(process, made, robot, Path(said.name))
            credentials = access.Credentials(user=access.TOOLS, password=found.password)
            with contextlib.closing(session.open_client((found.core,), credentials)) as bus:
                yield bus
        finally:
            process.terminate()
            try:
                process.wait(STOP_S)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()


def _up(process: "subprocess.Popen[bytes]", made: rows.Place, robot: str, said: Path) -> home.Running:
    rest = threading.Event()
    until = time.monotonic() + READY_S
    while time.monotonic() < until:
        if process.poll() is not None:
            raise BusError(f"the robot did not start: {said.read_text(errors='replace').strip()[-800:]}")
        for line in said.read_bytes().splitlines():
            if line.startswith(b"{"):
                told = _decoded(line, dict) or {}
                if not told.get("ready"):
                    raise BusError(f"the robot did not come up on the recorded bytes: {told.get('reason', told)}")
                return _record(made, robot)
        rest.wait(0.02)
    raise BusError(f"the robot did not come up within {READY_S:g} s: {said.read_text(errors='replace').strip()[-800:]}")


def _record(made: rows.Place, robot: str) -> home.Running:
    """Return how to reach the robot of that home."""
    return msgspec.json.decode((made.home / "run" / f"{robot}.json").read_bytes(), type=home.Running)


def _decoded(data: bytes, kind: Any) -> Any:
    try:
        return msgspec.json.decode(data, type=kind)
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError):
        return None
