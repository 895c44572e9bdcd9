"""Reruns a recording through the robot's own processes, and returns the differences."""

import contextlib
import os
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path

import msgspec
from msgspec import Struct

from lbr import home
from lbr.apps.recorder.recording import lines, selection
from lbr.apps.recorder.recording.chunks import Message
from lbr.apps.recorder.recording.decoding import read_or_none
from lbr.apps.recorder.recording.recorded import RecordedRows
from lbr.apps.recorder.rerun import alike, rows
from lbr.apps.recorder.rerun.ends import Clock, Ends, Questions
from lbr.apps.recorder.rerun.feed import Feed, Sent
from lbr.bus import access, keys, session, wire
from lbr.bus import stamp as stamps
from lbr.bus.session import Session
from lbr.errors import BusError, InputError
from lbr.messages.system import Event

READY_S = 60.0
STOP_S = 10.0
ROUND_S = 0.002
SAMPLES, EVENTS = 100_000, 10_000
"""More than a recording of some minutes has of one stream."""
REASON_NS = 1_000_000_000
"""The greatest distance in time of equal events: that of a state that is published once a second."""
RENEWED_NS = 300_000_000
"""The greatest difference in the end of an equal goal, as leases are renewed ten times a second."""
SETTLED_NS = 200_000_000
LATE_S = 0.5
"""The lateness of a command beyond which the window of comparison would be so wide that nothing differs."""
EXECUTIVE = "executive"
ONE_IN = 50
"""One sample in this many may differ: a pulse of a turn's last, creeping steps."""
RESULT = "/result"
ESTOP, RESET = "estop", "estop_reset"

Tell = Callable[[str], None]


class Recorded(Struct, kw_only=True):
    """The part of a recording to rerun."""

    robot: str
    rows: RecordedRows
    exchanged: lines.RecordedLines
    start_ns: int
    end_ns: int
    streams: dict[str, list[tuple[int, dict[str, object]]]] = {}
    events: tuple[tuple[int, Event], ...] = ()
    ended: dict[str, int] = {}
    """The end time of each goal."""

    def holds(self, at_ns: int, margin_ns: int = 0) -> bool:
        """Return whether a time lies in it, at least `margin_ns` from both ends."""
        return self.start_ns + margin_ns <= at_ns <= self.end_ns - margin_ns


class Outcome(Struct, kw_only=True):
    """The result. `setpoints` counts the samples of each stream, `differences` lists those that differ."""

    seconds: float
    runs: tuple[str, ...]
    left_out: Mapping[str, str]
    setpoints: dict[str, int]
    differences: dict[str, list[alike.Difference]]
    commands: int
    answered_otherwise: list[Sent]
    begun_before: int
    reasons: int
    missing: list[alike.CodedEvent]
    added: list[alike.CodedEvent]
    late_s: float
    asked: dict[str, Questions] = {}

    @property
    def late(self) -> bool:
        """Return whether this machine was too busy to send the commands in time, so that the result means nothing."""
        return self.late_s > LATE_S

    @property
    def same(self) -> bool:
        """Return whether setpoints, answers and reasons are as recorded."""
        return not (
            self.late or any(map(self.differs, self.setpoints)) or self.answered_otherwise or self.missing or self.added
        )

    def differs(self, topic: str) -> bool:
        """Return whether more than one sample in `ONE_IN` of a stream differs."""
        return len({one.at_ns for one in self.differences[topic]}) * ONE_IN > self.setpoints[topic]


class _Reader:
    """Sorts the messages of a recording."""

    def __init__(self) -> None:
        self.rows: RecordedRows | None = None
        self.edited = False
        self.robot = ""
        self.taped: list[Message] = []
        self.streams: dict[str, list[tuple[int, dict[str, object]]]] = {}
        self.events: list[tuple[int, Event]] = []
        self.ended: dict[str, int] = {}

    def take(self, item: Message) -> None:
        """Sort in a message."""
        if item.topic.startswith(lines.TAPED):
            self.taped.append(item)
        elif item.topic == selection.EVENT:
            if (event := item.read(Event)) is not None:
                self.events.append((item.log_ns, event))
        elif item.topic == "@rows":
            saved = item.read(RecordedRows)
            self.edited |= self.rows is not None and saved is not None and saved.revision != self.rows.revision
            self.rows = saved or self.rows
        elif item.topic == "@status":
            self.robot = str((item.read(dict[str, object]) or {}).get("robot", self.robot))
        elif item.topic.endswith(RESULT):
            if (message := item.read(dict[str, object])) is not None:
                self.ended.setdefault(str(message.get("goal", "")), item.log_ns)
        elif item.topic.endswith("/setpoint") and (message := item.read(dict[str, object])) is not None:
            self.streams.setdefault(item.topic, []).append((item.log_ns, message))


def read(files: tuple[Path, ...], start_ns: int, end_ns: int) -> Recorded:
    """Read the parts of a recording that a rerun needs; raise InputError if one is missing."""
    recording, damage = _Reader(), selection.Damage()
    for message in selection.messages(files, 0, end_ns, damage=damage):
        recording.take(message)
    if not recording.taped:
        lost = "".join(f"; {fault}" for fault in damage.files)
        if damage.places:
            lost += f", or they were in the {damage.bytes} bytes of it that are damaged or cut"
        raise InputError(
            f"the recording has no bytes of lines: it was made without 'lbr record --lines'{lost}", "bad_value"
        )
    if recording.rows is None or not recording.robot:
        raise InputError("the recording has no rows: it is cut, or was made by another program", "bad_value")
    if recording.edited:
        raise InputError("rows were edited while it was recorded: say which part with --from and --to", "not_possible")
    opened_ns = max((piece.log_ns for piece in recording.taped if lines.is_opening(piece)), default=0)
    begin, last_ns = max(opened_ns + SETTLED_NS, start_ns), recording.taped[-1].log_ns
    if begin >= last_ns:
        raise InputError("nothing was recorded in that time", "bad_value")
    return Recorded(
        robot=recording.robot,
        rows=recording.rows,
        exchanged=lines.recorded_lines(recording.taped),
        start_ns=begin,
        end_ns=last_ns,
        streams=recording.streams,
        events=tuple(recording.events),
        ended=recording.ended,
    )


def run(recorded: Recorded, tell: Tell) -> Outcome:
    """Rerun a recording; raise InputError if it cannot run here, BusError if the robot does not start."""
    with tempfile.TemporaryDirectory(prefix="lbr-replay-") as folder:
        place = Path(folder)
        place.chmod(0o700)
        made = rows.prepare(place, recorded.robot, recorded.rows, recorded.exchanged.lines)
        if not made.devices:
            raise InputError("none of the recorded lines belongs to a capability that can run here", "not_possible")
        clock = Clock(recorded.start_ns, recorded.end_ns)
        ends = Ends(clock, {address: recorded.exchanged.lines[device] for device, address in made.devices.items()})
        try:
            with _running(made, recorded.robot) as bus:
                tell("up, on the recorded bytes")
                witness, feed = _Witness(bus, recorded, made, clock), _feed(bus, recorded, made)
                _play(feed, clock, recorded, tell)
                outcome = witness.outcome(feed, made)
        finally:
            asked = ends.close()
        outcome.asked = {device: asked[address] for device, address in made.devices.items() if address in asked}
        return outcome


def _feed(bus: Session, recorded: Recorded, made: rows.Rerun) -> Feed:
    """Return the commands and stops that came from outside the robot."""
    own = {*made.runs, EXECUTIVE}
    commands = [
        command for command in recorded.exchanged.commands if command.source not in own and command.to in made.runs
    ]
    stops = [(at, event.kind == ESTOP) for at, event in recorded.events if event.kind in {ESTOP, RESET}]
    return Feed(
        bus,
        recorded.robot,
        [command for command in commands if recorded.holds(command.at_ns)],
        [stop for stop in stops if recorded.holds(stop[0])],
        recorded.ended,
        [f"{name}{RESULT}" for name, kind in made.runs.items() if RESULT[1:] in kind.outputs],
    )


def _play(feed: Feed, clock: Clock, recorded: Recorded, tell: Tell) -> None:
    """Send everything at its time, and wait for the last answers."""
    rest, told_s = threading.Event(), 0.0
    clock.start()
    while (now_ns := clock.now_ns()) < recorded.end_ns:
        feed.step(now_ns)
        rest.wait(ROUND_S)
        if time.monotonic() - told_s > 1.0:
            told_s = time.monotonic()
            tell(f"{(now_ns - recorded.start_ns) / 1e9:.0f} of {(recorded.end_ns - recorded.start_ns) / 1e9:.0f} s")
    until = time.monotonic() + STOP_S
    while not feed.finish(recorded.end_ns) and time.monotonic() < until:
        rest.wait(ROUND_S)


class _Witness:
    """Receives the setpoints and events of the robot."""

    def __init__(self, bus: Session, recorded: Recorded, made: rows.Rerun, clock: Clock) -> None:
        topics = [f"{name}/{port}" for name, kind in made.runs.items() for port in kind.setpoints]
        self._setpoints = {one: wire.Subscription(bus, f"{recorded.robot}/{one}", depth=SAMPLES) for one in topics}
        self._events = wire.Subscription(bus, keys.event(recorded.robot), depth=EVENTS)
        self._recorded, self._runs, self._clock = recorded, made.runs, clock

    def outcome(self, feed: Feed, made: rows.Rerun) -> Outcome:
        """Return the differences from the recording; both its ends are left out, as they have too little to compare."""
        recorded, window_ns = self._recorded, alike.WINDOW_NS + feed.late_ns
        counts, differences = {}, {}
        for topic, subscription in self._setpoints.items():
            then = [(at, alike.numbers(message)) for at, message in recorded.streams.get(topic, [])]
            diffs = alike.differences(then, self._samples(subscription), window_ns)
            counts[topic] = sum(recorded.holds(at, window_ns) for at, _ in then)
            differences[topic] = [diff for diff in diffs if recorded.holds(diff.at_ns, window_ns)]
        reason_ns = REASON_NS + window_ns
        happened = self._coded(recorded.events)
        missing, unrecorded = alike.unmatched(happened, self._coded(self._published_events()), reason_ns)
        return Outcome(
            seconds=(recorded.end_ns - recorded.start_ns) / 1e9,
            runs=tuple(made.runs),
            left_out=made.left_out,
            setpoints=counts,
            differences=differences,
            commands=len(feed.sent),
            answered_otherwise=feed.otherwise(window_ns + RENEWED_NS),
            begun_before=feed.begun_before,
            reasons=len(happened),
            missing=[event for event in missing if recorded.holds(event.at_ns, reason_ns)],
            added=[event for event in unrecorded if recorded.holds(event.at_ns, reason_ns)],
            late_s=feed.late_ns / 1e9,
        )

    def _dated(self, mono_ns: int) -> int:
        return mono_ns - self._clock.began_ns + self._recorded.start_ns

    def _samples(self, subscription: wire.Subscription) -> list[tuple[int, dict[str, float]]]:
        samples = []
        for raw in subscription.take():
            message, stamp = read_or_none(raw.payload, dict[str, object]), stamps.read(raw.attachment)
            if message is not None:
                at_ns = stamp.mono_ns if stamp is not None and stamp.mono_ns else int(raw.arrived * 1e9)
                samples.append((self._dated(at_ns), alike.numbers(message)))
        return sorted(samples, key=lambda one: one[0])

    def _published_events(self) -> Iterator[tuple[int, Event]]:
        for raw in self._events.take():
            event = read_or_none(raw.payload, Event)
            if event is not None:
                yield self._dated(int(raw.arrived * 1e9)), event

    def _coded(self, events: Iterable[tuple[int, Event]]) -> list[alike.CodedEvent]:
        return [
            alike.CodedEvent(at, event.subject, event.kind, event.code)
            for at, event in events
            if event.code and event.subject in self._runs and self._recorded.holds(at)
        ]


@contextlib.contextmanager
def _running(made: rows.Rerun, robot: str) -> Iterator[Session]:
    """Run the robot during a `with`; raise BusError with its output if it does not start."""
    environment = os.environ | {"LBR_HOME": str(made.home)}
    command = [sys.executable, "-m", "lbr.start", "run", str(made.profile), "--db", str(made.home / "robot.db")]
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


def _up(process: "subprocess.Popen[bytes]", made: rows.Rerun, robot: str, output: Path) -> home.Running:
    rest = threading.Event()
    until = time.monotonic() + READY_S
    while time.monotonic() < until:
        if process.poll() is not None:
            raise BusError(f"the robot did not start: {output.read_text(errors='replace').strip()[-800:]}")
        for line in output.read_bytes().splitlines():
            if line.startswith(b"{"):
                report = read_or_none(line, dict[str, object]) or {}
                if not report.get("ready"):
                    raise BusError(f"the robot did not come up on the recorded bytes: {report.get('reason', report)}")
                return _record(made, robot)
        rest.wait(0.02)
    raise BusError(
        f"the robot did not come up within {READY_S:g} s: {output.read_text(errors='replace').strip()[-800:]}"
    )


def _record(made: rows.Rerun, robot: str) -> home.Running:
    """Return the run record of the robot in that home."""
    return msgspec.json.decode((made.home / "run" / f"{robot}.json").read_bytes(), type=home.Running)
