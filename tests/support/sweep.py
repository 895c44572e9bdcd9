"""A place of its own for each process that runs tests, and what takes it away when that process is gone.

In the place are the home, all temporary files, and a list of the network namespaces that were made. What is started
bears its name in the environment. As a program, `sweep.py PLACE`, this waits until standard input closes, then sweeps:
so whatever ends a test process, nothing of it is left. It needs nothing but the standard library.
"""

import fcntl
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from contextlib import suppress
from pathlib import Path

MARK = "LBR_TESTS_IN"
PREFIX = "lbr-t"
NAMESPACES = "namespaces"
IN_USE = "in-use"
FOREIGN = ("LBR_HOME", "LBR_TOKEN", "LBR_ROBOT")
KERNEL_S = 2.0
"""What a dead process has started is given this long to end by itself, as it should; then it is killed."""
KILL_S = 5.0
XDG = {"CACHE": ".cache", "CONFIG": ".config", "DATA": ".local/share", "STATE": ".local/state"}


def enter() -> Path:
    """Make a place for this process, have it swept when the process is gone, and point the environment there."""
    everybody = Path(os.environ.get("PYTEST_DEBUG_TEMPROOT") or tempfile.gettempdir())
    for place in everybody.glob(f"{PREFIX}*"):
        if _forsaken(place):
            sweep(place)
    place = Path(tempfile.mkdtemp(prefix=PREFIX, dir=everybody))
    place.chmod(0o711)  # tests with a second user have folders in it that he may enter
    lock = os.open(place / IN_USE, os.O_WRONLY | os.O_CREAT | os.O_CLOEXEC, 0o600)  # until this process is gone
    fcntl.flock(lock, fcntl.LOCK_EX)
    _start_sweeper(place)
    (place / "home").mkdir()
    os.environ |= {
        "PYTEST_DEBUG_TEMPROOT": str(everybody),  # pytest keeps the folders of the last runs there, to look into
        MARK: str(place),
        "HOME": str(place / "home"),
        "TMPDIR": str(place),
        **{f"XDG_{name}_HOME": str(place / "home" / folder) for name, folder in XDG.items()},
    }
    for name in FOREIGN:
        os.environ.pop(name, None)
    tempfile.tempdir = None
    return place


def _start_sweeper(place: Path) -> None:
    """Start the sweeper, whose input ends with this process; no object is left that would complain of it at the end."""
    read_end, _ = os.pipe()
    os.posix_spawn(
        sys.executable,
        [sys.executable, "-I", "-S", __file__, str(place)],
        {name: value for name, value in os.environ.items() if name != MARK},
        file_actions=[
            (os.POSIX_SPAWN_DUP2, read_end, 0),
            (os.POSIX_SPAWN_OPEN, 1, os.devnull, os.O_WRONLY, 0),
            (os.POSIX_SPAWN_DUP2, 1, 2),
        ],
        setsid=True,
    )
    os.close(read_end)


def processes(place: Path) -> dict[int, str]:
    """Return what still runs of what was started in a place: command lines by process, this one excepted."""
    found = {}
    mark = f"{MARK}={place}".encode()
    for entry in Path("/proc").iterdir():
        if entry.name.isdecimal() and int(entry.name) != os.getpid():
            with suppress(OSError):  # it has just ended, or is somebody else's
                if mark in (entry / "environ").read_bytes().split(b"\0"):
                    words = (entry / "cmdline").read_bytes().split(b"\0")
                    found[int(entry.name)] = b" ".join(words).decode(errors="replace").strip()
    return found


def ended(place: Path, limit_s: float) -> dict[int, str]:
    """Wait until nothing runs any more; return what still does."""
    end = time.monotonic() + limit_s
    while (left := processes(place)) and time.monotonic() < end:
        time.sleep(0.02)
    return left


def kill(place: Path) -> None:
    """Kill all that runs in a place."""
    end = time.monotonic() + KILL_S
    while (left := processes(place)) and time.monotonic() < end:
        for pid in left:
            with suppress(OSError):
                os.kill(pid, signal.SIGKILL)
        time.sleep(0.02)


def sweep(place: Path) -> None:
    """Take away all that is left of a place."""
    kill(place)
    with suppress(OSError):
        for name in (place / NAMESPACES).read_text().split():
            subprocess.run(["ip", "netns", "delete", name], capture_output=True, check=False)
    for mounted in _mounts(place):
        subprocess.run(["umount", "-l", mounted], capture_output=True, check=False)
    shutil.rmtree(place, ignore_errors=True)


def note_namespace(name: str) -> None:
    """Have a network namespace deleted when this process is gone."""
    if place := os.environ.get(MARK):
        with (Path(place) / NAMESPACES).open("a") as file:
            file.write(f"{name}\n")


def _mounts(place: Path) -> list[str]:
    paths = [line.split()[1] for line in Path("/proc/mounts").read_text().splitlines()]
    return [path for path in reversed(paths) if path.startswith(f"{place}/")]


def _forsaken(place: Path) -> bool:
    """Say whether the process of a place is gone; one that is being made is left alone."""
    try:
        with (place / IN_USE).open() as file:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return False
    return True


def main() -> None:
    """Wait for the end of the process that started this, then sweep."""
    place = Path(sys.argv[1])
    os.chdir("/")
    sys.stdin.buffer.read()
    ended(place, KERNEL_S)
    sweep(place)


if __name__ == "__main__":
    main()
