"""Z1: lines by chance at consoles as people have them, in a pipe and on a terminal."""

import os
import random
import re
import select
import subprocess
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Self

from tests.fuzzing.lines import PROGRAM, line
from tests.fuzzing.mutation import noise
from tests.fuzzing.oracle import Verdict, judge
from tests.support import programs
from tests.support.bench import Bench, bench
from tests.support.clients.terminal import OnTerminal
from tests.support.figures import Results
from tests.support.robot import LBR, environment
from tests.support.trace import Output

TERMINAL_SHARE = 20
LONGEST_S = 8.0
LATE_NS = 150_000_000
ECHO_ONLY = ("UPDATE external_command SET argv = '[\"/bin/echo\"]'",)
_INPUT_ERROR = re.compile(
    r"is not a word of this robot| after '/|; say /|^(power|angle|range|sensor|interval) is |nothing may follow"
    r"|not valid UTF-8|control character|line is too long|has no partner|takes no arguments|makes no valid message"
)
_MENDED: dict[Verdict, bytes] = {"estop": b"reset", "disable": b"enable"}
_PROMPT_SENDS_NO = b"\x03\x04\x1a\x1c"
_DRIVES = re.compile(rb"[fFbB/\t]")


def consoles(results: Results, n: int, dice: random.Random) -> None:
    """Say `n` lines, one in twenty of them on a terminal, and hold every answer against the model."""
    with bench(results, edits=ECHO_ONLY) as under_test:
        pids = {unit: under_test.pid(unit) for unit in ("motors", "drive", "ranges")}
        _piped(under_test, max(1, n - n // TERMINAL_SHARE), dice)
        _terminal(under_test, n // TERMINAL_SHARE, dice)
        same = {unit: under_test.pid(unit) for unit in pids} == pids
        results.check("Z1", [] if same else ["a process was replaced"])
        errors = (under_test.robot.home / "stderr.txt").read_text(errors="replace")
        results.check("Z1", ["the executive told a traceback"] if "Traceback" in errors else [])


class Piped:
    """`lbr console` with a pipe at each end; every line is followed by lines whose answers mark its end."""

    def __init__(self, home: Path) -> None:
        self._count = 0
        self.popen = programs.start(
            [*LBR, "console"],
            env=environment(home),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
        )
        assert self.popen.stdin is not None
        assert self.popen.stdout is not None
        assert self.popen.stderr is not None
        self._in = self.popen.stdin.fileno()
        self._out, self._err = self.popen.stdout.fileno(), self.popen.stderr.fileno()
        for fd in (self._out, self._err):
            os.set_blocking(fd, False)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        for pipe in (self.popen.stdin, self.popen.stdout, self.popen.stderr):
            assert pipe is not None
            pipe.close()
        self.popen.kill()
        self.popen.wait()

    def say(self, raw: bytes) -> tuple[str, str, float]:
        """Return what a line brought on standard output and standard error, and the milliseconds to the next answer."""
        self._count += 1
        mark = f"'mark{self._count}'".encode()
        began = time.monotonic()
        rest = memoryview(raw + b"\ns\n/report/" + mark.strip(b"'") + b"\n")
        while rest:
            rest = rest[os.write(self._in, rest) :]
        said = {self._out: b"", self._err: b""}
        while mark not in said[self._err] or not said[self._err].endswith(b"\n"):
            ready, _, _ = select.select(list(said), [], [], LONGEST_S)
            if not ready or self.popen.poll() is not None:
                raise AssertionError(f"no answer to {raw!r}: {said[self._err][-300:]!r}")
            for fd in ready:
                said[fd] += os.read(fd, 65536)
        took_ms = (time.monotonic() - began) * 1e3
        while select.select([self._out], [], [], 0)[0]:
            said[self._out] += os.read(self._out, 65536)
        out, err = (text.decode(errors="replace").splitlines()[:-1] for text in said.values())
        return "\n".join(out), "\n".join(err), took_ms


def _piped(under_test: Bench, n: int, dice: random.Random) -> None:
    results, trace = under_test.results, under_test.trace
    explained = Explained()
    with Piped(under_test.robot.home) as console:
        console.say(b"status")
        for _ in range(n):
            raw = line(dice)
            verdict = judge(raw, (PROGRAM,), piped=True)
            if verdict in ("shutdown", "upset"):
                continue
            began_ns = time.monotonic_ns()
            out, err, took_ms = console.say(raw)
            explained.add(verdict, began_ns)
            if verdict in _MENDED:
                console.say(_MENDED[verdict])
            wrong = _disagrees(verdict, out, err)
            results.check("Z1", [f"{raw[:200]!r} is {verdict}: {wrong}"] if wrong else [])
            results.sample("Z1 answer", took_ms)
            if len(trace.entries) > 100_000:
                trace.entries.clear()
            trace.read()
            results.of("Z1").violations += explained.unexplained(trace.outputs(began_ns))
    results.check("Z1", [] if console.popen.returncode in (0, -9) else ["the console died"])


def _disagrees(verdict: Verdict, out: str, err: str) -> str:
    text = out + err
    if "Traceback" in text:
        return f"a traceback: {text[-200:]}"
    if verdict == "silent":
        return f"it was answered: {text[:200]!r}" if text else ""
    if verdict == "rejected":
        if out:
            return f"it was taken: {out[:200]!r}"
        return "" if len(err.splitlines()) == 1 else f"it takes {len(err.splitlines())} lines to say no: {err[:200]!r}"
    refused = next((line for line in err.splitlines() if _INPUT_ERROR.search(line)), "")
    return f"it was rejected: {refused!r}" if refused else "" if text else "it was not answered"


class Explained:
    """When outputs may have turned: from a line that moves until shortly after the next one was answered."""

    def __init__(self) -> None:
        self._since_ns = self._until_ns = 0

    def add(self, verdict: Verdict, began_ns: int) -> None:
        """Take in a line that was said at `began_ns` and stopped now."""
        if verdict == "moves":
            self._since_ns, self._until_ns = began_ns, time.monotonic_ns() + LATE_NS

    def unexplained(self, outputs: Sequence[Output]) -> list[str]:
        """Return what turned outside."""
        return [
            f"outputs {entry.left:g} {entry.right:g} at {entry.at_ns}, and nobody drove"
            for entry in outputs
            if not entry.zero and not self._since_ns <= entry.at_ns <= self._until_ns
        ]


def _terminal(under_test: Bench, n: int, dice: random.Random) -> None:
    """Type lines and raw bytes; what drives without a word of acceptance on the screen nobody explains."""
    results = under_test.results
    terminal = OnTerminal(under_test.robot.home, [*LBR, "console"])
    try:
        terminal.wait_for(b"Robot>")
        for number in range(n):
            typed = line(dice) if number % 2 else noise(dice, 200)
            typed = typed.translate(None, _PROMPT_SENDS_NO)
            terminal.type(_DRIVES.sub(b"", typed)[:400] + b"\r")
            if number % 20 == 19:
                _still_answers(terminal, results, number)
        moved = [entry for entry in under_test.trace.read() if not getattr(entry, "zero", True)]
        results.check("Z1", ["it drove, and nobody said so"] if moved else [])
    finally:
        terminal.end()


def _still_answers(terminal: OnTerminal, results: Results, number: int) -> None:
    start = len(terminal.said)
    mark = f"term{number}x".encode()
    terminal.type(b"\x1b[201~\x07\x07\x05\x15/report/" + mark + b"\r")
    try:
        terminal.wait_for(b"there is no report '" + mark[:4], start=start)
        wrong = ["a traceback on the terminal"] if terminal.said.find(b"Traceback", start) >= 0 else []
    except AssertionError as err:
        wrong = [str(err)]
    results.check("Z1", wrong)
    results.of("Z1").checks += 19
