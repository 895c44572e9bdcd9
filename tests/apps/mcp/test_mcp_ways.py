"""However an agent's program goes, by a pipe or over HTTP and in either protocol, what it moved stands: on a whole robot."""

import json
import signal
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path

import httpx
import pytest

from tests.support import needs, programs
from tests.support import robot as robots
from tests.support.waiting import until

needs.modules("mcp")
pytestmark = pytest.mark.slow_start

AGENT = Path(robots.__file__).parent / "clients" / "agent.py"
SPIN = {"power": 0.15, "angle_deg": 90, "seconds": 5}
SILENT = "no sign of life"
ENDS = (SILENT, "called it off", "not renewed")


@pytest.fixture(scope="module")
def robot(tmp_path_factory):
    settings = json.dumps({"port": robots.free_port(), "ask": []})
    row = f"INSERT INTO capability (robot, name, kind, settings) VALUES ('lbr', 'agents', 'mcp', '{settings}')"
    home = robots.prepare(tmp_path_factory.mktemp("mcp"), edits=(row,))
    assert robots.lbr(home, "token", "add", "looker", "--role", "view", "--for", "web").returncode == 0
    with robots.running(home) as robot:
        yield robot


@pytest.fixture(scope="module")
def url(robot):
    return until(lambda: (robot.ask("agents/state") or {}).get("urls"))[0]


def turning(robot):
    state = robot.ask("motors/state") or {}
    return bool(state.get("left") or state.get("right"))


@contextmanager
def agent(robot, mode, where, tool="drive", arguments=SPIN):
    """Run an agent's program that calls a tool, once the base is ready for it."""
    argv = [sys.executable, AGENT, mode, tool, json.dumps(arguments), *where]
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
    robot.line("reset")
    robot.line("stop")
    until(lambda: not turning(robot))
    with programs.start(argv, env=robots.environment(robot.home), text=True, **pipes) as popen:
        try:
            assert popen.stdout.readline() == "calls\n"
            yield popen
        finally:
            popen.send_signal(signal.SIGCONT)
            popen.kill()


@pytest.mark.parametrize("mode", ["auto", "legacy"])
@pytest.mark.parametrize("way", ["pipe", "http"])
@pytest.mark.parametrize("end", ["killed", "frozen", "cancelled"])
def test_what_an_agent_moved_stands_when_it_is_gone(end, way, mode, robot, url):
    where = [*robots.LBR, "mcp"] if way == "pipe" else [url]
    with agent(robot, mode, where) as popen:
        until(lambda: turning(robot))
        if end == "cancelled":
            popen.stdin.write("\n")
            popen.stdin.flush()
        else:
            popen.send_signal(signal.SIGKILL if end == "killed" else signal.SIGSTOP)
        until(lambda: not turning(robot))
        reason = robot.ask("drive/state")["reason"]
        assert any(end in reason for end in ENDS), reason


@pytest.mark.parametrize("mode", ["auto", "legacy"])
def test_a_call_over_http_is_done(mode, robot, url):
    with agent(robot, mode, [url], arguments=SPIN | {"seconds": 0.8}) as popen:
        answer = json.loads(popen.stdout.readline())
    assert answer["code"] == "done", answer


def test_one_call_of_the_newest_protocol_ends_when_its_client_may_ask_no_more(robot, url):
    with agent(robot, "auto", [url]):
        until(lambda: turning(robot))
        until(lambda: not turning(robot))
        reason = robot.ask("drive/state")["reason"]
    assert "call again" in reason or SILENT in reason, reason


def test_strangers_and_wrong_tokens_are_refused(robot, url):
    body = {"jsonrpc": "2.0", "id": 1, "method": "tools/list"}
    accept = {"Accept": "application/json, text/event-stream"}
    for headers, status in (
        ({"Authorization": "Bearer looker.wrong.00"}, 401),
        ({"Origin": "http://evil.example"}, 403),
        ({"Host": "evil.example"}, 421),
    ):
        assert httpx.post(url, json=body, headers=accept | headers).status_code == status


def test_a_person_lets_an_agent_by_a_word(robot):
    assert robot.line("/agent/test-agent")["code"] == 0
    assert "test-agent" in until(lambda: (robot.ask("agents/state") or {}).get("allowed"))
