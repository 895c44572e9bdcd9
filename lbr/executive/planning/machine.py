"""The limits of this machine: a plan that it cannot run is refused before anything starts."""

import contextlib
import os
import resource
from collections.abc import Callable, Container, Iterable, Mapping
from pathlib import Path

from msgspec import Struct

from lbr.capability.kind import Kind
from lbr.database.reading import Problem
from lbr.database.rows import CapabilityRow
from lbr.executive.planning.profile import Profile

MOST_CAPABILITIES = 100
"""Four times the largest robot there is. On two busy cores, 88 with little to do were ready after 20 s, and while they
started each of 517 stops was answered within 0.42 s. Ninety that hear every stream are more than the bus carries
there."""
FILES_EACH, FILES_BESIDE = 12, 100
"""The most that the executive holds open for a capability: its pipes, its links, its share of routers; and for
itself."""
FILES_WANTED = 2048
"""For a full robot, and for all who look at it besides."""
MEMORY_EACH_MB = 16
"""The memory of a driver or an operation by itself; few capabilities have less."""
STARTING_PER_CORE = 3
"""More that start at a time are no sooner ready, and hold up what runs."""


class Machine(Struct, frozen=True):
    """At most `most` capabilities, for the reason `bound`; `lacks(kind)` says what a kind needs that is not
    installed."""

    most: int = MOST_CAPABILITIES
    bound: str = f"one machine runs at most {MOST_CAPABILITIES}"
    lacks: Callable[[Kind], str] = lambda _kind: ""


ANY = Machine()


def problems(
    robot: str, chosen: Iterable[CapabilityRow], kinds: Mapping[str, Kind], profile: Profile, machine: Machine
) -> list[Problem]:
    """Return why what was chosen cannot run: too much for a machine, or something is not installed. Pure."""
    chosen = list(chosen)
    local_rows = [row for row in chosen if not profile.host_of(row.name)]
    lacking = [(row, machine.lacks(kinds[row.name])) for row in local_rows]
    refusals = [
        Problem("capability", f"{robot}/{row.name}", "kind", f"'{row.kind}' cannot run: {what}")
        for row, what in lacking
        if what
    ]
    count = processes(local_rows, {row.name for row in local_rows})
    if count > machine.most:
        refusals.append(_too_many(robot, count, machine.bound))
    for host, names in profile.hosts.items():
        there = sum(row.name in names for row in chosen)
        if there > MOST_CAPABILITIES:
            refusals.append(_too_many(robot, there, f"{ANY.bound}, also the host '{host}'"))
    return refusals


def processes(rows: Iterable[CapabilityRow], names: Container[str]) -> int:
    """Return how many processes the capabilities of these names are."""
    return len({row.process or f"{row.name} alone" for row in rows if row.name in names})


def _too_many(robot: str, count: int, bound: str) -> Problem:
    text = f"{count} processes would run, but {bound}; turn some capabilities off, or let some share one"
    return Problem("capability", robot, "enabled", text)


def this_machine(running: int) -> Machine:
    """Return what this machine can run, `running` processes of the robot included."""
    most, bound = min(
        (MOST_CAPABILITIES, ANY.bound),
        _by_files(),
        _by_memory(running),
        key=lambda one: one[0],
    )
    return Machine(most=most, bound=bound, lacks=Kind.lacks)


def raise_limits() -> None:
    """Have the kernel allow this process as many open files as a full robot needs, as far as it may."""
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
    """Return how many processes of a robot may start at a time on this machine."""
    return STARTING_PER_CORE * len(os.sched_getaffinity(0))
