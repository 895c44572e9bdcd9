"""`lbr stop` with an executive that stands still."""

import os
import signal

from tests.support import robot as robots


def test_a_frozen_robot_is_shut_down_as_any_other(tmp_path):
    with robots.running(robots.prepare(tmp_path / "h")) as robot:
        os.kill(robot.popen.pid, signal.SIGSTOP)
        done = robots.lbr(robot.home, "stop")
        assert (done.returncode, done.stdout) == (0, "robot 'lbr' has shut down\n")
        assert robot.popen.wait(5.0) == 0
