"""What every process of a robot has given up, and who alone holds devices and rows."""

import os
import sys
from pathlib import Path

import psutil

from lbr.capability import confine as confined
from lbr.capability import fork_server
from lbr.executive.processes.reaper import PROGRAM
from tests.support import needs, programs
from tests.support.bench import processes_of
from tests.support.robot import Robot
from tests.support.waiting import until

CONFINED = """
import sys
from lbr.capability.confine import confine
confine(sys.argv[1:])
print(open('/proc/self/status').read())
"""
HELD = ("Eff", "Prm", "Inh", "Amb", *(("Bnd",) if os.geteuid() == 0 else ()))
"""Rights of the kernel that nothing has; an ordinary user cannot bound what he has not."""


def field(status: str, name: str) -> str:
    return next(line.split(":", 1)[1].strip() for line in status.splitlines() if line.startswith(f"{name}:"))


def held(*places: str) -> int:
    done = programs.run([sys.executable, "-c", CONFINED, *places], capture_output=True, text=True, check=True)
    return int(field(done.stdout, "CapEff"), 16)


def holders(robot: Robot, *beginnings: str) -> set[int]:
    """Every process of the robot that has something open whose path begins so."""

    def holds(process: psutil.Process) -> bool:
        try:
            return any(str(fd.readlink()).startswith(beginnings) for fd in Path(f"/proc/{process.pid}/fd").iterdir())
        except FileNotFoundError:  # it has ended, or has closed that one
            return process.is_running() and holds(process)

    return {process.pid for process in processes_of(robot.home) if holds(process)}


@needs.root("has something to give up")
def test_root_keeps_nothing_unless_a_place_belongs_to_another(tmp_path):
    foreign = tmp_path / "foreign"
    foreign.touch()
    os.chown(foreign, 1, 1)
    assert held(str(tmp_path), "/no/such/device", "usb:20d2:5740") == 0
    assert held(str(tmp_path), str(foreign)) == 1 << confined.CAP_DAC_OVERRIDE


def test_every_process_but_the_executive_its_reaper_and_its_fork_server_is_confined_in_all_its_threads(robot: Robot):
    settings = '{"argv": ["/bin/sleep", "60"]}'
    robot.edit("INSERT INTO capability (robot, name, kind, settings) VALUES ('lbr', 'sleeper', 'exec', ?)", settings)
    until(lambda: robot.capability("sleeper")["phase"] == "ready")
    until(lambda: "sleep" in psutil.Process(robot.capability("sleeper")["pid"]).name())
    until(lambda: len(processes_of(robot.home)) >= 8)  # those three, those of four capabilities, a guard, the program
    others = [process for process in processes_of(robot.home) if process.pid != robot.popen.pid]
    others = [process for process in others if not {str(PROGRAM), fork_server.__name__} & set(process.cmdline())]
    for process in others:
        for task in Path(f"/proc/{process.pid}/task").iterdir():
            status = (task / "status").read_text()
            assert {field(status, f"Cap{which}") for which in HELD} == {"0" * 16}
            assert field(status, "NoNewPrivs") == "1"
        assert field(status, "Umask") == "0077"
        assert process.rlimit(psutil.RLIMIT_CORE) == (0, 0)
    robot.edit("DELETE FROM capability WHERE name = 'sleeper'")


@needs.LOOKING_INSIDE
def test_only_drivers_and_the_emulated_hardware_hold_devices_and_only_the_executive_the_rows(robot: Robot):
    pids = {unit["name"]: unit["pid"] for unit in robot.status()["capabilities"]}
    guards = {child.pid for child in psutil.Process(pids["motors"]).children()}
    holding = holders(robot, "/dev/pts/", "/dev/tty", "/dev/ptmx")
    assert holding - guards == {pids["motors"], pids["ranges"], pids["world"]}
    assert holders(robot, str(robot.home / "robot.db")) == {robot.popen.pid}
