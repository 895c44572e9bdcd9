"""`docksignal`: what may be said, and that the robot hears it."""

import subprocess
import sys

import pytest

from lbr import home
from lbr.apps.docksignal.__main__ import signal
from lbr.bus import codec, session, wire
from lbr.errors import InputError
from lbr.messages.dock import DockHeard
from lbr.messages.leases import CommandReply
from tests.support import programs
from tests.support.robot import environment
from tests.support.waiting import HANG_S


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["left"], DockHeard(left=True)),
        (["right_signal"], DockHeard(right=True)),
        (["left", "power"], DockHeard(left=True, power=True)),
    ],
)
def test_beams_are_named(words, expected):
    assert signal(words) == expected


@pytest.mark.parametrize("words", [[], ["front"], ["left", ""]])
def test_anything_else_is_refused_with_what_is_allowed(words):
    with pytest.raises(InputError, match="left, right or power"):
        signal(words)


def program(place, *words: str) -> "subprocess.Popen[str]":
    return programs.start(
        [sys.executable, "-m", "lbr.apps.docksignal", *words],
        env=environment(place),
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )


def test_without_a_robot_it_says_so(tmp_path):
    ended = program(tmp_path, "left")
    assert "no robot runs here" in ended.communicate(timeout=HANG_S)[0]
    assert ended.returncode == 1


def test_the_robot_of_this_home_hears_it(tmp_path, monkeypatch):
    monkeypatch.setenv("LBR_HOME", str(tmp_path))
    endpoint = f"unixsock-stream/{tmp_path}/s.sock"
    lock = home.RunLock("lbr")
    lock.publish(
        home.Running(robot="lbr", pid=1, endpoints=(endpoint,), profile="", database="", core=endpoint, password="")
    )
    router = session.open_router(session.Router(listen=(endpoint,)))
    said = []

    def answer() -> None:
        for request in served.take():
            said.append(codec.decode(request.payload))
            request.reply(CommandReply(accepted=True), "dock")

    served = wire.QueryServer(router, "lbr/dock/heard", answer)
    ended = program(tmp_path, "left")
    assert ended.communicate(timeout=HANG_S)[0].endswith(" left\n")
    router.close()
    lock.release()
    assert ended.returncode == 0
    assert said == [{"left": True, "right": False, "power": False}]
