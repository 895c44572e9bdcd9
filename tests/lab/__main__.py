"""`python -m tests.lab`: build the machine, run the tests and the service in it, show what came of them."""

import argparse
import io
import shlex
import sys
import tarfile
import time
from collections.abc import Generator, Sequence
from contextlib import closing
from pathlib import Path

from tests.lab import __doc__ as about
from tests.lab import first_start, image, network, robots, service, stage, table
from tests.lab.machine import SNAPSHOT, Machine
from tests.lab.processor import HERE, PROCESSORS
from tests.lab.stage import Scene
from tests.support import programs

ROOT = Path(__file__).resolve().parents[2]
FOLDER = ROOT / "build" / "lab"
SENT = (
    "tests/__init__.py",
    "tests/conftest.py",
    "tests/support",
    "tests/kernel",
    "tests/lab",
    "examples/roboclaw",
    "examples/so101",
    "pyproject.toml",
    "robot.db.sql",
)
"""What of the source is wanted beside the wheel that is in it."""
SENT_FOR_OTHERS = (
    *("benchmarks", "client", "docs", "examples", "launch_profiles", "tests"),
    *("pyproject.toml", "README.md", "robot.db.sql"),
)
"""What is wanted where any part of the tests may be run."""
KEPT = {
    "the simulated robots": robots.KEPT,
    "the service": service.KEPT,
    "the first start": first_start.KEPT,
    "two machines": network.KEPT,
}
KERNEL = "tests/kernel"
BATTERY, OTHERS = "battery.xml", "tests.xml"
REPORTS = {BATTERY: table.of, OTHERS: table.of_parts}
"""Of tests/kernel test by test, of all others part by part."""
BATTERY_S = 7200.0
PYTEST = "/opt/lbr/bin/python -m pytest -p no:cacheprovider -o faulthandler_timeout=3000 -o junit_family=xunit1 -o junit_duration_report=call --junitxml=/tmp/battery.xml"


def main() -> int:
    parser = argparse.ArgumentParser(
        prog="python -m tests.lab", description=about, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("what", choices=("table", *DONE_BY))
    parser.add_argument(
        "tests",
        nargs="*",
        help="for run: which tests, instead of tests/kernel, in pytest's words; for robots, service and network: scenes with these words; all if left out",
    )
    parser.add_argument("--cuts", type=int, default=50, help="for service: how often its power is cut (50)")
    parser.add_argument("--suite", choices=image.SUITES, default="bookworm", help="Debian's release (bookworm)")
    parser.add_argument("--arch", choices=PROCESSORS, default=HERE, help=f"Debian's name of its processor ({HERE})")
    parser.add_argument("--folder", type=Path, help="where the machine's files are (build/lab/SUITE-ARCH)")
    wanted = parser.parse_intermixed_args()
    wanted.folder = (wanted.folder or FOLDER / f"{wanted.suite}-{wanted.arch}").resolve()
    if wanted.what == "table":
        for name, shown in REPORTS.items():
            if (report := wanted.folder / name).exists():
                print(shown(report.read_text()))
        for name, kept in KEPT.items():
            print(table.of_scenes(name, stage.kept(wanted.folder / kept)))
        return 0
    if why := image.why_not(wanted.arch):
        print(f"no machine here: {why}", file=sys.stderr)
        return 2
    if wanted.what == "network" and not PROCESSORS[wanted.arch].two_lines:
        print(f"no two machines of {wanted.arch}: each would need a second serial line", file=sys.stderr)
        return 2
    return DONE_BY[wanted.what](wanted)


def _build(wanted: argparse.Namespace) -> int:
    began = time.monotonic()
    image.build(wanted.folder, wanted.suite, wanted.arch)
    built = time.monotonic()
    machine = Machine(wanted.folder)
    try:
        machine.start(snapshot=False)
        machine.run("/opt/lbr/bin/lbr service install lbr --power-off && modprobe vhci-hcd")
        machine.monitor(f"savevm {SNAPSHOT}")
    finally:
        machine.cut()
    print(f"built in {built - began:.0f} s, first start {time.monotonic() - built:.0f} s: {wanted.folder}")
    return 0


def _run(wanted: argparse.Namespace) -> int:
    asked = wanted.tests or [KERNEL]
    name = BATTERY if all(one.startswith((KERNEL, "-")) for one in asked) else OTHERS
    machine = Machine(wanted.folder)
    try:
        back_s = machine.start(snapshot=True)
        _send(machine, SENT if name == BATTERY else SENT_FOR_OTHERS)
        began = time.monotonic()
        words = f"cd /opt/lab && {PYTEST} {shlex.join(asked)}"
        done = machine.run(words, check=False, limit_s=BATTERY_S, show=True)
        xml = machine.run("cat /tmp/battery.xml").stdout
    finally:
        machine.cut()
    (wanted.folder / name).write_bytes(xml)
    print(REPORTS[name](xml.decode()))
    print(f"from the snapshot in {back_s:.0f} s, battery in {time.monotonic() - began:.0f} s of this machine's time")
    return done.returncode


def _robots(wanted: argparse.Namespace) -> int:
    machine = Machine(wanted.folder)
    try:
        machine.start(snapshot=True)
        path = wanted.folder / robots.KEPT
        scenes = robots.play(machine, _send, wanted.tests)
        return _told("the simulated robots", scenes, path, stage.kept(path) if wanted.tests else ())
    finally:
        machine.cut()


def _service(wanted: argparse.Namespace) -> int:
    machine = Machine(wanted.folder)
    try:
        machine.start(snapshot=True)
        path = wanted.folder / service.KEPT
        scenes = service.play(machine, _send, wanted.cuts, wanted.tests)
        return _told("the service", scenes, path, stage.kept(path) if wanted.tests else ())
    finally:
        machine.cut()


def _first(wanted: argparse.Namespace) -> int:
    with closing(first_start.play(wanted.folder / "first", wanted.suite, wanted.arch)) as scenes:
        return _told("the first start", scenes, wanted.folder / first_start.KEPT)


def _network(wanted: argparse.Namespace) -> int:
    path = wanted.folder / network.KEPT
    with closing(network.play(wanted.folder, _send, wanted.tests)) as scenes:
        return _told("two machines", scenes, path, stage.kept(path) if wanted.tests else ())


def _told(name: str, scenes: Generator[Scene], path: Path, others: Sequence[Scene] = ()) -> int:
    """Tell of each scene as it ends, and keep them in place of the others' of their names; say whether all came out as promised."""
    began, seen = time.monotonic(), {one.what: one for one in others}
    for one in scenes:
        said = "passed" if one.passed else "FAILED"
        print(f"{time.monotonic() - began:6.0f} s  {said}  {one.what}: {one.seen}", flush=True)
        seen[one.what] = one
        stage.keep(path, [*seen.values()])
    print(table.of_scenes(name, [*seen.values()]))
    return 0 if all(one.passed for one in seen.values()) else 1


def _send(machine: Machine, names: Sequence[str] = SENT) -> None:
    """Put the tests into the machine as they are here, beside the wheel that it has."""
    machine.run("mkdir -p /opt/lab && tar -C /opt/lab -xzf -", data=_packed(names))


def _shell(wanted: argparse.Namespace) -> int:
    machine = Machine(wanted.folder)
    try:
        machine.start(snapshot=True)
        return programs.run([*machine.ssh(), "-t"], check=False).returncode
    finally:
        machine.cut()


def _packed(names: Sequence[str]) -> bytes:
    found = io.BytesIO()
    with tarfile.open(fileobj=found, mode="w:gz", compresslevel=1) as tar:
        for name in names:
            tar.add(ROOT / name, name, filter=lambda one: None if "__pycache__" in one.name else one)
    return found.getvalue()


DONE_BY = {
    "build": _build,
    "run": _run,
    "robots": _robots,
    "service": _service,
    "first": _first,
    "network": _network,
    "shell": _shell,
}

if __name__ == "__main__":
    raise SystemExit(main())
