"""E2 and E6: the emergency stop's latch over deaths, restarts and an older database, and a stop without an executive."""

import shutil
import sqlite3
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager, suppress
from pathlib import Path

import msgspec

from lbr.bus import session
from lbr.bus.session import Session
from tests.scenarios.freezes import break_links
from tests.scenarios.kills import wait_until_gone
from tests.support.bench import Bench, bench, let_go
from tests.support.figures import Results
from tests.support.mover import RENEW_S
from tests.support.robot import start
from tests.support.waiting import HANG_S

COMMAND = msgspec.json.encode({"power": 0.4, "angle_deg": 90.0})
MOVERS = ("motors", "drive")
WATCHED_S = 0.3
BEFORE = "before.db"


def processes_killed(under_test: Bench) -> None:
    """Every capability's process in turn, the movers last."""
    with _latched(under_test):
        for name in ("world", "ranges", *MOVERS):
            pid = under_test.pid(name)
            under_test.ready_again(name, pid, under_test.kill(pid))
        under_test.all_ready()
    for name in MOVERS:
        under_test.forget_deaths(name)


def executive_killed(under_test: Bench) -> None:
    """The executive, and everything with it; then a new start."""
    with _latched(under_test):
        fault_ns = under_test.kill(under_test.robot.popen.pid)
        wait_until_gone(under_test, fault_ns, 2.0)
        _start_anew(under_test)


def database_restored(under_test: Bench) -> None:
    """A full restart, with the database as it was before anybody pressed."""
    home = under_test.robot.home
    with closing(sqlite3.connect(home / "robot.db")) as database, closing(sqlite3.connect(home / BEFORE)) as copy:
        database.backup(copy)
    with _latched(under_test):
        let_go(under_test.robot)
        for part in ("-wal", "-shm"):
            (home / f"robot.db{part}").unlink(missing_ok=True)
        shutil.move(home / BEFORE, home / "robot.db")
        _start_anew(under_test)


def links_lost(under_test: Bench) -> None:
    """Every link of the router."""
    with _latched(under_test):
        break_links(under_test.robot.popen.pid)
        under_test.reached()
        under_test.all_ready()


WAYS: tuple[Callable[[Bench], None], ...] = (processes_killed, executive_killed, database_restored, links_lost)


def without_executive(results: Results) -> None:
    """E6: the executive dies as somebody presses; what is left stops by itself."""
    with bench(results) as under_test:
        mover = under_test.drive()
        fault_ns = under_test.kill(under_test.robot.popen.pid)
        with suppress(Exception):
            under_test.robot.put("@estop", {"engaged": True, "reason": "E6"})
        zero = under_test.stopped_after("E6 dead", fault_ns)
        mover.cease()
        under_test.stays_at_rest(zero)
        under_test.robot.popen.wait(HANG_S)


def last_stops(results: Results, n: int) -> None:
    """E6, as far as no disk is needed."""
    for _ in range(n):
        without_executive(results)


@contextmanager
def insisting(under_test: Bench) -> Iterator[None]:
    """Command a motion at 10 Hz without any lease, over restarts of the robot too."""
    over = threading.Event()
    endpoints, key = under_test.robot.endpoints, f"{under_test.robot.name}/drive/command"

    def insist() -> None:
        bus: Session | None = None
        while not over.wait(RENEW_S):
            with suppress(Exception):  # the robot may be away
                bus = bus or session.open_client(endpoints, timeout_s=0.2)
                bus.put(key, COMMAND)
        if bus is not None:
            bus.close()

    thread = threading.Thread(target=insist, daemon=True)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()


@contextmanager
def _latched(under_test: Bench) -> Iterator[None]:
    """Press, let something happen under a sender that insists, and look whether it holds; then release it."""
    said = under_test.robot.line("estop")
    assert said["code"] == 0, said
    under_test.trace.read()
    since_ns = time.monotonic_ns()
    with insisting(under_test):
        yield
        under_test.pass_time(WATCHED_S)
    state = under_test.answer("@estop")
    under_test.trace.read()
    moved = [entry for entry in under_test.trace.outputs(since_ns) if not entry.zero]
    wrong = [] if state["engaged"] else [f"the latch is gone: {state}"]
    wrong += [f"a latched robot moved: {moved[0]}"] if moved else []
    under_test.results.check("E2", wrong)
    _released(under_test)


def _released(under_test: Bench) -> None:
    under_test.release()
    under_test.all_ready()
    under_test.pass_time(WATCHED_S)


def _start_anew(under_test: Bench) -> None:
    gone = under_test.robot
    let_go(gone)
    under_test.robot = start(Path(gone.home))
