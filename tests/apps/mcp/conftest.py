"""A whole robot that serves agents over HTTP: its owner as it is, and others by TLS and a token."""

import json
import signal
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path

import pytest

from tests.support import programs
from tests.support import robot as robots
from tests.support.door import add_token
from tests.support.waiting import until

AGENT = Path(robots.__file__).parent / "clients" / "agent.py"
SPIN = {"power": 0.15, "angle_deg": 90, "seconds": 5}
ROW = "INSERT INTO capability (robot, name, kind, settings) VALUES ('{robot}', '{name}', 'mcp', '{settings}')"


def row(robot, name, **settings):
    """Return the edit that adds a server for agents."""
    return ROW.format(robot=robot, name=name, settings=json.dumps({"port": robots.free_port(), **settings}))


@pytest.fixture(scope="module")
def robot(tmp_path_factory):
    edits = (row("lbr", "agents", ask=[]), row("lbr", "agents_tls", ask=[], tls=True))
    with robots.running(robots.prepare(tmp_path_factory.mktemp("mcp"), edits=edits)) as robot:
        yield robot


@pytest.fixture(scope="module")
def url(robot):
    return until(lambda: (robot.ask("agents/state") or {}).get("urls"))[0]


@pytest.fixture(scope="module")
def far(robot):
    return until(lambda: (robot.ask("agents_tls/state") or {}).get("urls"))[0]


@pytest.fixture(scope="module")
def tokens(robot):
    """Return a token for each role."""
    return {role: str(add_token(robot.home, role, role, good_for="web")) for role in ("view", "operate")}


def turning(robot):
    state = robot.ask("motors/state") or {}
    return bool(state.get("left") or state.get("right"))


@contextmanager
def agent(robot, mode, where, arguments=SPIN, **environment):
    """Run an agent's program that drives, once the base is ready for it."""
    argv = [sys.executable, AGENT, mode, "drive", json.dumps(arguments), *where]
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
    robot.line("reset")
    robot.line("stop")
    until(lambda: not turning(robot))
    with programs.start(argv, env=robots.environment(robot.home) | environment, text=True, **pipes) as popen:
        try:
            assert popen.stdout.readline() == "calls\n"
            yield popen
        finally:
            popen.send_signal(signal.SIGCONT)
            popen.kill()
