import os
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path
from tty import setraw

from lbr.drivers.servos.guard_release import GuardRelease
from lbr.errors import DeviceError
from lbr.robots.uxa90.driver.guard_release import BoardRelease
from tests.support import programs
from tests.support.waiting import HANG_S, until

DRIVER = """
import json, sys, time
from tests.drivers.peers import DriverContext
from lbr.robots.uxa90.driver import KIND
from lbr.robots.uxa90.driver.capability import Uxa90
from lbr.robots.uxa90.driver.packets import position_rad
from lbr.messages.joints import Joint
from lbr.messages.servos import ServoGoal, ServoSetpoint, StoredPlay
settings = {"device": "board", "release_s": 0.3, "settle_s": 0.05, "sweep_hz": 50} | json.loads(sys.argv[2])
ctx = DriverContext(KIND, KIND.parse(json.dumps(settings)), sys.argv[1], "uxa90")
ctx.wired["setpoint"] = ("joints",)
ctx.given = tuple(
    Joint(name=f"joint_{n}", device_id=n, lower_rad=-2.0, upper_rad=2.0, speed_rps=3.0) for n in (0, 1, 2)
)
servos = Uxa90(ctx)
servos.open()
told = False
while True:
    known = ctx.published and ctx.published[-1][0] == "state" and ctx.state.armed or "known" in globals() and known
    goals = tuple(ServoGoal(id=n, position_rad=position_rad(120), torque=1.0 if known else 0.0) for n in (0, 1, 2))
    stored = StoredPlay(slot=4, count=9, duration_s=60.0) if known and sys.argv[3] == "play" else None
    ctx.give(ServoSetpoint(goals=goals, lease="a" if known else "", stored=stored), source="joints")
    servos.step()
    if servos._session.guard is not None and not told:
        told = print("guarded", flush=True) or True
    time.sleep(0.01)
"""


def driving(board, row, play=""):
    """A driver in a process of its own, whose servos are on their way; or it has the main board play."""
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[3])}
    process = programs.start(
        [sys.executable, "-c", DRIVER, str(board.path), row, play], env=environment, stdout=subprocess.PIPE
    )
    assert process.stdout.readline() == b"guarded\n"
    process.stdout.close()
    if play:
        until(lambda: board.plays == [4])
    else:
        until(lambda: all(servo.level == 0 for servo in board.servos.values()))
    board.forget()
    return process


def test_a_driver_that_hangs_is_killed_and_its_guard_holds_the_servos_then_brakes_then_lets_them_go(board):
    process = driving(board, '{"hold_s": 0.2, "guard_silence_ms": 1000}')
    process.send_signal(signal.SIGSTOP)
    until(lambda: board.braked)
    assert [one for one in board.packets if one[1] >> 5 == 6][:1] == [bytes.fromhex("FFDF207F")]
    assert board.frames[0][8] == 0x10
    assert not board.moves()
    until(lambda: board.packets[-3:] == [bytes.fromhex(one) for one in ("FFC01050", "FFC11051", "FFC21052")])
    assert process.wait(HANG_S) == -signal.SIGKILL


def test_the_guard_of_a_killed_driver_ends_what_the_main_board_plays_and_a_new_driver_takes_the_line_from_it(board):
    from tests.robots.uxa90.test_uxa90_capability import Rig

    process = driving(board, '{"hold_s": 60.0, "guard_silence_ms": 2000}', "play")
    assert board.mode == "normal"
    process.kill()
    until(lambda: board.mode == "pc")
    assert not board.packets
    process.wait(HANG_S)
    made = []

    def opened():
        with suppress(DeviceError):  # the guard may just be looking whether somebody took the line
            made.append(Rig(board))
        return made

    until(opened)
    rig = made[0]
    rig.at({0: 200, 1: 200, 2: 200})
    rig.until(lambda: len(board.moves()) >= 3)
    assert board.moves()[:3] == [(0, 0, 100), (1, 0, 104), (2, 0, 108)]
    rig.sweeps()
    assert not board.braked
    rig.driver.close()


def test_the_guard_is_done_when_the_line_is_gone():
    peer, line = os.openpty()
    setraw(line)
    waited = []

    def pull(_seconds: float) -> None:
        if not waited:
            os.close(peer)
        waited.append(_seconds)
        assert len(waited) < 5, "it goes on without a line"

    GuardRelease(BoardRelease(line, (0, 1), 0.0), line, sleep=pull, clock=time.monotonic).act(60.0, 1.0)
    assert waited
    os.close(line)
