"""The limits of this machine: a plan that exceeds them is refused before anything starts."""

import contextlib
import os
import resource
from collections.abc import Callable, Container, Iterable, Iterator
from pathlib import Path

from msgspec import Struct

from lbr.capability.kind import Kind
from lbr.database.reading import Problem
from lbr.database.rows import CapabilityRow
from lbr.executive.planning.draft import Draft

MOST_CAPABILITIES = 100
"""Four times the largest robot.

On two busy cores, 88 idle capabilities were ready after 20 s; each of 517 stops meanwhile was answered within 0.42 s.
Ninety that receive every stream exceed the capacity of the bus there.
"""
FILES_EACH, FILES_BESIDE = 12, 100
"""The most files that the executive opens for one capability (pipes, links, share of routers), and for itself."""
FILES_WANTED = 2048
"""Enough for a full robot and everyone who watches it."""
MEMORY_EACH_MB = 16
"""The memory of a bare driver or operation; few capabilities use less."""
STARTING_PER_CORE = 3
"""More at a time are not ready sooner, and delay the capabilities that run."""


class Machine(Struct, frozen=True):
    """Runs at most `most` capabilities, for the reason `bound`; `lacks(kind)` names a kind's missing packages."""

    most: int = MOST_CAPABILITIES
    bound: str = f"one machine runs at most {MOST_CAPABILITIES}"
    lacks: Callable[[Kind], str] = lambda _kind: ""


ANY = Machine()


def problems(draft: Draft, machine: Machine) -> Iterator[Problem]:
    """Yield why the chosen capabilities cannot run: they exceed the machine, or something is not installed. Pure."""
    local_rows = [row for row in draft.chosen if not draft.profile.host_of(row.name)]
    for row in local_rows:
        if what := machine.lacks(draft.kinds[row.name]):
            yield draft.problem(row.name, "kind", f"'{row.kind}' cannot run: {what}")
    count = processes(local_rows, {row.name for row in local_rows})
    if count > machine.most:
        yield _too_many(draft.robot, count, machine.bound)
    for host, names in draft.profile.hosts.items():
        there = sum(row.name in names for row in draft.chosen)
        if there > MOST_CAPABILITIES:
            yield _too_many(draft.robot, there, f"{ANY.bound}, also the host '{host}'")


def processes(rows: Iterable[CapabilityRow], names: Container[str]) -> int:
    """Return how many processes these capabilities need."""
    return len({row.process or f"{row.name} alone" for row in rows if row.name in names})


def _too_many(robot: str, count: int, bound: str) -> Problem:
    text = f"{count} processes would run, but {bound}; turn some capabilities off, or let some share one"
    return Problem("capability", robot, "enabled", text)


def this_machine(running: int) -> Machine:
    """Return the limits of this machine, on which `running` processes of the robot already run."""
    most, bound = min((MOST_CAPABILITIES, ANY.bound), _by_files(), _by_memory(running), key=lambda one: one[0])
    return Machine(most=most, bound=bound, lacks=Kind.lacks)


def raise_limits() -> None:
    """Raise this process's limit of open files to what a full robot needs, as far as the kernel permits."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    wanted = FILES_WANTED if hard == resource.RLIM_INFINITY else min(FILES_WANTED, hard)
    if soft != resource.RLIM_INFINITY and soft < wanted:
        with contextlib.suppress(OSError, ValueError):
            resource.setrlimit(resource.RLIMIT_NOFILE, (wanted, hard))


def _by_files() -> tuple[int, str]:
    soft, _hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    if soft == resource.RLIM_INFINITY:
        return MOST_CAPABILITIES, ""
    most = max(0, (soft - FILES_BESIDE) // FILES_EACH)
    return most, f"this user may hold {soft} files open, which is enough for {most} (see 'ulimit -Hn')"


def _by_memory(running: int) -> tuple[int, str]:
    with contextlib.suppress(OSError, ValueError, KeyError):
        lines = Path("/proc/meminfo").read_text(encoding="ascii").splitlines()
        said = {name: int(rest.split()[0]) for name, _, rest in (line.partition(":") for line in lines)}
        free_mb = (said["MemAvailable"] + said.get("SwapFree", 0)) // 1024
        most = running + free_mb // MEMORY_EACH_MB
        return most, f"{free_mb} MB of memory are free, which is enough for {most} ({MEMORY_EACH_MB} MB each)"
    return MOST_CAPABILITIES, ""


def at_once() -> int:
    """Return how many processes of a robot may start at the same time on this machine."""
    return STARTING_PER_CORE * len(os.sched_getaffinity(0))
