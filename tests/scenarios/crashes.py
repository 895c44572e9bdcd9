"""S13 and P5: processes that crash or hang by themselves, on the path to the motors and beside it."""

import os
import signal
import time
from contextlib import suppress

import psutil

from lbr.bus import wire
from tests.support.bench import ANGLES, Bench, bench
from tests.support.figures import Results
from tests.support.waiting import HANG_S

CRASHES = (
    *("exception", "callback", "thread", "exit", "recursion", "memory"),
    *("exit 0", "thread exit", "abort", "segfault", "terminated"),
)
HANGS = ("busy", "deadlock", "interpreter", "frozen")
AFTERMATH_S = 0.25
VICTIMS = ("failures", "failing_motors", "failing_app")
EDITS = (
    "UPDATE capability SET kind = 'failing_motors' WHERE robot = 'lbr' AND name = 'motors'",
    """INSERT INTO capability (robot, name, kind, settings, needs, help)
       VALUES ('lbr', 'app', 'failing_app', '{}', '["drive"]', 'Drives and fails')""",
    "INSERT INTO channel (robot, source, target) VALUES ('lbr', 'app.move', 'drive.command')",
)


def motor_driver_fails(under_test: Bench, how: str, figure: str) -> None:
    """The motor driver goes wrong while another drives."""
    mover = under_test.drive()
    _fails(under_test, "motors", how, figure)
    mover.cease()


def driving_app_fails(under_test: Bench, how: str, figure: str) -> None:
    """The app that drives goes wrong."""
    accepted = under_test.robot.ask("app/go", {"angle_deg": under_test.dice.choice(ANGLES)})
    assert accepted["accepted"], accepted
    under_test.wait_for_motion()
    _fails(under_test, "app", how, figure)


def crashes(results: Results, n: int) -> None:
    """S13: every way to crash, on both sides."""
    _all(results, n, CRASHES, "S13")


def hangs(results: Results, n: int) -> None:
    """P5: every way to hang, on both sides."""
    _all(results, n, HANGS, "P5")


def _all(results: Results, n: int, ways: tuple[str, ...], figure: str) -> None:
    with bench(results, *VICTIMS, edits=EDITS) as under_test:
        for _ in range(n):
            for how in ways:
                motor_driver_fails(under_test, how, figure)
                under_test.forget_deaths("motors")
                driving_app_fails(under_test, how, figure)
                under_test.forget_deaths("app")


def _fails(under_test: Bench, name: str, how: str, figure: str) -> None:
    pid = under_test.pid(name)
    fault_ns = time.monotonic_ns()
    if how == "frozen":
        os.kill(pid, signal.SIGSTOP)
    else:
        _tell(under_test, name, how)
    stop = figure if figure == "S13" else "P5 stop"
    zero = under_test.stopped_after(stop, fault_ns)
    _until_gone(under_test, pid, fault_ns, f"{figure} gone")
    under_test.ready_again(name, pid, fault_ns, f"{figure} ready", limit_s=HANG_S)
    under_test.pass_time(AFTERMATH_S)
    under_test.stays_at_rest(zero)
    under_test.results.check(figure if figure == "S13" else "P5 stop", _told_differently(under_test, name))
    if name == "motors":
        under_test.begins_with_zero(fault_ns)


def _told_differently(under_test: Bench, name: str) -> list[str]:
    """Compare what the status and the events say of the last end; the console shows the events."""
    status = under_test.unit(name)["last_end"]
    kinds = {"crashed", "hung", "taken_along"}
    ends = [e for e in under_test.robot.events() if e["subject"] == name and e["kind"] in kinds]
    event = ends[-1]["text"] if ends else ""
    return [] if status and event.startswith(status) else [f"status says {status!r}, the event {event!r}"]


def _tell(under_test: Bench, name: str, how: str) -> None:
    """Ask for the failure without waiting for an answer that may never come."""
    robot = under_test.robot
    with suppress(Exception):
        wire.put(robot.bus, f"{robot.name}/{name}/fail", {"how": how}, source="bench")


def _until_gone(under_test: Bench, pid: int, fault_ns: int, figure: str) -> None:
    under_test.until(lambda: not _runs(pid), HANG_S, f"process {pid} gone", every_s=0.005)
    under_test.results.sample(figure, (time.monotonic_ns() - fault_ns) * 1e-6)


def _runs(pid: int) -> bool:
    try:
        return psutil.Process(pid).status() != psutil.STATUS_ZOMBIE
    except psutil.Error:
        return False
