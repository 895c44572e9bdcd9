"""`lbr topic` on a small robot that describes one stream and one command, while a stranger publishes."""

import json
import threading

import pytest

from lbr import cli
from lbr.bus import keys, wire
from lbr.console import topics
from lbr.messages.system import CapabilityStatus, EstopState, Status
from tests.console.fake_robot import ROBOT

UNIT = CapabilityStatus(
    name="drive", kind="drive", phase="ready", pid=1, restarts=0, uptime_s=1.0, reason="", rates_hz={"state": 50.0}
)
STATUS = Status(
    robot=ROBOT, profile="t", ready=True, pid=1, uptime_s=1.0, capabilities=(UNIT,),
    estop=EstopState(engaged=False, reason=""),
)  # fmt: skip


@pytest.fixture
def described(robot):
    """The robot's words about itself, and a stream of a program that has none."""
    schema = {"title": "DriveState", "type": "object", "properties": {}}
    command = {"title": "DriveCommand", "x-role": "operate"}
    served = [
        wire.StaticReply(robot.bus, keys.schema(ROBOT, "drive", "state"), lambda: schema),
        wire.StaticReply(robot.bus, keys.schema(ROBOT, "drive", "command"), lambda: command),
        wire.StaticReply(robot.bus, keys.status(ROBOT), lambda: STATUS),
        wire.StaticReply(robot.bus, f"{ROBOT}/drive/state", dict),
    ]
    over = threading.Event()

    def beacon() -> None:
        while not over.wait(0.05):
            wire.put(robot.bus, f"{ROBOT}/beacon/nearest", {"nearest_m": 1.0}, source="beacon")

    thread = threading.Thread(target=beacon, daemon=True)
    thread.start()
    yield robot
    over.set()
    thread.join(5)
    served.clear()


@pytest.fixture
def lbr(described, capsys):
    def run(*arguments: str) -> tuple[int, str, str]:
        code = cli.main([*arguments, "--connect", described.endpoint, "--robot", ROBOT])
        return code, *capsys.readouterr()

    return run


def test_the_list_has_what_is_heard_without_a_schema(lbr):
    code, out, _ = lbr("topic", "list", "--json")
    found = {topic["name"]: topic for topic in json.loads(out)}
    assert code == 0
    assert set(found) == {"drive/state", "drive/command", "beacon/nearest"}
    assert found["beacon/nearest"]["message"] == topics.UNDESCRIBED
    assert found["drive/command"]["role"] == "command"


@pytest.mark.parametrize(
    ("name", "said"),
    [("@estop", "engaged"), ("@status", "capabilities"), ("@event", "subject"), ("beacon/nearest", "no schema")],
)
def test_what_no_capability_describes_is_explained(lbr, name, said):
    code, out, _ = lbr("topic", "info", name)
    assert code == 0
    assert out.startswith(f"{ROBOT}/{name}  (stream of ")
    assert said in out


def test_a_topic_that_is_not_there_is_told_with_those_that_may_be_meant(lbr):
    code, _, err = lbr("topic", "info", "drive/comand")
    assert code != 0
    assert "there is no 'drive/comand'; did you mean drive/command" in err
    assert "@estop" not in err


@pytest.mark.parametrize(
    "name",
    [
        "drive/command",
        "drive/stop",
        "nothing",
    ],
)
def test_echo_once_asks_no_command_and_says_why_nothing_came(described, lbr, monkeypatch, name, wording):
    monkeypatch.setattr("lbr.commands.topic.WAIT_S", 0.2)
    code, out, err = lbr("topic", "echo", name, "--once")
    assert (code, out) == (1, "")
    wording(err)
    assert described.renewed == described.stopped == []


def test_echo_says_after_a_while_that_nothing_came_and_goes_on(described, client, capsys, monkeypatch):
    monkeypatch.setattr("lbr.commands.topic.SILENT_S", 0.2)
    seen = []

    def print_one(message, **_options) -> None:
        seen.append(message.key)
        raise KeyboardInterrupt

    monkeypatch.setattr("lbr.commands.topic.print_message", print_one)
    later = threading.Timer(2.0, lambda: wire.put(client, f"{ROBOT}/late/word", {}, source="late"))
    later.start()
    code = cli.main(["topic", "echo", "late/word", "--connect", described.endpoint, "--robot", ROBOT])
    later.join()
    assert code == cli.INTERRUPTED
    assert seen == [f"{ROBOT}/late/word"]
    assert "nothing has come on rob/late/word within 0.2 s, and there is no 'late/word'" in capsys.readouterr().err
