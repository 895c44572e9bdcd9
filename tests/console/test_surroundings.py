"""What a shell may give a command that is too little: each is one sentence and an exit code, never a traceback."""

import os
import platform
import resource
import subprocess
import sys

import pytest

from lbr import home, surroundings
from lbr.bus import session
from lbr.errors import BusError, InputError
from tests.support import programs
from tests.support import robot as robots
from tests.support.waiting import HANG_S, until

LBR = f"{sys.executable} -m lbr.start"


@pytest.fixture
def shell(tmp_path):
    """Run a line of a shell in which `lbr` is the command, and return its code and what it complained of."""

    def run(line: str, **variables: str) -> tuple[int, list[str]]:
        environment = os.environ | {"LBR_HOME": str(tmp_path / "home")} | variables
        done = programs.run(
            ["bash", "-c", f'lbr() {{ {LBR} "$@"; }}; {line}'],
            env={name: value for name, value in environment.items() if value},
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=HANG_S,
            check=False,
        )  # fmt: skip
        return done.returncode, done.stderr.splitlines()

    return run


@pytest.mark.parametrize(
    ("line", "code"),
    [
        ("lbr run", 2),
        ("lbr run <&-", 2),
        (": | lbr run", 2),
        ("sleep 1 | lbr run >&-", 2),
        ("lbr --help >/dev/full", 1),
        ("lbr doctor >/dev/full", 1),
        ("lbr --version >&-", 1),
        ("lbr db init && lbr db check >&-", 1),
        ("ulimit -n 40; lbr status", 2),
        ("ulimit -n 100; lbr run --no-console", 2),
        ("ulimit -f 100; lbr run --no-console", 2),
        ("ulimit -f 100; lbr db init", 2),
        (
            "HOME=/dev/null LBR_HOME= lbr run --no-console",
            2,
        ),
        ("LBR_HOME=/dev/null lbr token list", 2),
    ],
)
def test_too_little_is_one_sentence_and_a_code(shell, line, code, wording):
    got, complaints = shell(line)
    assert (got, len(complaints)) == (code, 1)
    assert complaints[0].startswith("lbr: ")
    wording(complaints[0])


def test_a_home_that_cannot_be_made_is_named(shell):
    code, (complaint,) = shell("HOME=/proc LBR_HOME= lbr run --no-console")
    assert (code, complaint.startswith("lbr: /proc/.lbr ")) == (2, True)


def test_soft_limits_are_no_obstacle(shell):
    assert shell("ulimit -Sn 40; ulimit -Sf 10; lbr db init") == (0, [])


def test_what_prints_nothing_needs_no_output():
    code = "from lbr import surroundings as s; s.plug_streams(); exit(bool(s.output_failure()))"
    line = f"{sys.executable} -c '{code}' >&- <&- 2>&-"
    assert programs.run(["bash", "-c", line], timeout=HANG_S, check=False).returncode == 0


@pytest.mark.parametrize(
    ("line", "code"),
    [
        ("lbr status 2>&-", 1),
        ("lbr status --robot 2>&-", 2),
        ("lbr db init >/dev/null <&- 2>&-", 0),
        ("lbr --help >&- 2>&-", 1),
    ],
)
def test_what_is_complained_to_nobody_changes_no_exit_code(shell, line, code):
    assert shell(line) == (code, [])


def test_nobody_knows_the_home(monkeypatch):
    monkeypatch.delenv("LBR_HOME", raising=False)
    monkeypatch.setattr("pathlib.Path.home", lambda: (_ for _ in ()).throw(RuntimeError("no home")))
    with pytest.raises(InputError, match="set HOME, or LBR_HOME"):
        home.home()


@pytest.mark.parametrize(("number", "said"), [(24, "ulimit -n"), (27, "ulimit -f"), (28, "no room"), (13, "a right")])
def test_errors_of_the_surroundings_say_what_to_do(number, said):
    text = surroundings.explained(OSError(number, os.strerror(number), "/some/file"))
    assert text.startswith("/some/file: ")
    assert said in text.replace("the right", "a right")


def test_other_errors_are_faults_and_stay_loud():
    assert surroundings.explained(OSError(5, "Input/output error")) == ""


HEAPS = """
import ctypes, threading
from lbr import surroundings
libc = ctypes.CDLL(None)
libc.fopen.restype, libc.malloc.restype = ctypes.c_void_p, ctypes.c_void_p
libc.fflush.argtypes = [ctypes.c_void_p]
if {bound}:
    surroundings.bound_heaps()
together = threading.Barrier(6)
def allocate():
    together.wait()
    libc.malloc(1000)
    together.wait()
threads = [threading.Thread(target=allocate) for _ in range(6)]
for thread in threads: thread.start()
for thread in threads: thread.join()
out = ctypes.c_void_p(libc.fopen(b"{path}", b"w"))
libc.malloc_info(0, out)
libc.fflush(out)
"""


def heaps(path, *, bound):
    """Return how many heaps six threads at once have made."""
    programs.run([sys.executable, "-c", HEAPS.format(path=path, bound=bound)], check=True, timeout=HANG_S)
    return path.read_text().count("<heap nr=")


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="only glibc has heaps to count")
def test_threads_of_a_process_that_routes_share_a_few_heaps(tmp_path):
    assert heaps(tmp_path / "bound", bound=True) <= surroundings.HEAPS < heaps(tmp_path / "free", bound=False)


def test_limits_are_not_lowered():
    before = resource.getrlimit(resource.RLIMIT_NOFILE)
    surroundings.lift_limits()
    after = resource.getrlimit(resource.RLIMIT_NOFILE)
    assert after[1] == before[1]
    assert after[0] < 0 or after[0] >= before[0]


def test_a_robot_with_nowhere_to_print_runs_and_tells_of_it(tmp_path):
    home = robots.prepare(tmp_path / "h")
    closed = ["bash", "-c", 'exec "$@" <&- >&-', "bash", *robots.LBR, "run", "--no-console"]
    popen = programs.start(closed, env=robots.environment(home))
    try:
        until(lambda: "cannot be printed" in robots.lbr(home, "send", "/report/events").stdout)
    finally:
        popen.terminate()
        assert popen.wait(HANG_S) == 0


def test_a_user_who_may_start_too_few_threads_for_a_robot_reads_the_limit_and_root_has_none(monkeypatch):
    limits = {resource.RLIMIT_NPROC: (12, 12)}
    monkeypatch.setattr(surroundings.resource, "getrlimit", lambda which: limits.get(which, (-1, -1)))
    monkeypatch.setattr(surroundings.os, "geteuid", lambda: 0)
    surroundings.need_room_for_a_robot()
    monkeypatch.setattr(surroundings.os, "geteuid", lambda: 1000)
    with pytest.raises(InputError, match="ulimit -u"):
        surroundings.need_room_for_a_robot()


def test_a_bus_library_that_may_start_no_threads_is_a_bus_error(monkeypatch):
    def panics(_config):
        raise type(session.PANIC, (BaseException,), {})("OS can't spawn worker thread")

    monkeypatch.setattr(session.zenoh, "open", panics)
    with pytest.raises(BusError, match="OS can't spawn worker thread"):
        session.open_client(["unixsock-stream//tmp/none.sock"])
