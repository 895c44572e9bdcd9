"""`lbr logs`."""

import os
import time
from collections.abc import Collection, Iterator
from pathlib import Path

import click
from click.shell_completion import CompletionItem

from lbr import home
from lbr.apps.recorder.commands.box import Excerpt
from lbr.apps.recorder.recording import export, times
from lbr.database import glance
from lbr.errors import InputError
from lbr.names import did_you_mean

LOOK_S = 0.2
TAIL_BYTES = 2_000_000
MOST_LINES = 10_000


def complete_log(_context: click.Context, _parameter: click.Parameter, begun: str) -> list[CompletionItem]:
    """Complete the name of a log."""
    there = _names(home.home() / "logs", None)
    found = {*there, *(one for one, log in _sharing() if log in there)}
    return [CompletionItem(name) for name in sorted(found) if name.startswith(begun)]


@click.command("logs")
@click.argument("name", required=False, default="", shell_complete=complete_log)
@click.option("--robot", metavar="NAME", help="Whose; the only one with logs if left out.")
@click.option("-f", "--follow", is_flag=True, help="Go on with what is written, until Ctrl-C.")
@click.option(
    "-n",
    "--lines",
    type=click.IntRange(0, MOST_LINES),
    default=50,
    show_default=True,
    help="How many of the last lines.",
)
@click.option("--from", "begin", metavar="TIME", help="Out of the black box: from 10m (ago), 14:02 ... on.")
@click.option("--to", "end", metavar="TIME", help="Until then; now if left out.")
def command(name: str, robot: str | None, follow: bool, lines: int, begin: str | None, end: str | None) -> int:
    """Print the log of a capability, the executive or an external command; without NAME list the logs.

    A log has what the part has written, and its events between, in order; no robot need run. Events have times, what
    a part writes has them in the black box (--from, --to).
    """
    if begin is not None or end is not None:
        return _recorded(name, robot, begin, end)
    logs = _names(home.home() / "logs", robot)
    if not name:
        if robot is not None and not any(log.startswith(f"{robot}/") for log in logs):
            owners = {log.partition("/")[0] for log in _names(home.home() / "logs", None) if "/" in log}
            raise InputError(f"there is no log of a robot '{robot}'; {did_you_mean(robot, owners)}", "unknown_name")
        for log, path in sorted(logs.items()):
            click.echo(f"{log:<30}  {path.stat().st_size / 1000:8.1f} kB")
        return 0
    chosen = _chosen(name, logs)
    if len(chosen) != 1:
        known = ", ".join(sorted(logs)) or "none"
        raise InputError(
            f"several robots have a log '{name}': say which with --robot NAME"
            if chosen
            else f"there is no log '{name}'; there is {known}",
            "unknown_name",
        )
    path = logs[chosen[0]]
    last, size = _tail(path, lines)
    if not size:
        click.echo(f"the log '{chosen[0]}' is empty", err=True)
    for line in last:
        click.echo(_clean(line))
    if follow:
        for line in _followed(path, size):
            click.echo(_clean(line))
    return 0


def _names(folder: Path, robot: str | None) -> dict[str, Path]:
    """Return the logs by `robot/capability`, or by the name of an external command."""
    logs = {}
    for path in sorted(folder.glob("*.log")):
        owner, dash, part = path.stem.rpartition("-")
        if not path.is_file() or path.name.endswith(".old.log") or (robot is not None and dash and owner != robot):
            continue
        logs[f"{owner}/{part}" if dash else part] = path
    return logs


def _chosen(name: str, logs: Collection[str]) -> list[str]:
    """Return the logs that a name stands for. A capability within a shared process stands for that process's log. An
    older log of its own needs its whole name, as the list shows it."""
    if "/" in name and name in logs:
        return [name]
    shared = {part: log for part, log in _sharing() if log in logs}
    named = {log_name for log_name in (*logs, *shared) if _means(name, log_name)}
    return sorted({shared.get(log_name, log_name) for log_name in named})


def _means(name: str, one: str) -> bool:
    """Return whether a name stands for a `robot/capability`, with or without the robot."""
    return name in {one, one.rpartition("/")[2]}


def _sharing() -> list[tuple[str, str]]:
    """Return each capability in a shared process, and the process, as `robot/name`."""
    rows = glance.rows(home.default_database(), "capability", "robot", "name", "process")
    return [(f"{robot}/{name}", f"{robot}/{process}") for robot, name, process in rows if process]


def _tail(path: Path, lines: int) -> tuple[list[str], int]:
    """Return the last lines of a log, and its size then."""
    try:
        with path.open("rb") as file:
            size = os.fstat(file.fileno()).st_size
            file.seek(max(0, size - TAIL_BYTES))
            text = file.read(min(size, TAIL_BYTES)).decode(errors="replace")
    except OSError as err:
        raise InputError(f"{path} cannot be read: {err.strerror}") from err
    return (text.splitlines()[-lines:] if lines else []), size


def _followed(path: Path, at: int) -> Iterator[str]:
    """Yield lines as they are written, without end; start over in a log that was cut or replaced."""
    rest = b""
    while True:
        try:
            size = path.stat().st_size
        except OSError:
            size = 0
        if size < at:
            at, rest = 0, b""
        if size > at:
            with path.open("rb") as file:
                file.seek(at)
                *whole, rest = (rest + file.read(size - at)).split(b"\n")
            at = size
            yield from (one.decode(errors="replace") for one in whole)
        else:
            time.sleep(LOOK_S)


def _recorded(name: str, robot: str | None, begin: str | None, end: str | None) -> int:
    shared = {log.rpartition("/")[2] for part, log in _sharing() if _means(name, part)}
    wanted = {name, *shared}
    now, count = time.time_ns(), 0
    for message in Excerpt("", robot, begin, end).chosen().messages():
        entry = export.decoded(message) if message.topic == "@log" else None
        if isinstance(entry, dict) and (not name or entry.get("name") in wanted):
            count += 1
            click.echo(_clean(f"{times.text(message.log_ns, now)} {entry.get('name')}: {entry.get('message')}"))
    return 0 if count else 1


def _clean(text: str) -> str:
    """Replace characters that move the terminal's cursor; tabs stay."""
    return "".join(one if one.isprintable() or one == "\t" else "?" for one in text)
