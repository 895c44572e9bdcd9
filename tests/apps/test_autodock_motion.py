"""The base is moved under its lease: renewed, ended by its result, by a refusal, by silence."""

import time
from types import SimpleNamespace
from typing import Any

import pytest

from lbr.apps.autodock.motion import Motion
from lbr.apps.program import Robot
from lbr.bus import codec, session, wire
from lbr.messages.codes import Reason
from lbr.messages.drive import GoalResult
from lbr.messages.leases import CommandReply, refused

FIELDS = {"power": 0.2, "angle_deg": 180.0}


class FakeDrive:
    """The other end of the wire: notes what it is asked for and answers as told."""

    def __init__(self, place: str) -> None:
        self.router = session.open_router(session.Router(listen=(place,)))
        self.bus = session.open_client([place])
        self.asked: list[dict[str, Any]] = []
        self.answer = CommandReply(accepted=True, lease="abc", ttl_s=0.6, goal="goal-1")
        self.served = wire.QueryServer(self.router, "lbr/drive/command", lambda: None)

    def serve(self) -> None:
        for request in self.served.take():
            self.asked.append(codec.decode(request.payload))
            request.reply(self.answer, "drive")

    def close(self) -> None:
        self.bus.close()
        self.router.close()


@pytest.fixture
def drive(tmp_path):
    fake = FakeDrive(f"unixsock-stream/{tmp_path}/s.sock")
    yield fake
    fake.close()


@pytest.fixture
def clock():
    return SimpleNamespace(now=100.0)


@pytest.fixture
def motion(drive, clock) -> Motion:
    return Motion(Robot(drive.bus, "lbr", "autodock:1", 0.0), "command", FIELDS, clock.now)


def go_on(motion: Motion, drive: FakeDrive, clock: Any, until: Any, fields: dict[str, Any] = FIELDS) -> None:
    for _ in range(2000):
        drive.serve()
        motion.renew(fields, clock.now)
        clock.now += 0.002
        if until():
            return
        time.sleep(0.001)
    raise AssertionError(f"never: {motion.ending}, {drive.asked}")


def test_it_asks_once_without_a_lease_and_then_quotes_the_one_it_got(motion, drive, clock):
    go_on(motion, drive, clock, lambda: len(drive.asked) > 3, FIELDS | {"angle_deg": 170.0})
    assert drive.asked[0] == FIELDS | {"ttl_s": 0.8}
    assert all(each == {"power": 0.2, "angle_deg": 170.0, "lease": "abc", "ttl_s": 0.8} for each in drive.asked[1:])


@pytest.mark.parametrize(
    ("result", "code", "good", "final"),
    [
        ("reached", "done", True, False),
        ("stopped", "stopped", False, True),
        ("stopped", "obstacle", False, False),
        ("superseded", "taken_over", False, True),
        ("fault", "stuck", False, False),
    ],
)
def test_a_result_ends_it(motion, drive, clock, result, code, good, final):
    reason = "in any words"
    go_on(motion, drive, clock, lambda: len(drive.asked) > 1)
    said = GoalResult(goal="goal-1", result=result, reason=reason, code=code, range_cm=None, elapsed_s=1.0)
    motion.hear(GoalResult(goal="goal-0", result="fault", reason="another's", range_cm=None, elapsed_s=1.0))
    motion.hear(said)
    go_on(motion, drive, clock, lambda: motion.ending is not None)
    assert (motion.ending.good, motion.ending.final, motion.ending.text) == (good, final, reason)
    asked = len(drive.asked)
    motion.renew(FIELDS, clock.now)
    drive.serve()
    assert len(drive.asked) == asked


@pytest.mark.parametrize(
    ("code", "final"), [("held", True), ("estop", True), ("taken_over", True), ("not_armed", False), ("", False)]
)
def test_a_refusal_ends_it(motion, drive, clock, code, final):
    reason = "in any words"
    drive.answer = CommandReply(accepted=False, reason=reason, code=code)
    go_on(motion, drive, clock, lambda: motion.ending is not None)
    assert (motion.ending.good, motion.ending.final, motion.ending.text) == (False, final, reason)


def test_a_dead_lease_says_why_once_no_result_has_come(motion, drive, clock):
    go_on(motion, drive, clock, lambda: len(drive.asked) > 1)
    why = Reason("dead_lease", "lease is dead: stopped by console", cause="stopped", note="stopped by console")
    drive.answer = refused(why)

    def ended() -> bool:
        clock.now += 0.002
        return motion.ending is not None

    go_on(motion, drive, clock, ended)
    assert (motion.ending.text, motion.ending.final) == ("stopped by console", True)


def test_silence_ends_it(motion, drive, clock):
    for _ in range(40):
        clock.now += 0.1
        motion.renew(FIELDS, clock.now)
    assert motion.ending is not None
    assert ("does not answer" in motion.ending.text, motion.ending.final) == (True, True)
