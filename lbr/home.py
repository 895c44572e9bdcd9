"""`$LBR_HOME` (default `~/.lbr`): database, logs, sockets and the records of running robots."""

import fcntl
import os
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from hashlib import blake2b
from pathlib import Path

import msgspec
from msgspec import Struct

from lbr import disk, ownership
from lbr.errors import AlreadyRunningError, InputError
from lbr.ownership import Fault

LOOKERS_S = 0.1
PUBLIC = ".crt"
"""The suffix of a file below `credentials/` that everybody may read."""
BEGINNING = "beginning"
RUN_VARIABLE = "LBR_RUN"
"""The mark of a running robot in the environment of its processes."""
_lived_in: Path | None = None
_beginning: int | None = None
SOCKET_PATH_LIMIT = 100  # sun_path has 108 bytes, and the bus library adds a suffix for its lock file


class Running(Struct, frozen=True, kw_only=True):
    """A robot that runs on this machine, and its endpoints.

    At `endpoints`, every local user may look and operate. At `core`, users who may read this home have all rights, by
    `password`. `lan` are the endpoints for other machines.
    """

    robot: str
    pid: int
    endpoints: tuple[str, ...]
    profile: str
    database: str
    core: str
    password: str
    lan: tuple[str, ...] = ()


def home() -> Path:
    """Return the home, created for its owner alone if need be, without a check of its owner."""
    path = _place()
    return path if _is_lived_in(path) else _made(path)


def live_in() -> None:
    """Never create this home again: a robot runs from it, which a new one of the same name would hide."""
    global _lived_in  # noqa: PLW0603 - of a process, as LBR_HOME is
    _lived_in = _place()


def _is_lived_in(path: Path) -> bool:
    """Return whether a robot runs from there that contains this process."""
    return path == _lived_in or RUN_VARIABLE in os.environ


def _place() -> Path:
    try:
        return _spoken(Path(os.environ.get("LBR_HOME") or Path.home() / ".lbr").absolute())
    except RuntimeError:  # there is neither HOME nor an account with a home
        raise InputError("it is not known where your home directory is: set HOME, or LBR_HOME") from None
    except FileNotFoundError:  # LBR_HOME is relative
        raise InputError(
            "the folder that you are in is gone, and LBR_HOME is no whole path: go to one that is there"
        ) from None


def _spoken(path: Path) -> Path:
    """Return a folder whose path is valid for the bus and devices: in an endpoint, `#` or `?` ends the path."""
    wrong = next((one for one in str(path) if one in "#?\x7f" or one < " " or "\ud800" <= one <= "\udfff"), "")
    if wrong:
        raise InputError(
            f"{str(path)!r} has {wrong!r} in it, which no socket's address may have: choose another folder"
        )
    return path


def directory(name: str) -> Path:
    """Return a subdirectory of the home, created for its owner alone if need be; InputError if others could change
    it."""
    place = home()
    if _is_lived_in(place) and not place.is_dir():
        raise InputError(f"the robot's home {place} is gone: end the robot, put its home back, and start it again")
    ownership.refuse(ownership.faults(place))
    return _ours(_made(place / name))


def default_database() -> Path:
    """Return the default path of the database."""
    return home() / "robot.db"


def socket_path(robot: str, part: str = "") -> Path:
    """Return a robot's socket: in the home, or in a private temporary directory if the home's path is too long."""
    path = directory("run") / f"{robot}{part}.sock"
    if len(str(path)) <= SOCKET_PATH_LIMIT:
        return path
    mark = blake2b(str(path.parent).encode(), digest_size=6).hexdigest()
    short = _spoken(Path(tempfile.gettempdir())) / f"lbr-{os.getuid()}-{mark}"
    return _ours(_made(short)) / f"{robot}{part}.sock"


def credentials(make: Callable[[], Iterable[bytes]], *names: str) -> tuple[Path, ...]:
    """Return files below `credentials/`; if one is missing all are made, by one process at a time, for the owner alone.

    InputError names a file that others could have read or changed, or that is empty.
    """
    folder = directory("credentials")
    paths = tuple(folder / name for name in names)
    with disk.locked(folder):
        if not all(path.exists() for path in paths):
            for path, content in zip(paths, make(), strict=True):
                disk.write(path, content)
    ownership.refuse(fault for path in paths for fault in key_faults(path))
    return paths


def given_credentials(*names: str) -> tuple[Path, ...]:
    """Return the files that the owner has put below `credentials/`, or an empty tuple.

    InputError names a file that is missing beside the others, or that others could have read or changed.
    """
    paths = tuple(directory("credentials") / name for name in names)
    there = [path for path in paths if path.exists()]
    if there and (missing := [path for path in paths if path not in there]):
        raise InputError(f"{missing[0]} is missing beside {there[0]}: put it there, or remove the other")
    ownership.refuse(fault for path in there for fault in key_faults(path))
    return tuple(there)


def key_faults(path: Path) -> Iterator[Fault]:
    """Yield the faults of a file below `credentials/`: its readers and writers, and that it is empty."""
    yield from ownership.faults(path, secret=path.suffix != PUBLIC)
    with suppress(OSError):
        if path.stat().st_size == 0:
            yield Fault(path=path, text="is empty (0 bytes)", do=f"`rm {path}`, and a new one is made")


def running() -> list[Running]:
    """Return the robots that run here, by name."""
    found = []
    run = _place() / "run"
    if not run.is_dir():
        return []
    ownership.refuse(ownership.faults(run, owners=_owner_of_home()))
    for path in filter(Path.is_file, sorted(run.glob("*.json"))):
        try:
            robot = msgspec.json.decode(path.read_bytes(), type=Running)
        except (OSError, msgspec.DecodeError, UnicodeDecodeError):
            continue
        if disk.is_locked(path.with_suffix(".lock")):
            found.append(robot)
    return found


def begin() -> None:
    """Show that a start is under way here, of a robot with unknown name, until that has its lock."""
    global _beginning  # noqa: PLW0603 - of a process, as its locks are
    _beginning = os.open(directory("run") / BEGINNING, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600)
    fcntl.flock(_beginning, fcntl.LOCK_SH)


def starting() -> list[str]:
    """Return the robots whose start is under way here: they hold their lock, and cannot be reached yet.

    A name that is not known yet is empty.
    """
    run = _place() / "run"
    if not run.is_dir():
        return []
    ownership.refuse(ownership.faults(run, owners=_owner_of_home()))
    begun = [""] if disk.is_locked(run / BEGINNING, shared=True) else []
    locks = (path for path in sorted(run.glob("*.lock")) if not path.with_suffix(".json").exists())
    return begun + [path.stem for path in locks if disk.is_locked(path)]


class RunLock:
    """One `lbr run` per robot and home: held by the kernel for as long as the process lives, however it ends."""

    def __init__(self, robot: str) -> None:
        self._record = directory("run") / f"{robot}.json"
        self._fd = os.open(self._record.with_suffix(".lock"), os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600)
        if not _locked_within(self._fd, LOOKERS_S):
            os.close(self._fd)
            raise AlreadyRunningError(
                f"robot '{robot}' already runs here; 'lbr status' shows it and 'lbr stop' ends it"
            )
        self._record.unlink(missing_ok=True)  # of a run that was killed
        live_in()
        _begun()

    def publish(self, record: Running) -> None:
        """Publish how to reach the robot, readable by the owner alone; raise InputError with the reason if it fails."""
        try:
            disk.write(self._record, msgspec.json.encode(record), synced=False)
        except OSError as err:
            raise InputError(f"{self._record} cannot be written ({err.strerror}): check the disk") from err

    def release(self) -> None:
        """Release the lock."""
        self._record.unlink(missing_ok=True)
        os.close(self._fd)


def _begun() -> None:
    global _beginning
    fd, _beginning = _beginning, None
    if fd is not None:
        os.close(fd)


def _made(path: Path) -> Path:
    try:
        path.mkdir(mode=0o700, parents=True, exist_ok=True)
    except OSError as err:
        raise InputError(f"{path} cannot be made ({err.strerror}); set LBR_HOME to a directory of your own") from err
    return path


def _ours(path: Path) -> Path:
    ownership.refuse(ownership.faults(path))
    return path


def _owner_of_home() -> tuple[int, ...]:
    """Return the other users whose records count: root may look at another user's robots."""
    return (_place().stat().st_uid,) if os.geteuid() == 0 else ()


def _locked_within(fd: int, limit_s: float) -> bool:
    """Acquire the lock; a process that checks whether a robot runs holds it only for an instant."""
    end = time.monotonic() + limit_s
    while True:
        try:
            fcntl.flock(fd, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            if time.monotonic() > end:
                return False
            time.sleep(0.01)
        else:
            return True
