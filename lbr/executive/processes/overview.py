"""The status of every capability, with its CPU, memory and niceness."""

from collections.abc import Mapping

import psutil

from lbr.executive.processes.part import Part
from lbr.executive.processes.supervisor import Supervisor
from lbr.messages.system import CapabilityStatus

Read = tuple[float | None, float | None, int | None]
"""CPU in percent of a core, memory in MB, niceness; None: unreadable."""


class Overview:
    """Reads the supervisor's capabilities and the processes' meters; the CPU use is that since the last call."""

    def __init__(self, supervisor: Supervisor) -> None:
        self._supervisor = supervisor
        self._meters: dict[int, psutil.Process] = {}

    def capabilities(self, now: float) -> tuple[CapabilityStatus, ...]:
        """Return the status of every capability, in start order."""
        parts = self._supervisor.parts
        pids = {part.child.pid for part in parts.values() if part.child is not None}
        self._meters = {pid: meter for pid, meter in self._meters.items() if pid in pids}
        read = {pid: self._read(pid) for pid in pids}
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

    def _read(self, pid: int) -> Read:
        try:
            meter = self._meters.get(pid) or self._meters.setdefault(pid, psutil.Process(pid))
            return meter.cpu_percent(), round(meter.memory_info().rss / 1e6, 1), meter.nice()
        except psutil.Error:
            return None, None, None
