"""Who stops the robot stops docking, also before it begins and while it stands: nothing of it begins afterwards."""

import threading
import time

import pytest

from lbr.apps import program
from lbr.apps.autodock.__main__ import run
from lbr.apps.autodock.script import Manner
from lbr.apps.program import Robot
from lbr.bus import codec, session, stamp, wire
from lbr.messages.attitude import AttitudeState
from lbr.messages.drive import DriveState
from lbr.messages.leases import CommandReply
from tests.support.robot import until


class FakeRobot:
    """The other end of the wire: a drive that can be stopped and refuses to move, and an attitude."""

    def __init__(self, place):
        self.router = session.open_router(session.Router(listen=(place,)))
        self.bus = session.open_client([place])
        self.stopped_s, self.who = time.monotonic() - 100.0, "phone"
        self.asked, self.own_stops, self.ending = [], 0, None
        keys = ("turn", "command", "stop")
        self._served = {name: wire.QueryServer(self.router, f"lbr/drive/{name}", lambda: None) for name in keys}
        self._told_at = 0.0

    def dock(self, started_s):
        robot = Robot(self.bus, "lbr", "autodock:1", started_s)
        threading.Thread(target=lambda: setattr(self, "ending", run(robot, Manner(), 0.0)), daemon=True).start()

    def stop(self, who):
        self.stopped_s, self.who = time.monotonic(), who
        self._tell()

    def serve(self):
        for name, served in self._served.items():
            for request in served.take():
                if name == "stop":
                    self.own_stops += 1
                    self.stopped_s = stamp.sent_s(stamp.read(request.attachment), time.monotonic())
                    self.who = "autodock:1"
                    self._tell()
                    request.reply(CommandReply(accepted=True), "drive")
                else:
                    self.asked.append(codec.decode(request.payload))
                    request.reply(CommandReply(accepted=False, reason="something is in the way"), "drive")
        if time.monotonic() - self._told_at > 0.05:
            self._tell()

    def _tell(self):
        self._told_at = time.monotonic()
        state = DriveState(
            moving=False, power=0.0, angle_deg=0.0, left=0.0, right=0.0, holder=None, goal=None, limited_by="",
            reason=f"stopped by {self.who}", code="stopped", stopped_by=self.who, estop=False, loop=None,
            stopped_s=self.stopped_s,
        )  # fmt: skip
        wire.put(self.router, "lbr/drive/state", state, source="drive")
        lies = AttitudeState(valid=True, turned_deg=90.0, epoch="1", measured_s=self._told_at)
        wire.put(self.router, "lbr/attitude/state", lies, source="attitude")

    def until(self, look):
        until(lambda: self.serve() or look(), limit_s=8.0)

    def close(self):
        self.bus.close()
        self.router.close()


@pytest.fixture
def robot(tmp_path):
    fake = FakeRobot(f"unixsock-stream/{tmp_path}/s.sock")
    yield fake
    fake.stop("the end of the test")
    fake.until(lambda: fake.ending)
    fake.close()


def test_a_stop_while_it_starts_is_the_end_of_it(robot):
    started_s = time.monotonic()
    robot.stop("console")
    robot.dock(started_s)
    robot.until(lambda: robot.ending)
    assert (robot.ending.good, robot.ending.text) == (False, "stopped by console")
    assert robot.asked == []


def test_a_stop_while_it_stands_is_the_end_of_it_and_older_ones_and_its_own_are_not(robot):
    robot.dock(time.monotonic())
    robot.until(lambda: len(robot.asked) >= 2 and robot.own_stops)
    assert robot.ending is None
    robot.stop("console")
    before = len(robot.asked)
    robot.until(lambda: robot.ending)
    assert robot.ending.text == "stopped by console"
    assert len(robot.asked) <= before + 1, "what was on its way to the drive alone, which refuses it as older"


@pytest.mark.parametrize(("said", "believed"), [("1.5", True), ("1e300", False), ("nan", False), ("soon", False)])
def test_when_it_was_asked_for_is_believed_if_it_makes_sense(monkeypatch, said, believed):
    monkeypatch.setenv("LBR_STARTED_S", said)
    before = time.monotonic()
    found = program._started_s()
    assert (found == 1.5) if believed else before <= found <= time.monotonic()
