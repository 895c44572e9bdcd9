"""However an agent's program goes, by a pipe or over HTTP and in either protocol, what it moved stands: on a whole robot."""

import json
import signal
import sys

import certifi
import httpx
import pytest

from lbr.database import store
from tests.apps.mcp.conftest import AGENT, SPIN, agent, turning
from tests.support import needs, programs
from tests.support import robot as robots
from tests.support.door import add_token
from tests.support.waiting import until

needs.modules("mcp")
pytestmark = pytest.mark.slow_start

SILENT = "no sign of life"
ENDS = (SILENT, "called it off", "not renewed")


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


@pytest.mark.parametrize("mode", ["auto", "legacy"])
def test_elsewhere_a_token_may_what_its_role_may_and_the_pinned_certificate_is_trusted(mode, robot, far, tokens):
    pinned = {"LBR_CA": str(robot.home / "credentials" / "bus.crt")}
    for role, code in (("operate", "done"), ("view", "role")):
        spin = SPIN | {"seconds": 0.2}
        with agent(robot, mode, [far], arguments=spin, LBR_TOKEN=tokens[role], **pinned) as popen:
            assert json.loads(popen.stdout.readline())["code"] == code


@pytest.mark.parametrize("mode", ["auto", "legacy"])
@pytest.mark.parametrize("wrong", ["token", "certificate"])
def test_a_wrong_token_and_another_certificate_come_to_nothing(wrong, mode, robot, far, tokens):
    token = tokens["operate"].replace(".", ".0", 1) if wrong == "token" else tokens["operate"]
    authority = robot.home / "credentials" / "bus.crt" if wrong == "token" else certifi.where()
    done = programs.run(
        [sys.executable, AGENT, mode, "status", "{}", far],
        env=robots.environment(robot.home) | {"LBR_TOKEN": token, "LBR_CA": str(authority)},
        input="",
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 1
    assert {"token": "an error response", "certificate": "CERTIFICATE_VERIFY_FAILED"}[wrong] in done.stderr


def test_strangers_and_wrong_tokens_are_refused(robot, url):
    body = {"jsonrpc": "2.0", "id": 1, "method": "tools/list"}
    accept = {"Accept": "application/json, text/event-stream"}
    for headers, status in (
        ({"Authorization": "Bearer looker.wrong.00"}, 401),
        ({"Origin": "http://evil.example"}, 403),
        ({"Host": "evil.example"}, 421),
    ):
        assert httpx.post(url, json=body, headers=accept | headers).status_code == status


def test_a_token_is_good_when_it_is_added_and_no_more_when_it_is_revoked_and_the_server_runs_on(robot, url):
    body = {"jsonrpc": "2.0", "id": 1, "method": "tools/list"}
    before = robot.capability("agents")["pid"]
    token = add_token(robot.home, "later", "view", good_for="web")
    headers = {"Accept": "application/json, text/event-stream", "Authorization": f"Bearer {token}"}

    def refused():
        return httpx.post(url, json=body, headers=headers).status_code == 401

    until(lambda: not refused(), what="the token")
    with store.Database.open(robot.home / "robot.db") as database:
        database.revoke_token("later")
    until(refused, what="its end")
    assert robot.capability("agents")["pid"] == before


def test_a_person_lets_an_agent_by_a_word(robot):
    assert robot.line("/agent/test-agent")["code"] == 0
    assert "test-agent" in until(lambda: (robot.ask("agents/state") or {}).get("allowed"))
