"""The word `autodock`: has the table run, tells each state and how it ended; a stop before it begins is the end of it."""

import threading
import time

import pytest

from lbr.apps import program
from lbr.apps.autodock.__main__ import run
from lbr.apps.program import Robot
from lbr.bus import codec, session, wire
from lbr.errors import LbrError
from lbr.messages.behaviour import BehaviourState
from lbr.messages.leases import CommandReply
from tests.support.replies import drive_state
from tests.support.waiting import until


class FakeRobot:
    """The other end of the wire: a drive that can be stopped, and behaviours that run what they are told."""

    def __init__(self, place):
        self.router = session.open_router(session.Router(listen=(place,)))
        self.bus = session.open_client([place])
        self.stopped_s = time.monotonic() - 100.0
        self.state = BehaviourState(phase="resting")
        self.answer = CommandReply(accepted=True, reason="runs dock from 'Looking'")
        self.asked, self.ended = [], None
        served = {
            name: wire.QueryServer(self.router, f"lbr/behaviour/{name}", lambda: None) for name in ("run", "stop")
        }
        self._served = served
        self._told_at = 0.0

    def dock(self, started_s):
        robot = Robot(self.bus, "lbr", "autodock:1", started_s)

        def work():
            try:
                self.ended = run(robot, "dock")
            except LbrError as err:
                self.ended = False, str(err)

        threading.Thread(target=work, daemon=True).start()

    def serve(self):
        for name, served in self._served.items():
            for request in served.take():
                self.asked.append((name, codec.decode(request.payload).get("name", "")))
                request.reply(self.answer, "behaviour")
        if time.monotonic() - self._told_at > 0.05:
            self._told_at = time.monotonic()
            drive = drive_state(stopped_s=self.stopped_s, stopped_by="console")
            wire.put(self.router, "lbr/drive/state", drive, source="drive")
            wire.put(self.router, "lbr/behaviour/state", self.state, source="behaviour")

    def until(self, look):
        until(lambda: self.serve() or look())

    def close(self):
        self.bus.close()
        self.router.close()


@pytest.fixture
def robot(tmp_path):
    fake = FakeRobot(f"unixsock-stream/{tmp_path}/s.sock")
    yield fake
    fake.until(lambda: fake.ended)
    fake.close()


def test_a_stop_while_it_starts_is_the_end_of_it(robot):
    robot.stopped_s = time.monotonic()
    robot.dock(robot.stopped_s - 0.1)
    robot.until(lambda: robot.ended)
    assert robot.ended == (False, "stopped by console")
    assert robot.asked == []


@pytest.mark.parametrize("good", [True, False])
def test_it_tells_each_state_and_how_the_table_ended(robot, capsys, good):
    robot.state = BehaviourState(phase="ended", table="dock", state="Docked", good=not good, reason="of another time")
    robot.dock(time.monotonic())
    robot.until(lambda: robot.asked)
    assert robot.asked == [("run", "dock")]
    robot.state = BehaviourState(phase="running", table="dock", state="Searching")
    robot.until(lambda: "Searching" in capsys.readouterr().out)
    robot.state = BehaviourState(phase="ended", table="dock", state="Docked", good=good, reason="ended in 'Docked'")
    robot.until(lambda: robot.ended)
    assert robot.ended == (good, "ended in 'Docked'")


def test_what_refuses_it_is_told(robot):
    robot.answer = CommandReply(accepted=False, reason="'patrol' runs", code="busy")
    robot.dock(time.monotonic())
    robot.until(lambda: robot.ended)
    assert robot.ended == (False, "'patrol' runs")


@pytest.mark.parametrize(("said", "believed"), [("1.5", True), ("1e300", False), ("nan", False), ("soon", False)])
def test_when_it_was_asked_for_is_believed_if_it_makes_sense(monkeypatch, said, believed):
    monkeypatch.setenv("LBR_STARTED_S", said)
    before = time.monotonic()
    found = program._told_s("LBR_STARTED_S")
    assert (found == 1.5) if believed else before <= found <= time.monotonic()
