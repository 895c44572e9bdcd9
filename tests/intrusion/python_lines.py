"""A10: a line that begins with `!` is Python at the robot's own terminal, and nowhere else."""

import contextlib
import json
from collections.abc import Callable, Iterator
from pathlib import Path

from lbr.bus import wire
from lbr.console import target
from lbr.errors import BusError
from lbr.testing.robot import NoAnswerError
from tests.support import programs
from tests.support.bench import bench, temporary_home
from tests.support.clients.terminal import OnTerminal
from tests.support.figures import Results
from tests.support.robot import LBR, Robot, environment, lbr

END_S = 20.0
ROWS = (
    "UPDATE external_command SET argv = '[\"/bin/echo\"]'",
    "INSERT INTO external_command (robot, name, argv, blocking) VALUES ('lbr', 'bang', '[\"{line}\"]', 1)",
    (
        "INSERT INTO verb (robot, word, pattern, target, payload) VALUES ('lbr', 'say', '/say', 'executive.estop',"
        ' \'{{"reason": "{line}"}}\')'
    ),
    "UPDATE verb SET help = '{line}' WHERE word = 'f'",
    "UPDATE robot SET description = '{line}', owner = '{line}'",
    "INSERT INTO phrase (name, language, text) VALUES ('bang', 'en', '{line}')",
)


def python_lines(results: Results) -> None:
    """Try it through every entry; then at the robot's own terminal, where it must work and be written down."""
    with temporary_home() as place:
        canary = place / "canary"
        line = f"!open('{canary}','w')"
        rows = tuple(row.format(line=line.replace("'", "''")) for row in ROWS)
        with bench(results, edits=rows) as under_test:
            for what, attempt in _entries(under_test.robot, line):
                with contextlib.suppress(BusError, StopIteration, NoAnswerError):
                    attempt()
                results.check("A10", [f"{what}: it was executed"] if canary.exists() else [])
                canary.unlink(missing_ok=True)
        _piped_into_the_robot(results, place, line, canary)
        _at_the_terminal(results, place, line, canary)


def _entries(robot: Robot, line: str) -> Iterator[tuple[str, Callable[[], object]]]:
    spellings = (line, f" {line}", f"\t{line}", f"!{line}", json.dumps(line), line.replace("!", "\uff01"))
    for spelt in spellings:
        for key in ("@console", "@console/view", "@console/admin"):
            yield f"{key} at the local door", lambda key=key, spelt=spelt: _say(robot, key, spelt)
        yield "@console/admin as the owner", lambda spelt=spelt: _say_as_owner(robot, spelt)
        yield "lbr send", lambda spelt=spelt: lbr(robot.home, "send", spelt, limit_s=END_S)
    piped = "\n".join(spellings) + "\n"
    yield "lbr console", lambda: lbr(robot.home, "console", stdin=piped, limit_s=END_S)
    yield "a terminal elsewhere", lambda: _typed(robot.home, ["console"], line)
    for words in (
        f"clock {line}",
        "bang",
        f"bang {line}",
        "/say",
        "say",
        "help",
        f"/estop/{line}",
        f"/report/{line}",
        "reset",
    ):
        yield f"the line {words}", lambda words=words: robot.line(words)
    yield "a put", lambda: robot.put("@console", line)
    yield "a reason", lambda: robot.ask("drive/stop", {"reason": line})


def _say(robot: Robot, key: str, line: str) -> object:
    return list(robot.bus.get(f"{robot.name}/{key}", payload=line, timeout=2.0))


def _say_as_owner(robot: Robot, line: str) -> object:
    record = json.loads((robot.home / "run" / f"{robot.name}.json").read_text())
    credentials = target.Credentials(user="@tools", password=record["password"])
    with target.connected(target.Target(robot=robot.name, endpoints=(record["core"],), credentials=credentials)) as bus:
        return wire.ask(bus, f"{robot.name}/@console/admin", line, source="bench")


def _piped_into_the_robot(results: Results, home: Path, line: str, canary: Path) -> None:
    done = lbr(home, "run", "lbr-sim", stdin=f"{line}\n", limit_s=END_S)
    executed = canary.exists()
    canary.unlink(missing_ok=True)
    results.check("A10", [f"a pipe into the robot: it was executed: {done.stdout[-300:]}"] if executed else [])


def _at_the_terminal(results: Results, home: Path, line: str, canary: Path) -> None:
    _typed(home, ["run", "lbr-sim"], line, end="Shutdown")
    audited = programs.run(
        [*LBR, "db", "audit"], env=environment(home), capture_output=True, text=True, check=False, timeout=END_S
    ).stdout
    results.check("A10", [] if canary.exists() else ["the robot's own terminal: it was not executed"])
    results.check(
        "A10", [] if "python" in audited and str(canary) in audited else [f"not in the trail: {audited[-500:]}"]
    )


def _typed(home: Path, words: list[str], line: str, *, end: str = "") -> None:
    terminal = OnTerminal(home, [*LBR, *words])
    try:
        terminal.wait_for(b"Robot>", END_S)
        terminal.type(line.encode() + b"\r")
        terminal.type(b"/report/afterwards\r")
        terminal.wait_for(b"there is no report", END_S)
        if end:
            terminal.type(end.encode() + b"\r")
            terminal.popen.wait(END_S)
    finally:
        terminal.end()
