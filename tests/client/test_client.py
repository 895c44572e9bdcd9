"""A program's way to a robot, on a whole one in simulation: it looks, says lines, borrows motion, and loses it when it stands still."""

import os
import signal
import sys
import time
from contextlib import ExitStack

import pytest

from lbr import client
from tests.client.wheels import release, turning, wheels
from tests.support import programs
from tests.support import robot as robots
from tests.support.mover import HELD_UP, NOT_BEGUN
from tests.support.waiting import until

PATIENT = {"ttl_s": 1.0}
"""The longest life of a lease: the machine may hold up a test."""
DRIVING = """
import time
import lbr_client as client

with client.connect() as robot:
    while True:
        try:
            with robot.borrow("drive/command", power=0.15, angle_deg=180, ttl_s=1.0) as motion:
                print("drives", flush=True)
                while motion.keep():
                    time.sleep(0.02)
        except client.RefusalError:  # the machine has held it up
            time.sleep(0.05)
"""


def borrowed(robot, key="drive/command", **message):
    """Borrow, once the base is armed again after what was before."""

    def begun():
        try:
            return robot.borrow(key, **message, **PATIENT)
        except client.RefusalError as error:
            if error.code not in NOT_BEGUN:
                raise
            return None

    return until(begun)


def turns(robot, running):
    """Borrow a motion until the wheels turn by it."""

    def turned():
        motion = borrowed(robot, power=0.1, angle_deg=180)
        try:
            return until(lambda: motion.keep() and turning(running)) and motion
        except client.RefusalError as error:
            if error.code not in HELD_UP:
                raise
            return None

    return until(turned)


def test_it_finds_the_robot_that_runs_here_and_looks_at_it(robot):
    assert (robot.name, robot.role) == ("lbr", "admin")
    assert {one["name"] for one in robot.latest("@status")["capabilities"]} >= {"drive", "motors"}
    found = robot.stream("ranges/readings", within_s=9.0)
    assert {"forward_m", "back_m"} <= set(next(found))
    found.close()
    with pytest.raises(client.BusError, match="nothing answers on 'nothing/here'"):
        robot.latest("nothing/here")


def test_a_line_is_said_and_what_it_moves_is_over_when_it_returns(robot):
    until(lambda: robot.latest("attitude/state")["valid"])

    def turned():
        try:
            return robot.say("/t/20")
        except client.RefusalError as error:
            if error.code not in HELD_UP:
                raise
            return None

    assert "degrees" in until(turned).ending
    assert robot.latest("drive/state")["moving"] is False
    assert "drive" in robot.say("status").text


@pytest.mark.parametrize(("line", "code"), [("/r/3/0", "bad_value"), ("/nonsense", "unknown_command")])
def test_a_line_that_is_refused_says_why_in_words_and_by_code(robot, line, code):
    with pytest.raises(client.RefusalError) as refused:
        robot.say(line)
    assert refused.value.code == code
    assert str(refused.value)


def test_a_command_that_is_refused_raises_its_sentence_and_code(robot):
    assert robot.ask("drive/stop")["accepted"]
    with pytest.raises(client.RefusalError, match=r"Expected `bool`, got `str` - at `\$\.enabled`") as refused:
        robot.ask("motors/enable", enabled="of course")
    assert refused.value.code == "malformed"


@pytest.mark.parametrize("power", [float("nan"), float("inf")])
def test_what_is_no_number_is_named_before_it_is_sent(robot, power):
    with pytest.raises(client.InputError, match=f"power={power} is no number"):
        robot.borrow("drive/command", power=power)
    with pytest.raises(client.InputError, match=f"power={power} is no number"):
        robot.ask("drive/command", power=power)
    with borrowed(robot, power=0.1) as motion, pytest.raises(client.InputError, match="is no number"):
        motion.keep(power=power)


def test_borrowed_motion_goes_on_while_it_is_kept_changes_and_ends_with_its_with(robot, running):
    with turns(robot, running) as motion:
        first = wheels(running)
        until(lambda: motion.keep(power=0.2) and abs(wheels(running)[0]) > abs(first[0]) + 0.05)
    until(lambda: wheels(running) == (0.0, 0.0))
    with pytest.raises(client.RefusalError) as ended:
        motion.keep()
    assert ended.value.code == "cancelled"


def test_motion_that_is_not_kept_lapses_and_says_so(robot, running):
    def ended():
        motion = turns(robot, running)
        until(lambda: wheels(running) == (0.0, 0.0))  # nothing of ours runs meanwhile
        with pytest.raises(client.RefusalError) as ended:
            until(lambda: not motion.keep())
        motion.release()
        return None if ended.value.code in NOT_BEGUN else ended.value.code

    assert until(ended) in {"dead_lease", "lapsed"}


def test_a_move_with_an_end_is_waited_for(robot):
    def turned():
        with borrowed(robot, "drive/turn", angle_deg=-20.0) as motion:
            try:
                motion.wait()
            except client.RefusalError as error:
                if error.code not in HELD_UP:
                    raise
            return motion.done

    until(turned)


def test_another_ones_stop_and_the_emergency_stop_end_it_with_their_code(robot, running):
    for stop, codes in ((lambda: running.say("s"), {"stopped"}), (running.press, {"estop"})):
        with turns(robot, running) as motion:
            stop()
            with pytest.raises(client.RefusalError) as ended:
                until(lambda motion=motion: not motion.keep())
            assert ended.value.code in codes | {"dead_lease"}
        until(lambda: wheels(running) == (0.0, 0.0))
    with pytest.raises(client.RefusalError) as refused:
        robot.borrow("drive/command", power=0.1)
    assert refused.value.code == "estop"
    release(robot)


@pytest.mark.parametrize("end", [signal.SIGKILL, signal.SIGSTOP])
def test_the_distribution_drives_without_lbr_and_the_wheels_stand_when_its_program_is_ended(end, alone, running, home):
    running.say("reset")
    command = [alone, "-I", "-c", DRIVING]
    program = programs.start(command, env=robots.environment(home), stdout=-1, stderr=-1, text=True)
    try:
        assert program.stdout.readline() == "drives\n", program.communicate()
        until(lambda: turning(running))
        os.kill(program.pid, end)
        until(lambda: wheels(running) == (0.0, 0.0))
    finally:
        program.kill()
        program.communicate()


def test_reading_a_stream_again_later_gives_the_newest_and_not_what_came_meanwhile(robot):
    found = robot.stream("drive/state", within_s=9.0)
    next(found)
    time.sleep(0.5)  # what comes meanwhile is not kept
    began = time.monotonic()
    for _ in range(3):
        next(found)
    assert time.monotonic() - began > 0.02
    found.close()


LEFT_OPEN = """
from lbr import client

robot = client.connect()
robot.do.status()
close = robot.operator.close
robot.operator.close = lambda: (close(), print("let go,", "closed" if robot.session.is_closed() else "connected"))
"""


def test_a_program_that_does_not_close_its_robot_leaves_the_bus_before_the_interpreter_ends(running, home):
    env = {**os.environ, "LBR_HOME": str(home)}
    done = programs.run([sys.executable, "-c", LEFT_OPEN], env=env, capture_output=True, text=True)
    assert (done.stdout, done.stderr, done.returncode) == ("let go, connected\n", "", 0)


FORKED = """
import multiprocessing
from lbr import client

def said(do):
    try:
        return do()
    except client.BusError as error:
        return str(error)

def child():
    for do in (lambda: robot.say("status"), lambda: robot.latest("drive/state"), client.connect):
        print(said(do), flush=True)
    robot.close()

with client.connect() as robot:
    kept, tries = False, 20
    while not kept and (tries := tries - 1):
        try:
            with robot.drive(0.15, 180):
                forked = multiprocessing.get_context("fork").Process(target=child)
                forked.start()
                forked.join()
                kept = robot.latest("drive/state")["holder"] is not None
        except client.RefusalError:  # the machine has held it up
            pass
    print(forked.exitcode, kept)
"""


def test_a_forked_process_is_told_to_be_spawned_and_leaves_its_parents_motion_alone(running, home):
    env = {**os.environ, "LBR_HOME": str(home)}
    done = programs.run([sys.executable, "-c", FORKED], env=env, capture_output=True, text=True)
    *told, parent = done.stdout.splitlines()
    assert (parent, done.stderr, done.returncode) == ("0 True", "", 0)
    assert ["was forked" in text for text in told[:3]] == [True] * 3
    assert all("was forked" in text for text in told)


def test_a_motion_that_is_not_there_is_told_with_what_names_those_that_are(robot):
    with pytest.raises(client.RefusalError, match="'drive/nope' does not answer"):
        robot.borrow("drive/nope")


def test_a_whole_robots_words_are_methods(robot):
    assert {"r", "t", "stop", "status"} <= set(dir(robot.do))
    assert "drive" in robot.do.status().text
    assert "power" in robot.do.r.__doc__


def test_a_program_that_outlives_its_robot_is_told_to_connect_again(monkeypatch, tmp_path):
    home = robots.prepare(tmp_path / "h")
    monkeypatch.setenv("LBR_HOME", str(home))
    with ExitStack() as stack:
        with robots.running(home):
            robot = stack.enter_context(client.connect(name="a test"))
        for do in (
            lambda: robot.say("status"),
            lambda: robot.latest("drive/state"),
            lambda: next(robot.stream("drive/state", within_s=0.1)),
            lambda: robot.borrow("drive/command", power=0.1),
        ):
            with pytest.raises(
                (client.BusError, client.RefusalError), match=r"ended since this program connected; .* again"
            ):
                do()
