"""Whoever reaches the robot's socket without a password: what they may put, and what not."""

import json
import sys
import time
from collections.abc import Iterator
from subprocess import PIPE, Popen

import pytest

from lbr.bus import session, wire
from lbr.bus.access import TOOLS, Credentials
from tests.support.robot import Robot
from tests.support.waiting import until

STREAMS = ("drive/state", "motors/state", "ranges/readings")
WILDCARDS = ("*/*", "*/state", "drive/*", "dr$*/state", "**", "*/readings", "motors/sta$*")


@pytest.fixture
def stranger(robot: Robot) -> Iterator[session.Session]:
    with session.open_client(robot.endpoints) as bus:
        yield bus


@pytest.fixture
def inside(robot: Robot) -> Iterator[session.Session]:
    """A session behind the rights."""
    record = json.loads((robot.home / "run" / "lbr.json").read_text())
    with session.open_client([record["core"]], Credentials(user=TOOLS, password=record["password"])) as bus:
        yield bus


def test_no_wildcard_carries_a_forged_stream_past_the_rights(
    inside: session.Session, stranger: session.Session
) -> None:
    feeds = [wire.Subscription(inside, f"lbr/{key}", depth=256) for key in (*STREAMS, "drive/stop")]
    heard: list[bytes] = []

    def said(what: str) -> bool:
        stranger.put("lbr/drive/stop", json.dumps({"said": what}))
        heard.extend(raw.payload for feed in feeds for raw in feed.take())
        return any(what.encode() in payload for payload in heard)

    until(lambda: said("first"), what="what may be put arrives")
    for key in (*STREAMS, *WILDCARDS):
        stranger.put(f"lbr/{key}", json.dumps({"forged": key}))
    until(lambda: said("last"), what="what was put last")
    assert not [payload for payload in heard if b"forged" in payload]


def test_commands_can_be_put_without_a_password(inside: session.Session, stranger: session.Session) -> None:
    taken = wire.Subscription(inside, "lbr/drive/command", depth=8)
    until(lambda: stranger.put("lbr/drive/command", '{"power": 0}') or taken.take(), what="the command")


def test_a_press_in_the_executives_name_is_a_press(robot: Robot, stranger: session.Session) -> None:
    press = {"engaged": True, "reason": "in its name"}
    robot.put("@estop", {"engaged": True, "reason": "the first"})
    until(lambda: robot.status()["estop"]["acknowledged"], what="the first is acknowledged")
    until(lambda: robot.line("reset")["code"] == 0, what="the reset")
    wire.put(stranger, "lbr/@estop", press, source="executive", urgent=True)
    until(lambda: robot.status()["estop"]["reason"] == "in its name", what="it is latched")
    until(lambda: robot.line("reset")["code"] == 0, what="the second reset")


@pytest.mark.parametrize("key", ["lbr/**", "lbr/*/*"])
def test_a_client_that_asks_more_than_it_listens_to_holds_up_no_stop(
    robot: Robot, inside: session.Session, key: str
) -> None:
    """A client that asks more than it listens to holds up no stop"""
    command = [sys.executable, "-m", "tests.support.clients.asker", robot.endpoints[0], key]
    with Popen(command, stdout=PIPE) as asker:
        try:
            assert asker.stdout is not None
            assert asker.stdout.readline() == b"asking\n"
            end = time.monotonic() + 3.0
            while time.monotonic() < end:
                answers = wire.ask_all(inside, ["lbr/drive/stop"], b"{}", source="test", timeout_s=3.0)
                assert answers, "a stop was not answered"
        finally:
            asker.kill()
