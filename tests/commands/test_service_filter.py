"""What runs under the unit's own filter of system calls: a whole robot, as systemd would start it."""

import ctypes.util
import os
import shutil
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

from lbr.commands import unitfiles
from lbr.commands.unitfiles import RELAY_UNIT, UNIT, Extras, Site
from tests.support import programs, robot
from tests.support.waiting import HANG_S, until

SITE = Site(program=(str(Path(sys.prefix) / "bin" / "lbr"),), groups=("tty",))
FILTERED = Path(__file__).with_name("under_filter.py")
pytestmark = pytest.mark.skipif(
    shutil.which("systemd-analyze") is None or ctypes.util.find_library("seccomp") is None,
    reason="systemd-analyze or libseccomp is not installed",
)


def allowed(unit: str) -> set[str]:
    """The system calls that a unit's lines leave, as systemd.exec(5) has it: the first line decides what the rest adds to."""
    found: set[str] = set()
    for line in unit.splitlines():
        key, _, words = line.partition("=")
        if key != "SystemCallFilter":
            continue
        takes_away = words.startswith("~")
        for word in words.removeprefix("~").split():
            calls = expanded(word)
            found = found - calls if takes_away else found | calls
    return found | expanded("@default")


def expanded(word: str) -> set[str]:
    return {call for one in groups()[word] for call in expanded(one)} if word.startswith("@") else {word}


@cache
def groups() -> dict[str, set[str]]:
    """Return what is in each group of system calls: names and other groups."""
    shown = programs.run(
        ["systemd-analyze", "syscall-filter"], capture_output=True, text=True, check=True, timeout=HANG_S
    )
    found: dict[str, set[str]] = {}
    for line in shown.stdout.splitlines():
        if line.startswith("@"):
            inside = found[line.strip()] = set()
        elif line.strip() and not line.strip().startswith("#"):
            inside.add(line.strip())
    return found


@pytest.fixture(scope="module")
def files() -> dict[str, str]:
    return unitfiles.files("lbr-sim", "daemon", SITE, Extras(motor_relay="i2c:1:0x69"))


@pytest.fixture(scope="module")
def calls(files: dict[str, str]) -> str:
    return " ".join(sorted(allowed(files[UNIT])))


def filtered(calls: str, *program: str) -> "subprocess.CompletedProcess[str]":
    words = [sys.executable, str(FILTERED), calls, *program]
    return programs.run(words, capture_output=True, text=True, check=False, timeout=HANG_S)


def test_the_filter_is_at_work(calls):
    done = filtered(calls, sys.executable, "-c", "import os; os.setgroups([])")
    assert "Operation not permitted" in done.stderr


def test_a_process_gives_up_its_rights_under_the_filter(calls):
    done = filtered(
        calls, sys.executable, "-c", "from lbr.capability import confine; confine.confine(); print('confined')"
    )
    assert (done.stdout, done.stderr) == ("confined\n", "")


def test_the_relay_starts_under_its_filter(files):
    calls = " ".join(sorted(allowed(files[RELAY_UNIT])))
    done = filtered(calls, sys.executable, "-P", "-m", "lbr.drivers.pico.relay", "--help")
    assert done.returncode == 0, done.stderr


def test_a_whole_robot_runs_drives_and_ends_under_the_filter(tmp_path, calls):
    home = robot.prepare(tmp_path)
    started = robot.start(home, prefix=(sys.executable, str(FILTERED), calls))
    try:
        phases = {unit["name"]: unit["phase"] for unit in started.status()["capabilities"]}
        assert phases == dict.fromkeys(("drive", "motors", "ranges", "world"), "ready")
        ahead = {"power": 0.1, "angle_deg": 0}
        until(lambda: started.ask("drive/command", ahead)["accepted"], what="the base may be driven")
        assert all(unit["restarts"] == 0 for unit in started.status()["capabilities"])
        seccomp = Path(f"/proc/{started.capability('motors')['pid']}/status").read_text()
        assert "Seccomp:\t2" in seccomp
    finally:
        assert started.close() == 0
    assert "Operation not permitted" not in "".join(log.read_text() for log in (home / "logs").glob("*.log"))


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can raise a rank and see whether it was refused")
def test_motion_processes_may_be_raised_under_the_filter(calls):
    done = filtered(
        calls, sys.executable, "-c", "import os; os.setpriority(os.PRIO_PROCESS, 0, -10); print(os.nice(0))"
    )
    assert (done.stdout, done.stderr) == ("-10\n", "")
