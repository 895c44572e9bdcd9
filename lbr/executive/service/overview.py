"""What runs and how it is: the status of every capability, with its CPU, memory and niceness."""

from collections.abc import Mapping

import psutil

from lbr.executive.processes.managed_process import ManagedProcess
from lbr.executive.processes.supervisor import Supervisor
from lbr.messages.system import CapabilityStatus

Read = tuple[float | None, float | None, int | None]
"""CPU in percent of a core, memory in MB, niceness; None: it cannot be read."""


class Overview:
    """Reads the supervisor's slots and the processes' meters; CPU is since the look before."""

    def __init__(self, supervisor: Supervisor) -> None:
        self._supervisor = supervisor
        self._meters: dict[int, psutil.Process] = {}

    def capabilities(self, now: float) -> tuple[CapabilityStatus, ...]:
        """Return the status of every capability, in start order."""
        slots = self._supervisor.slots
        pids = {slot.child.pid for slot in slots.values() if slot.child is not None}
        self._meters = {pid: meter for pid, meter in self._meters.items() if pid in pids}
        read = {pid: self._read(pid) for pid in pids}
        return tuple(self._one(name, slot, now, read) for name, slot in slots.items())

    def _one(self, name: str, slot: ManagedProcess, now: float, read: Mapping[int, Read]) -> CapabilityStatus:
        cpu, memory, nice = read[slot.child.pid] if slot.child is not None else (None, None, None)
        return CapabilityStatus(
            name=name,
            kind=slot.unit.kind,
            phase=slot.phase,
            pid=slot.child.pid if slot.child is not None else None,
            restarts=slot.restarts,
            uptime_s=round(now - slot.started_at, 1) if slot.child is not None else None,
            reason=slot.reason,
            code=slot.code,
            last_end=slot.last_end,
            end_code=slot.end_code,
            rates_hz=slot.rates,
            cpu_percent=cpu,
            memory_mb=memory,
            nice=nice,
            process=slot.unit.config.process,
        )

    def _read(self, pid: int) -> Read:
        try:
            meter = self._meters.get(pid) or self._meters.setdefault(pid, psutil.Process(pid))
            return meter.cpu_percent(), round(meter.memory_info().rss / 1e6, 1), meter.nice()
        except psutil.Error:
            return None, None, None
