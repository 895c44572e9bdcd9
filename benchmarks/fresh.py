"""Measures a newcomer's first minutes: README's commands on minimal Debian machines, repeatedly. `python -m benchmarks
fresh --n 10 --release bookworm trixie`, as root with mmdebstrap. Each start has a Debian of its own, with only the base
system and `python3-venv`. An ordinary user types README's commands there, makes the robot turn, and ends it. Wheels are
fetched once and kept for later starts. `--arch arm64` does it on an emulated processor (qemu-user-static). `--tests`
runs README's test command as well, with these words after it: `--tests "tests/messages tests/operations"`."""

import argparse
import os
import re
import shutil
import sys
import tempfile
import time
from pathlib import Path

from benchmarks import FOLDER, Measured
from lbr.errors import InputError
from tests.support import programs
from tests.support.figures import Promise, Results

SMOKE = "--n 0"
CHECKOUT = FOLDER.parent
LINES = ("status", "/r/0.3/90", "stop", "Shutdown")
ANSWERS = ("no emergency stop", "accepted", "stopped", "shutting down")
"""The expected parts of the lines, in this order."""
SIZE = "find .venv/lib -type f ! -name '*.pyc' ! -path '*/site-packages/pip*' -printf '%s\\n' | awk '{n += $1} END {print int(n / 1e6)}'"
"""The size of its environment in MB, without Python's compiled files, and without pip, which every environment has."""
LONGEST_S = 1800.0
HERE = {"x86_64": "amd64", "aarch64": "arm64"}.get(os.uname().machine, os.uname().machine)
PROMISES = {
    "FM": Promise(what="README's run command on a fresh machine: the robot turns when told, and ends in order"),
    "FM ready": Promise(
        what="README's run command on a fresh machine, to a robot that has been told to turn", unit="s"
    ),
    "FM first": Promise(what="the same where the wheels are fetched as well", unit="s"),
    "FM tests": Promise(what="README's test command there, or the part of the tests that was named"),
    "FM size": Promise(what="what `.[sim]` installs beside pip, without what Python compiles", unit="MB", target=280.0),
}
INSIDE = """
set -eu
mount -t overlay overlay -o lowerdir="$BASE",upperdir="$PLACE/up",workdir="$PLACE/work" "$PLACE/root"
mount --bind "$CACHE" "$PLACE/root/home/owner/.cache"
mount -t proc proc "$PLACE/root/proc"
mount --rbind /dev "$PLACE/root/dev"
mount -t tmpfs tmpfs "$PLACE/root/tmp"
cd /
exec chroot --userspec=owner:owner "$PLACE/root" /usr/bin/env HOME=/home/owner PATH=/usr/bin:/bin sh -c 'cd ~/lbr; exec bash -c "$0"' "$COMMAND"
"""
"""The beginning of a start: the base stays as it is, and all mounts end with the process."""


def options(parser: argparse.ArgumentParser) -> None:
    """Add the machines, and the number."""
    parser.add_argument("--n", type=int, default=10, help="starts of each release (default %(default)s)")
    parser.add_argument("--release", nargs="+", default=["bookworm", "trixie"], help="Debian's names (default both)")
    parser.add_argument("--arch", default=HERE, help="Debian's name of the processor (default %(default)s)")
    parser.add_argument("--tests", metavar="WORDS", help="run the test command once for each release, with these words")


def measure(given: argparse.Namespace) -> Measured:
    """Make a machine of each release, and start on it repeatedly."""
    results, told = Results(PROMISES), []
    if given.n and (os.geteuid() != 0 or shutil.which("mmdebstrap") is None):
        raise InputError("fresh machines need root and mmdebstrap (sudo apt install mmdebstrap)", "not_possible")
    for release in given.release if given.n else ():
        with tempfile.TemporaryDirectory(prefix="lbr-fresh-") as place:
            told += _release(results, Path(place), release, given)
    for name in ("run-command", "test-command"):
        results.check("FM", [] if "pip install" in command(name) else [f"README has no {name}"])
    return Measured(results=results.ordered(), text="\n".join(told))


def command(marker: str) -> str:
    """Return the command after a marker of README's and its opening fence."""
    found = re.search(rf"<!-- {marker} -->\n```sh\n(.*)\n", (CHECKOUT / "README.md").read_text())
    assert found is not None, marker
    return found[1]


def _release(results: Results, place: Path, release: str, given: argparse.Namespace) -> list[str]:
    base, cache = place / "base", place / "cache"
    _debian(base, release, given.arch)
    cache.mkdir()
    shutil.chown(cache, 1000, 1000)
    told = []
    for number in range(given.n):
        wrong, took_s, megabytes, python = _start(base, cache, place / f"start-{number}")
        results.check("FM", wrong)
        if not wrong:
            results.sample("FM ready" if number else "FM first", took_s)
            results.sample("FM size", megabytes)
        told.append(
            f"{release} {given.arch}, {python}: {'; '.join(wrong) or 'it turned'} after {took_s:.0f} s, {megabytes:.0f} MB"
        )
        print(told[-1], file=sys.stderr, flush=True)
    if given.tests is not None:
        words = f"{command('test-command')} {given.tests}"
        said = _inside(base, cache, place / "tests", words, "")[0]
        told.append(f"{release} {given.arch}: {said.strip().splitlines()[-1]}")
        results.check("FM tests", [] if re.search(r"^\d+ passed", said, re.MULTILINE) else [said[-2000:]])
    return told


def _debian(base: Path, release: str, arch: str) -> None:
    """Make a Debian with its base system, README's requirements, and an ordinary user with a checkout."""
    words = ["mmdebstrap", "--quiet", "--variant=minbase", f"--architectures={arch}"]
    words += ['--aptopt=Acquire::Check-Valid-Until "false"']  # a mirror of a future release may be some weeks old
    words += ["--include=ca-certificates,python3,python3-venv", release, str(base)]
    programs.run(words, check=True)
    programs.run(["chroot", str(base), "useradd", "--create-home", "--uid", "1000", "owner"], check=True)
    home = base / "home/owner"
    (home / "lbr").mkdir()
    (home / ".cache").mkdir()
    tracked = programs.run(["git", "ls-files", "-z"], cwd=CHECKOUT, check=True, capture_output=True).stdout
    programs.run(
        ["cp", "--parents", "-t", str(home / "lbr"), *tracked.decode().rstrip("\0").split("\0")],
        cwd=CHECKOUT,
        check=True,
    )
    programs.run(["chown", "-R", "1000:1000", str(home)], check=True)
    for name in ("/etc/resolv.conf", "/etc/ssl/certs/ca-certificates.crt"):
        shutil.copyfile(name, f"{base}{name}")


def _start(base: Path, cache: Path, place: Path) -> tuple[list[str], float, float, str]:
    """Type README's run command and some lines; return the answers and the times."""
    lines = "".join(f"{line}\n" for line in LINES)
    said, times = _inside(base, cache, place, f"{command('run-command')} && {{ {SIZE}; .venv/bin/python -V; }}", lines)
    wrong, at = [], 0
    for answer in ANSWERS:
        at = said.find(answer, at)
        if at < 0:
            wrong.append(f"no '{answer}' in: {said[-2000:]}")
            break
    took_s = next((at for line, at in times if line.startswith("accepted")), 0.0)
    last = said.strip().splitlines()[-2:]
    megabytes = float(last[0]) if not wrong and last[0].isdecimal() else 0.0
    return wrong, took_s, megabytes, last[-1] if last else ""


def _inside(base: Path, cache: Path, place: Path, words: str, typed: str) -> tuple[str, list[tuple[str, float]]]:
    """Run a command as the owner of a separate machine; return its output, and the time of each line."""
    for name in ("up", "work", "root"):
        (place / name).mkdir(parents=True)
    environment = dict(os.environ) | {"BASE": str(base), "CACHE": str(cache), "PLACE": str(place), "COMMAND": words}
    argv = [
        "timeout",
        "--kill-after=10",
        str(LONGEST_S),
        "unshare",
        "--mount",
        "--pid",
        "--fork",
        "--kill-child",
        "sh",
        "-c",
        INSIDE,
    ]
    began, times = time.monotonic(), []
    with programs.start(argv, env=environment, stdin=-1, stdout=-1, stderr=-2, text=True) as program:
        assert program.stdin is not None
        assert program.stdout is not None
        program.stdin.write(typed)
        program.stdin.close()
        times = [(line, time.monotonic() - began) for line in program.stdout]
    shutil.rmtree(place, ignore_errors=True)
    return "".join(line for line, _ in times), times
