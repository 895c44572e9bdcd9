"""A whole robot for a test: `lbr run` in a home of its own, and a client on its bus."""

import json
import select
import signal
import sqlite3
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import ExitStack, closing, contextmanager
from os import environ
from pathlib import Path
from typing import Any

from lbr.bus import keys, session, wire
from lbr.bus.access import TOOLS, Credentials
from lbr.capability.die_with_parent import dying_with_parent
from lbr.database import store

READY_S = 30.0
"""A start takes two seconds, and up to ten times as long on a busy machine."""
ENDS_S = 8.0
ANSWER_S = 10.0
RENEWED_S = 0.1
"""Ten times a second, like a console."""
LEASE_S = 1.0
"""The longest permitted lifetime of a lease."""


class NoAnswerError(AssertionError):
    """A line without an answer in time, which may have been carried out all the same."""


class Robot:
    """A running robot: `say` sends a console line with all rights, `ask` a question on its bus."""

    def __init__(self, home: Path, popen: "subprocess.Popen[str]", ready: dict[str, Any]) -> None:
        self.home = home
        self.popen = popen
        self.ready = ready
        self.name: str = ready["robot"]
        self.endpoints: list[str] = ready["endpoints"]
        self.bus = session.open_client(self.endpoints)
        self._owner: session.Session | None = None

    def as_owner(self) -> session.Session:
        """Open a session with all rights, as `lbr`'s own commands do."""
        running = json.loads((self.home / "run" / f"{self.name}.json").read_text())
        return session.open_client([running["core"]], Credentials(user=TOOLS, password=running["password"]))

    def ask(self, key: str, message: object = None, *, source: str = "test", timeout_s: float = ANSWER_S) -> Any:
        """Query `<robot>/<key>` and return the decoded answer; None without one."""
        answers = wire.ask(self.bus, f"{self.name}/{key}", message, source=source, timeout_s=timeout_s)
        return json.loads(answers[0].payload) if answers else None

    def answers(self, timeout_s: float) -> bool:
        """Return whether the robot answers on each of this object's sessions; a broken link is restored by itself."""
        sessions = [self.bus, *([self._owner] if self._owner is not None else [])]
        key = f"{self.name}/@status"
        return all(wire.ask(bus, key, None, source="test", timeout_s=timeout_s) for bus in sessions)

    def put(self, key: str, message: Any, *, source: str = "test") -> None:
        """Publish on `<robot>/<key>`."""
        wire.put(self.bus, f"{self.name}/{key}", message, source=source)

    def say(self, text: str, role: str = "admin") -> dict[str, Any]:
        """Send a console line, with all rights like `lbr send`, or with a lower role; return its answer."""
        if self._owner is None and role == "admin":
            self._owner = self.as_owner()
        bus = self._owner if role == "admin" and self._owner is not None else self.bus
        query = bus.get(keys.console(self.name, role), payload=text, timeout=ANSWER_S)
        answer = next((reply.ok for reply in query), None)
        if answer is None:
            raise NoAnswerError(f"no answer to '{text[:40]}' within {ANSWER_S:g} s")
        found: dict[str, Any] = json.loads(answer.payload.to_bytes())
        return found

    def move(self, text: str, within_s: float = 20.0) -> dict[str, Any]:
        """Send a line that moves the robot, and renew its lease like a console until the motion is over; return its
        end.

        The lease has the longest lifetime, as a machine with tests delays its programs. The last refusal of a renewal
        is returned: its `cause` is the code of the end, `done` if the goal was reached.
        """
        hold = self.say(text)["hold"]
        assert hold is not None, f"'{text}' moves nothing"
        key, end = hold["key"].removeprefix(f"{self.name}/"), time.monotonic() + within_s
        while True:
            renewed: dict[str, Any] | None = self.ask(key, {**hold["payload"], "ttl_s": LEASE_S})
            if renewed is None or not renewed["accepted"]:
                return renewed or {"accepted": False, "code": "timeout", "cause": "", "reason": "no answer"}
            assert time.monotonic() < end, f"'{text}' goes on for longer than {within_s:g} s"
            time.sleep(RENEWED_S)

    def close(self) -> int:
        """Shut it down in order, and return its exit code; kill it if it does not end."""
        self.bus.close()
        if self._owner is not None:
            self._owner.close()
        if self.popen.poll() is None:
            self.popen.send_signal(signal.SIGTERM)
        assert self.popen.stdout is not None
        self.popen.stdout.close()
        with ExitStack() as late:  # even when the time of the test is over
            late.callback(_killed, self.popen)
            code = self.popen.wait(ENDS_S)
            late.pop_all()
        return code


def until(condition: Callable[[], object], what: str, within_s: float = 8.0) -> None:
    """Wait until a condition holds, and fail with `what` if that takes too long."""
    end = time.monotonic() + within_s
    while not condition():
        assert time.monotonic() < end, f"not within {within_s:g} s: {what}"
        time.sleep(0.02)


def prepared(home: Path, edits: Iterable[str] = ()) -> Path:
    """Make a home with the shipped rows, changed by SQL statements; servers get any free port."""
    home.mkdir(mode=0o700, parents=True, exist_ok=True)
    store.create(home / "robot.db")
    with closing(sqlite3.connect(home / "robot.db")) as database, database:
        database.execute("UPDATE capability SET settings = json_set(settings, '$.port', 0) WHERE kind = 'web'")
        for edit in edits:
            database.execute(edit)
    return home


@contextmanager
def running(profile: str = "lbr-sim", *, edits: Iterable[str] = (), home: Path | None = None) -> Iterator[Robot]:
    """Run a robot for the time of a `with`, in a new home or in yours; none of its processes outlives that."""
    with tempfile.TemporaryDirectory(prefix="lbr-") as place:  # a short path, because the names of sockets are bounded
        home = prepared(Path(place) / "h", edits) if home is None else home
        argv = (sys.executable, "-m", "lbr.start", "run", profile, "--no-console")
        robot = Robot(home, *started(dying_with_parent(argv), home))
        try:
            yield robot
        finally:
            robot.close()


def started(
    argv: Sequence[str], home: Path, within_s: float = READY_S
) -> "tuple[subprocess.Popen[str], dict[str, Any]]":
    """Start a program that runs a robot in a home, and return it with its ready line; one that is late is killed."""
    errors_file = home / "stderr.txt"
    with errors_file.open("ab") as errors:
        popen = subprocess.Popen(
            argv,
            env=environ | {"LBR_HOME": str(home), "PYTHONUNBUFFERED": "1"},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=errors,
            text=True,
        )
    with ExitStack() as failed:  # even when the time of the test is over
        failed.callback(_killed, popen)
        assert popen.stdout is not None
        end = time.monotonic() + within_s
        while not select.select([popen.stdout], [], [], 0.1)[0]:
            assert time.monotonic() < end, f"not ready within {within_s:g} s: {errors_file.read_text()[-2000:]}"
        line = popen.stdout.readline()
        assert line, f"no ready line: {errors_file.read_text()[-2000:]}"
        failed.pop_all()
    return popen, json.loads(line)


def _killed(popen: "subprocess.Popen[str]") -> None:
    popen.kill()
    popen.wait()
    assert popen.stdout is not None
    popen.stdout.close()
