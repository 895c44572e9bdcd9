"""The status of every capability, with its CPU, memory and niceness."""

import os
from collections.abc import Mapping
from pathlib import Path

from lbr.executive.processes.part import Part
from lbr.executive.processes.supervisor import Supervisor
from lbr.messages.system import CapabilityStatus

Read = tuple[float | None, float | None, int | None]
"""CPU in percent of a core, memory in MB, niceness; None: unreadable."""
TICKS_PER_S, PAGE_BYTES = os.sysconf("SC_CLK_TCK"), os.sysconf("SC_PAGE_SIZE")


class Overview:
    """Reads the supervisor's capabilities and the processes' meters; the CPU use is that since the last call."""

    def __init__(self, supervisor: Supervisor) -> None:
        self._supervisor = supervisor
        self._used: dict[int, tuple[float, float]] = {}

    def capabilities(self, now: float) -> tuple[CapabilityStatus, ...]:
        """Return the status of every capability, in start order."""
        parts = self._supervisor.parts
        pids = {part.child.pid for part in parts.values() if part.child is not None}
        self._used = {pid: used for pid, used in self._used.items() if pid in pids}
        read = {pid: self._read(pid, now) for pid in pids}
        return tuple(self._status(name, part, now, read) for name, part in parts.items())

    def _status(self, name: str, part: Part, now: float, read: Mapping[int, Read]) -> CapabilityStatus:
        cpu, memory, nice = read[part.child.pid] if part.child is not None else (None, None, None)
        return CapabilityStatus(
            name=name,
            kind=part.spec.kind,
            phase=part.phase,
            pid=part.child.pid if part.child is not None else None,
            restarts=part.restarts,
            uptime_s=round(now - part.started_at, 1) if part.child is not None else None,
            reason=part.reason,
            code=part.code,
            last_end=part.last_end,
            end_code=part.end_code,
            rates_hz=part.rates,
            cpu_percent=cpu,
            memory_mb=memory,
            nice=nice,
            process=part.spec.config.process,
        )

    def _read(self, pid: int, now: float) -> Read:
        try:
            fields = Path(f"/proc/{pid}/stat").read_bytes().rpartition(b")")[2].split()  # proc(5), from `state` on
        except OSError:
            return None, None, None
        used_s, nice, pages = (int(fields[11]) + int(fields[12])) / TICKS_PER_S, int(fields[16]), int(fields[21])
        before_s, at = self._used.get(pid, (used_s, now))
        self._used[pid] = used_s, now
        percent = (used_s - before_s) / (now - at) * 100.0 if now > at else 0.0
        return round(percent, 1), round(pages * PAGE_BYTES / 1e6, 1), nice
