"""A15: what each process of a robot holds: no privilege, no file that is another's business."""

import re
from collections.abc import Iterator
from pathlib import Path

import psutil

from lbr.capability import fork_server
from lbr.executive.processes.reaper import PROGRAM
from tests.fuzzing import intruder
from tests.support.bench import Bench, bench, processes_of
from tests.support.figures import Results
from tests.support.waiting import until

UNCONFINED = {"executive", "reaper", "fork server"}
"""The executive starts the others, and sets their niceness and their devices first; its reaper has to see them all; what
is forked gives up what it has to by itself."""
HELPERS = {str(PROGRAM): "reaper", fork_server.__name__: "fork server"}
"""By a word of their command lines."""
EXTERNAL = (
    'UPDATE external_command SET argv = \'["/bin/sleep", "60"]\', blocking = 0',
    (
        "INSERT INTO capability (robot, name, kind, settings) VALUES ('lbr', 'sleeper', 'exec',"
        ' \'{"argv": ["/bin/sleep", "60"]}\')'
    ),
)


def processes(results: Results) -> None:
    """Look at every process of a running robot, also at programs that it started."""
    with bench(results, "spy", edits=(*EXTERNAL, *intruder.spy_rows())) as under_test:
        under_test.all_ready()
        under_test.robot.line("clock")
        until(lambda: _began(under_test, "/bin/sleep", 2), what="both programs have begun")
        for process in processes_of(under_test.robot.home):
            results.check("A15", list(_wrong(under_test, process)))
        results.check("A15", _open_to_others(under_test.robot.home))


def _began(under_test: Bench, program: str, count: int) -> bool:
    """Say whether this many tethers have become the program."""
    return [process.cmdline()[:1] for process in processes_of(under_test.robot.home)].count([program]) == count


def _wrong(under_test: Bench, process: psutil.Process) -> Iterator[str]:
    status = Path(f"/proc/{process.pid}/status").read_text()
    name = _name(under_test, process)
    fields = dict(re.findall(r"^(\w+):\t(.*)$", status, re.MULTILINE))
    if name not in UNCONFINED:
        if int(fields["CapEff"], 16) or int(fields["CapPrm"], 16):
            yield f"{name} has the capabilities {fields['CapEff']}"
        if fields["NoNewPrivs"] != "1":
            yield f"{name} may gain privileges"
    if fields["Umask"] != "0077":
        yield f"{name} has the umask {fields['Umask']}"
    held = _held(process)
    owners = _owners(under_test)
    devices = under_test.robot.home / "run" / f"{under_test.robot.name}-devices"
    for link in devices.iterdir():
        if str(link.resolve()) in held and name not in {owners.get(link.name), "world"}:
            yield f"{name} holds {link.name}"
    if name != "executive" and any("robot.db" in path for path in held):
        yield f"{name} holds the database"


def _owners(under_test: Bench) -> dict[str, str]:
    """Return the one process that may hold each device; besides it only the world does, which emulates it."""
    settings = under_test.robot.line("/report/settings")["data"]
    processes = {unit["name"]: unit["process"] or unit["name"] for unit in under_test.units()}
    return {
        said["device"]: processes[name] for name, said in settings.items() if "device" in said and name != "attitude"
    }


def _name(under_test: Bench, process: psutil.Process) -> str:
    """Return whose process it is; a child is its parent's."""
    pids = {under_test.robot.ready["pid"]: "executive"}
    pids |= {unit["pid"]: unit["process"] or unit["name"] for unit in under_test.units()}
    while process.pid not in pids and (parent := process.parent()) is not None:
        if parent.pid == under_test.robot.ready["pid"]:
            return next((HELPERS[word] for word in process.cmdline() if word in HELPERS), "program")
        process = parent
    return pids.get(process.pid, "stranger")


def _held(process: psutil.Process) -> set[str]:
    found = set()
    for link in Path(f"/proc/{process.pid}/fd").iterdir():
        try:
            found.add(str(link.readlink()))
        except OSError:
            continue
    return found


def _open_to_others(home: Path) -> list[str]:
    """Return files and folders of the home that others may read or write, beyond those that we made for the test."""
    ours = {"stderr.txt", "trace.txt"}
    return [
        f"{path.relative_to(home)} has mode {path.stat().st_mode & 0o777:o}"
        for path in home.rglob("*")
        if path.name not in ours and not path.is_symlink() and path.exists() and path.stat().st_mode & 0o077
        if "capabilities" not in path.parts
    ]
