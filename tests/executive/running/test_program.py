"""Processes of a robot: a program in any language, their rank, what each has given up; nothing outlives the executive."""

import json
import os
import signal
import sys
import time
from pathlib import Path

import psutil
import pytest

from lbr.capability import fork_server
from lbr.executive.processes import scheduling
from lbr.executive.processes.reaper import PROGRAM
from tests.support import needs
from tests.support.bench import processes_of
from tests.support.waiting import until

SHELL = "import os, time, json; print(json.dumps({k: v for k, v in os.environ.items() if k[:4] == 'LBR_'}), flush=True); time.sleep(60)"

HELD = ("Eff", "Prm", "Inh", "Amb", *(("Bnd",) if os.geteuid() == 0 else ()))
"""Rights of the kernel that nothing has; an ordinary user cannot bound what he has not."""


def field(status: str, name: str) -> str:
    return next(line.split(":", 1)[1].strip() for line in status.splitlines() if line.startswith(f"{name}:"))


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("strange", "#!/no/such/shell\n", "there is no such program, or what its first line names"),
        ("bare", "echo I have no first line\n", "'chmod +x' it"),
    ],
)
def test_a_program_that_does_not_start_is_reported_with_what_is_wrong(robot, tmp_path, name, text, said):
    program = tmp_path / name
    program.write_text(text)
    program.chmod(0o755)
    robot.edit(
        "INSERT INTO capability (robot, name, kind, settings, restart) VALUES ('lbr', ?, 'exec', ?, 'never')",
        name,
        json.dumps({"argv": [str(program)]}),
    )
    until(lambda: any((unit["name"], unit["phase"]) == (name, "failed") for unit in robot.status()["capabilities"]))
    assert said in robot.capability(name)["reason"]
    assert str(program) in (robot.home / "logs" / f"lbr-{name}.log").read_text()


def test_movers_and_drivers_outrank_a_program(robot):
    nice = {unit["name"]: unit["nice"] for unit in robot.status()["capabilities"]}
    if os.geteuid() == 0:
        assert nice["motors"] == nice["drive"] == nice["ranges"] == nice["world"] == scheduling.MOTION
        assert os.getpriority(os.PRIO_PROCESS, robot.popen.pid) == scheduling.MOTION
    threads = Path(f"/proc/{robot.capability('motors')['pid']}/task")
    assert {os.getpriority(os.PRIO_PROCESS, int(task.name)) for task in threads.iterdir()} == {nice["motors"]}
    settings = '{"argv": ["/bin/sleep", "60"]}'
    robot.edit("INSERT INTO capability (robot, name, kind, settings) VALUES ('lbr', 'nap', 'exec', ?)", settings)
    until(lambda: robot.capability("nap").get("nice") == scheduling.BACKGROUND)
    robot.edit("DELETE FROM capability WHERE name = 'nap'")
    until(lambda: "nap" not in {unit["name"] for unit in robot.status()["capabilities"]})


def holders(robot, *beginnings: str) -> set[int]:
    """Every process of the robot that has something open whose path begins so."""

    def holds(process: psutil.Process) -> bool:
        try:
            return any(str(fd.readlink()).startswith(beginnings) for fd in Path(f"/proc/{process.pid}/fd").iterdir())
        except FileNotFoundError:  # it has ended, or has closed that one
            return process.is_running() and holds(process)

    return {process.pid for process in processes_of(robot.home) if holds(process)}


def test_every_process_but_the_executive_its_reaper_and_its_fork_server_is_confined_in_all_its_threads(robot):
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
def test_only_drivers_and_the_emulated_hardware_hold_devices_and_only_the_executive_the_rows(robot):
    pids = {unit["name"]: unit["pid"] for unit in robot.status()["capabilities"]}
    guards = {child.pid for child in psutil.Process(pids["motors"]).children()}
    holding = holders(robot, "/dev/pts/", "/dev/tty", "/dev/ptmx")
    assert holding - guards == {pids["motors"], pids["ranges"], pids["world"]}
    assert holders(robot, str(robot.home / "robot.db")) == {robot.popen.pid}


def test_a_program_learns_its_wiring_and_restarts(robot):
    settings = json.dumps({"argv": [sys.executable, "-c", SHELL], "inputs": ["ranges"], "outputs": ["noise"]})
    robot.edit("INSERT INTO capability (robot, name, kind, settings) VALUES ('lbr', 'beep', 'exec', ?)", settings)
    robot.edit("INSERT INTO channel (robot, source, target) VALUES ('lbr', 'ranges.readings', 'beep.ranges')")
    log = robot.home / "logs" / "lbr-beep.log"
    until(lambda: log.exists() and "ranges/readings" in log.read_text())
    wiring = json.loads(next(line for line in log.read_text().splitlines() if "ranges/readings" in line))
    assert wiring["LBR_ROBOT"] == "lbr"
    assert Path(wiring["LBR_CONFIG"]).stat().st_mode & 0o777 == 0o600
    assert json.loads(wiring["LBR_INPUTS"]) == {"ranges": ["lbr/ranges/readings"]}
    assert json.loads(wiring["LBR_OUTPUTS"]) == {"noise": "lbr/beep/noise"}
    pid = until(lambda: robot.capability("beep")["pid"])
    executive = psutil.Process(robot.popen.pid)
    used = sum(executive.cpu_times()[:2])
    looked = time.monotonic()
    until(lambda: time.monotonic() - looked > 1.0)
    assert sum(executive.cpu_times()[:2]) - used < 0.5, "the executive spins beside a program"
    os.kill(pid, signal.SIGKILL)
    until(lambda: robot.capability("beep")["pid"] not in {None, pid})
