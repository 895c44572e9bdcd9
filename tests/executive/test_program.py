"""Kind `exec`: a program in any language, wired by its environment; and nothing outlives the executive."""

import json
import os
import signal
import sys
import time
from pathlib import Path

import psutil
import pytest

from lbr.executive.processes import scheduling
from tests.support.waiting import until

SHELL = "import os, time, json; print(json.dumps({k: v for k, v in os.environ.items() if k[:4] == 'LBR_'}), flush=True); time.sleep(60)"


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("gone", None, "there is no such program"),
        ("strange", "#!/no/such/shell\n", "its first line"),
        ("bare", "echo I have no first line\n", "'chmod +x' it"),
    ],
)
def test_a_program_that_does_not_start_is_reported_with_what_is_wrong(robot, tmp_path, name, text, said):
    program = tmp_path / name
    if text is not None:
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


def test_a_program_learns_its_wiring_restarts_and_dies_with_the_executive(robot):
    """The last one here: it ends the robot."""
    settings = json.dumps({"argv": [sys.executable, "-c", SHELL], "inputs": ["ranges"], "outputs": ["noise"]})
    robot.edit("INSERT INTO capability (robot, name, kind, settings) VALUES ('lbr', 'beep', 'exec', ?)", settings)
    robot.edit("INSERT INTO channel (robot, source, target) VALUES ('lbr', 'ranges.readings', 'beep.ranges')")
    log = robot.home / "logs" / "lbr-beep.log"
    until(lambda: log.exists() and "ranges/readings" in log.read_text())
    wiring = json.loads(next(line for line in log.read_text().splitlines() if line.startswith("{")))
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
    second = until(lambda: (now := robot.capability("beep")["pid"]) not in {None, pid} and now)
    robot.popen.kill()
    until(lambda: not psutil.pid_exists(second) or psutil.Process(second).status() == psutil.STATUS_ZOMBIE)
