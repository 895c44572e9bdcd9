"""An emulated servo bus in a process of its own, and clients that take turns on it."""

import importlib.util
import json
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

from tests.support import programs

SERVOS = 18
FLOOR = Path(__file__).with_name("floor.c")


class Process:
    """A process that answers each line with a line of JSON."""

    def __init__(self, *argv: str) -> None:
        self._popen = programs.start(argv, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.answer()

    def tell(self, line: str) -> None:
        """Give it a line."""
        assert self._popen.stdin is not None
        self._popen.stdin.write(line + "\n")
        self._popen.stdin.flush()

    def answer(self) -> dict[str, Any]:
        """Wait for its line."""
        assert self._popen.stdout is not None
        line = self._popen.stdout.readline()
        if not line:
            raise SystemExit(f"{' '.join(map(str, self._popen.args))} ended")  # type: ignore[arg-type]
        found: dict[str, Any] = json.loads(line)
        return found

    def close(self) -> None:
        """End it."""
        self._popen.communicate()


class Line:
    """The emulated bus, and clients that take turns on it."""

    def __init__(self, folder: Path, stack: ExitStack) -> None:
        self.path = str(folder / "bus")
        self._stack = stack
        self._twin = self._start("tests.support.servo_bus.twin", self.path)
        self._clients: dict[str, Process] = {}
        self._floor = compiled(folder)

    @property
    def kinds(self) -> list[str]:
        """Who can take part here."""
        known = {"floor": self._floor is not None, "block": True}
        sdk = importlib.util.find_spec("dynamixel_sdk") is not None
        return [kind for kind, here in {**known, "vendor_three": sdk, "vendor_block": sdk}.items() if here]

    def set(self, **order: Any) -> None:
        """Make the bus again, or with `faults` alone change those."""
        self._twin.tell(json.dumps(order))
        self._twin.answer()

    def start(self, kind: str, seconds: float) -> Process:
        """Let a client begin; its answer comes when it is done."""
        if kind not in self._clients:
            self._clients[kind] = self._start("tests.support.servo_bus.client", kind, self.path, str(SERVOS))
        self._clients[kind].tell(str(seconds))
        return self._clients[kind]

    def run(self, kind: str, seconds: float) -> dict[str, Any]:
        """Let a client read for a while."""
        if kind != "floor":
            return self.start(kind, seconds).answer()
        argv = [str(self._floor), self.path, str(seconds), str(SERVOS)]
        found: dict[str, Any] = json.loads(programs.run(argv, check=True, capture_output=True).stdout)
        return found

    def _start(self, *module_and_arguments: str) -> Process:
        process = Process(sys.executable, "-m", *module_and_arguments)
        self._stack.callback(process.close)
        return process


@contextmanager
def line() -> Iterator[Line]:
    """Start the emulated bus; end it, and all clients, at the end."""
    with tempfile.TemporaryDirectory() as folder, ExitStack() as stack:
        yield Line(Path(folder), stack)


def compiled(folder: Path) -> Path | None:
    """Return the floor's program, None without a compiler."""
    compiler = shutil.which("cc")
    if compiler is None:
        return None
    program = folder / "floor"
    programs.run([compiler, "-O2", "-Wall", "-Wextra", "-o", str(program), str(FLOOR)], check=True)
    return program
