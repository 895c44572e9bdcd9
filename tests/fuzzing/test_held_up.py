"""An executive that was held up, with all the routers in it, is answered for at every door afterwards."""

import json
import os
import signal
import time

from lbr.bus import keys, session, wire
from tests.support.robot import Robot
from tests.support.waiting import until

HELD_UP_S = 0.6
TIMES = 5


def test_a_robot_that_was_held_up_answers_again_at_its_local_door(robot: Robot):
    for _ in range(TIMES):
        os.kill(robot.ready["pid"], signal.SIGSTOP)
        time.sleep(HELD_UP_S)
        os.kill(robot.ready["pid"], signal.SIGCONT)
        with session.open_client(robot.endpoints) as newcomer:
            for key in ("@status", "drive/stop"):
                asked = f"{robot.name}/{key}"
                until(lambda bus=newcomer, key=asked: wire.ask(bus, key, {}, source="test", timeout_s=0.5), what=asked)
        until(lambda: answers(robot, "s"), what="a line from who was there before")


def answers(robot: Robot, line: str) -> bool:
    """Say a line on the session that was there before; its link may be on the way back, then nobody is asked."""
    replies = robot.bus.get(keys.console(robot.name), payload=line, timeout=1.0)
    return any(reply.ok is not None and json.loads(reply.ok.payload.to_bytes())["code"] == 0 for reply in replies)


def test_sessions_of_one_process_outlast_any_holding_up():
    assert session.HELD_MS >= 1000 * session.LINK_LEASE_MS
