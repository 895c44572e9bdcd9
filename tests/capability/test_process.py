"""A capability in a process of its own, on a real bus: its ports, its phases, and every way out."""

import ctypes
import json
import os
import signal
import textwrap
import time
from contextlib import closing, contextmanager
from pathlib import Path
from unittest import mock

import msgspec
import psutil
import pytest

from lbr.bus import keys, session, stamp, wire
from lbr.capability.config import InputWire, OutputWire, ProcessConfig
from lbr.executive.planning.process_specs import ProcessSpec
from lbr.executive.processes.fork_server import ForkServer
from lbr.executive.processes.process_host import ProcessHost
from lbr.executive.processes.reaper import Reaper
from lbr.executive.processes.restart import UNSEEN, ended_by
from lbr.messages.system import EstopState
from tests.support import needs
from tests.support.waiting import until

PROBE = """
    import sys
    import time
    from pathlib import Path
    from msgspec import Struct
    from lbr.capability import Capability, Kind
    from lbr.errors import DeviceError
    from lbr.messages.codes import Reason
    from lbr.messages.leases import CommandReply
    from lbr.messages.motors import MotorSetpoint


    class Settings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
        device_there: str = ""
        steps_first: int = 0
        answers_at: str = ""
        lacks_until: int = 0


    class Count(Struct, frozen=True):
        n: int


    class Do(Struct, frozen=True):
        what: str


    class Probe(Capability):
        rate_hz = 100.0

        def open(self):
            if self.ctx.settings.device_there and not __import__("os").path.exists(self.ctx.settings.device_there):
                raise DeviceError("device 'x' is missing; plug it in")
            self.n = 0
            self.heard = []
            self.steps = 0
            with Path(self.ctx.home, "opened").open("a") as opened:
                opened.write("!")

        def step(self):
            self.steps += 1
            if self.steps == 1 and self.ctx.settings.steps_first:
                self.ctx.warn("has not stepped enough", "not_ready")
            elif self.steps == self.ctx.settings.steps_first:
                self.ctx.ready()
            for received in self.ctx.take("setpoint"):
                self.n += round(received.message.left * 10)
            self.ctx.publish("count", Count(self.n))
            if self.ctx.estop.engaged:
                self.ctx.estop.acknowledge(stopped=True)

            if self.steps == 3 and not self.answers():
                raise DeviceError("device 'x' is silent")

        def answers(self):
            return not self.ctx.settings.answers_at or Path(self.ctx.settings.answers_at).exists()

        def lacks(self):
            return Reason("not_armed", "not armed") if self.steps < self.ctx.settings.lacks_until else None

        def command(self, call):
            call.reply(CommandReply(accepted=True, reason=" ".join((*self.heard, call.message.what))))
            self.heard.append(call.message.what)
            {"raise": self.boom, "wait": self.wait, "exit": lambda: sys.exit(0), "hang": self.hang,
             "raise twice": self.boom_twice, "clutch": self.clutch}.get(call.message.what, lambda: None)()

        def boom(self):
            raise ValueError("out of cheese")

        def boom_twice(self):
            self.close = self.boom
            raise ValueError("first cause")

        def wait(self):
            while not Path(self.ctx.home, "go on").exists():
                time.sleep(0.001)

        def clutch(self):
            library = __import__("ctypes").PyDLL(None)
            Path(self.ctx.home, "held").touch()
            library.sleep(60)

        def hang(self):
            while True:
                pass


    KIND = Kind(name="probe", summary="", family="app", entry=Probe, settings=Settings, moves=True,
                setpoints={"setpoint": MotorSetpoint}, outputs={"count": Count}, commands={"do": Do, "stop": Do})
"""
KEY = "5e" * 32
NOT_ENGAGED = EstopState(engaged=False, reason="")


class Stage:
    def __init__(self, home: Path, forks: ForkServer | None = None) -> None:
        self.home = home
        self.log = home / "r-probe.log"
        self.forks = forks
        (home / "capabilities").mkdir(mode=0o700)
        (home / "capabilities" / "probe.py").write_text(textwrap.dedent(PROBE))
        endpoint = f"unixsock-stream/{home}/bus.sock"
        self.router = session.open_router(session.Router(listen=(endpoint,)))
        self.bus = session.open_client([endpoint])
        self.endpoint = endpoint
        self.said = []
        self.child = None
        self.reaper = Reaper()

    def start(self, *, settings="{}", estop=NOT_ENGAGED):
        feed = InputWire(key="r/probe/setpoint", source="drive", seal=KEY, history=8)
        config = ProcessConfig(
            robot="r",
            name="probe",
            kind="probe",
            settings=msgspec.Raw(settings.encode()),
            endpoints=(self.endpoint,),
            home=str(self.home),
            wiring={"setpoint": (feed,)},
            outputs={"count": (OutputWire(key="r/probe/count"),)},
            estop=estop,
            release_key=KEY,
        )
        unit = ProcessSpec(
            name="probe", kind="probe", family="app", moves=True, restart="never", needs=(), config=config
        )
        self.host = ProcessHost(self.home, self.reaper, self.forks)
        self.child = self.host.start(unit, config)
        return self

    def reports(self):
        self.host.poll()
        return self.child.reports()

    def heard(self, phase):
        self.said += [report for report in self.reports() if report.phase]
        return [report for report in self.said if report.phase == phase]

    def ready(self):
        until(lambda: self.heard("ready"), what=f"ready; log: {self.log.read_text()}")
        until(lambda: self.ask("r/probe/count"), what="the process on the bus")
        return self

    def ask(self, key, message=None):
        answers = wire.ask(self.bus, key, message, source="test")
        return json.loads(answers[0].payload) if answers else None

    def ended(self):
        def code():
            self.heard("")
            return self.child.returncode()

        until(lambda: code() is not None, what="end of the process")
        return code()

    def hang_up(self):
        """Close the lifeline, as the kernel does when the executive dies."""
        self.child._process._running.stdin.close()

    def close(self):
        if self.child is not None:
            self.child.kill()
            self.ended()
            self.child.close()
        self.reaper.close()
        self.bus.close()
        self.router.close()


@contextmanager
def forking(home):
    with (
        mock.patch.dict(os.environ, LBR_HOME=str(home)),
        closing(Reaper()) as reaper,
        closing(ForkServer(reaper, "test")) as made,
    ):
        until(lambda: not made.begins, what="the fork server")
        yield made


@pytest.fixture(scope="module")
def forks(tmp_path_factory):
    with forking(tmp_path_factory.mktemp("f")) as made:
        yield made


@pytest.fixture
def own_forks(tmp_path):
    with forking(tmp_path) as made:
        yield made


@pytest.fixture
def stage(tmp_path_factory, forks):
    made = Stage(tmp_path_factory.mktemp("p"), forks)
    yield made
    made.close()


@pytest.fixture
def fresh(tmp_path_factory):
    made = Stage(tmp_path_factory.mktemp("p"))
    yield made
    made.close()


def process_of(stage) -> psutil.Process:
    return psutil.Process(stage.child.pid)


def test_a_process_starts_in_an_interpreter_of_its_own_where_there_is_no_fork_server(fresh):
    fresh.start().ready()
    assert process_of(fresh).ppid() == os.getpid()
    fresh.ask("r/probe/do", {"what": "raise"})
    assert fresh.ended() == 70


@needs.LOOKING_INSIDE
def test_a_forked_process_is_seen_by_its_own_words_and_mark(stage):
    stage.start().ready()
    found = process_of(stage)
    assert found.ppid() != os.getpid()
    words = found.cmdline()
    own = words.index("-m") + 1
    assert words[own : own + 3] == ["lbr.capability.process", "r/probe", str(stage.home)]
    assert found.environ()["LBR_RUN"].startswith(f"{stage.reaper.token}.")
    assert os.getsid(found.pid) == found.pid
    assert Path(f"/proc/{found.pid}/fd/1").resolve() == stage.log


def test_a_forked_process_outlives_its_fork_server_and_another_takes_its_place(stage, own_forks):
    stage.forks = own_forks
    stage.start().ready()
    os.kill(process_of(stage).ppid(), signal.SIGKILL)
    assert stage.ask("r/probe/count") == {"n": 0}
    stage.child.kill()
    code = stage.ended()
    assert code in {-signal.SIGKILL, UNSEEN}
    assert "exit code" not in ended_by(code, program=False)
    until(lambda: not own_forks.begins and own_forks.serves, what="another fork server")


def test_a_fork_server_that_is_frozen_holds_up_a_start_for_a_moment_only(stage, own_forks):
    server = psutil.Process(own_forks.pid)
    server.suspend()
    assert own_forks.fork(("r/probe", str(stage.home)), {}, 2, 2) is None
    assert not server.is_running()
    stage.forks = own_forks
    stage.start().ready()
    assert process_of(stage).ppid() == os.getpid()


def test_streams_answer_a_get_with_their_latest_value_and_are_stamped(stage):
    stage.start().ready()
    until(lambda: stage.ask("r/probe/count") == {"n": 0})
    raw = wire.ask(stage.bus, "r/probe/count", None, source="test")[0]
    said = stamp.read(raw.attachment)
    assert said is not None
    assert said.source == "probe"
    assert said.seq > 0
    assert abs(said.mono_ns - time.monotonic_ns()) < 5e9


def test_commands_are_answered_and_malformed_ones_refused_in_one_line(stage):
    stage.start().ready()
    assert stage.ask("r/probe/do", {"what": "nothing"}) == {"accepted": True, "reason": "nothing"}
    for payload in (b"{", b"\xff\xfe", b'{"what": 3}', b"[]", b'{"what": NaN}', b"[" * 5000):
        reply = json.loads(next(iter(stage.bus.get("r/probe/do", payload=payload))).ok.payload.to_bytes())
        assert reply["accepted"] is False
        assert "\n" not in reply["reason"]
    huge = json.dumps({"what": "x" * 70_000}).encode()
    reply = json.loads(next(iter(stage.bus.get("r/probe/do", payload=huge))).ok.payload.to_bytes())
    assert "65536 bytes" in reply["reason"]


def test_a_stop_is_heard_before_the_commands_that_still_wait(stage):
    stage.start().ready()
    for what in ("wait", "a", "b"):
        wire.put(stage.bus, "r/probe/do", {"what": what}, source="test")
    wire.put(stage.bus, "r/probe/stop", {"what": "stop"}, source="test")
    stage.ask("r/probe/count")  # answered by another thread: all of it has come in
    (stage.home / "go on").touch()
    heard = stage.ask("r/probe/do", {"what": "c"})["reason"]
    assert heard.split().index("stop") < heard.split().index("a")
    assert heard.replace("stop ", "") == "wait a b c"


def test_a_wildcard_get_executes_no_command(stage):
    stage.start().ready()
    until(lambda: stage.ask("r/probe/count"))
    found = [raw.key for raw in wire.ask(stage.bus, "r/*/*", {"what": "raise"}, source="test")]
    assert found == ["r/probe/count"]
    assert stage.child.returncode() is None


def test_only_the_wired_source_can_write_a_setpoint_and_only_once(stage):
    stage.start().ready()
    sealed = wire.Publisher(stage.bus, "r/probe/setpoint", "drive", seal=bytes.fromhex(KEY))
    heard = wire.Subscription(stage.bus, "r/probe/setpoint", depth=8)
    sealed.put({"left": 0.1, "right": 0.0})
    until(lambda: stage.ask("r/probe/count") == {"n": 1})
    (genuine,) = heard.take()
    stage.bus.put("r/probe/setpoint", genuine.payload, attachment=genuine.attachment)
    wire.put(stage.bus, "r/probe/setpoint", {"left": 0.5, "right": 0.5}, source="drive")
    stage.bus.put("r/probe/setpoint", b'{"left":0.7,"right":0.7}', attachment=genuine.attachment)
    sealed.put({"left": 0.2, "right": 0.0})
    until(lambda: stage.ask("r/probe/count") == {"n": 3})


def test_the_schema_of_every_port_can_be_asked_for(stage):
    stage.start().ready()
    schema = until(lambda: stage.ask(keys.schema("r", "probe", "setpoint")))
    assert "forward positive" in schema["$defs"]["MotorSetpoint"]["properties"]["left"]["description"]


def test_a_missing_device_makes_it_degraded_and_its_return_ready(stage):
    device = stage.home / "device"
    stage.start(settings=json.dumps({"device_there": str(device)}))
    until(lambda: stage.heard("degraded"))
    assert "missing; plug it in" in stage.heard("degraded")[0].reason
    answer = until(lambda: stage.ask("r/probe/do", {"what": "nothing"}), "its commands are known on the bus")
    assert "missing" in answer["reason"]
    device.touch()
    stage.ready()


def test_a_device_that_is_opened_again_and_again_and_says_nothing_is_told_once_and_never_called_ready(stage):
    device = stage.home / "device"
    stage.start(settings=json.dumps({"answers_at": str(device)}))
    until(lambda: stage.heard("degraded"))
    until(lambda: len((stage.home / "opened").read_text()) > 2)
    device.touch()
    stage.ready()
    assert [report.phase for report in stage.said if report.phase in {"ready", "degraded"}] == ["degraded", "ready"]


def test_who_has_just_begun_and_says_what_it_waits_for_is_not_called_ready_before(stage):
    stage.start(settings=json.dumps({"steps_first": 5})).ready()
    assert [report.phase for report in stage.said if report.phase in {"ready", "degraded"}] == ["degraded", "ready"]


def test_who_would_refuse_its_first_command_is_called_ready_when_it_would_not(stage):
    stage.start(settings=json.dumps({"lacks_until": 5})).ready()
    told = [(report.phase, report.code) for report in stage.said if report.phase in {"ready", "degraded"}]
    assert told == [("degraded", "not_armed"), ("ready", "")]


def test_the_emergency_stop_latches_is_acknowledged_and_only_a_sealed_release_lets_go(stage):
    stage.start().ready()
    heard = wire.Subscription(stage.bus, keys.estop_acknowledgement("r", "*"), depth=8)
    wire.put(stage.bus, keys.estop("r"), {"engaged": True, "reason": "test"}, source="test")
    said = until(heard.take)
    assert json.loads(said[0].payload) == {
        "capability": "probe",
        "engaged": True,
        "stopped": True,
        "reason": "",
        "within_s": 0.5,
    }
    wire.put(stage.bus, keys.estop("r"), {"engaged": False}, source="test")
    release = keys.estop_release("r", "probe")
    assert stage.ask(release, {})["code"] == "denied"
    sealed = stamp.make("executive", 0, b"{}", bytes.fromhex(KEY))
    answers = wire.ask(stage.bus, release, {}, source="executive", attachment=sealed)
    assert json.loads(answers[0].payload)["accepted"] is True


def test_a_stop_that_cannot_be_read_stops_all_the_same(stage):
    stage.start().ready()
    heard = wire.Subscription(stage.bus, keys.estop_acknowledgement("r", "*"), depth=8)
    stage.bus.put(keys.estop("r"), b"\xffSTOP")
    assert json.loads(until(heard.take)[0].payload)["stopped"] is True


def test_it_ends_in_order_when_asked_and_says_so(stage):
    stage.start().ready()
    stage.child.terminate()
    assert stage.ended() == 0
    assert stage.heard("stopping")


def test_it_ends_when_its_executive_is_gone(stage):
    stage.start().ready()
    stage.hang_up()
    assert stage.ended() == 0


def test_it_goes_on_and_ends_in_order_when_it_was_frozen_and_its_executive_is_gone(stage):
    stage.start().ready()
    os.killpg(stage.child.pid, signal.SIGSTOP)
    stage.hang_up()
    assert stage.ended() == 0


def test_a_frozen_process_that_is_asked_to_end_ends_in_order(stage):
    stage.start().ready()
    os.killpg(stage.child.pid, signal.SIGSTOP)
    stage.child.terminate()
    assert stage.ended() == 0


def test_a_signal_ends_a_process_whichever_thread_receives_it(stage):
    stage.start().ready()
    other = next(thread.id for thread in process_of(stage).threads() if thread.id != stage.child.pid)
    assert ctypes.CDLL(None).tgkill(stage.child.pid, other, signal.SIGTERM) == 0
    assert stage.ended() == 0


def test_one_that_holds_the_interpreter_is_killed_when_its_executive_is_gone(stage):
    stage.start().ready()
    stage.ask("r/probe/do", {"what": "clutch"})
    until((stage.home / "held").exists, what="the interpreter held")
    stage.hang_up()
    stage.reaper.close()
    # By its guardian, or by its own alarm where it noticed the end just before it held the interpreter.
    assert stage.ended() in {-signal.SIGKILL, -signal.SIGALRM}


@pytest.mark.parametrize(
    ("what", "reason"),
    [
        ("raise", "ValueError: out of cheese"),
        ("exit", "SystemExit: 0"),
    ],
)
def test_whatever_is_raised_ends_the_process_and_is_reported(stage, what, reason):
    stage.start().ready()
    stage.ask("r/probe/do", {"what": what})
    assert stage.ended() == 70
    assert reason in stage.heard("failed")[0].reason


def test_what_was_raised_is_in_the_log_where_the_close_after_it_raises_too(stage):
    stage.start().ready()
    stage.ask("r/probe/do", {"what": "raise twice"})
    assert stage.ended() == 70
    assert "ValueError: first cause" in stage.log.read_text()


def test_a_hang_is_silence_on_the_heartbeat(stage):
    stage.start().ready()
    stage.ask("r/probe/do", {"what": "hang"})
    stage.reports()
    quiet_from = time.monotonic()
    until(lambda: time.monotonic() - quiet_from > 0.6)
    assert stage.reports() == []
    assert stage.child.returncode() is None


def test_a_capability_file_that_others_may_change_is_refused(stage):
    (stage.home / "capabilities" / "probe.py").chmod(0o666)
    stage.start()
    assert stage.ended() == 70
    assert "could be changed" in stage.heard("failed")[0].reason


def test_a_refused_put_and_a_refused_query_become_events(stage):
    stage.start().ready()
    heard = wire.Subscription(stage.bus, keys.event("r"), depth=16)
    stage.bus.put("r/probe/do", b"{")
    said = until(heard.take)
    assert json.loads(said[0].payload)["kind"] == "refused"
