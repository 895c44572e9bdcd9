"""A robot's status as a table."""

import sys

from rich.console import Console
from rich.table import Table
from rich.text import Text

from lbr.console.toolbar import state_of
from lbr.messages.system import CapabilityStatus, Status

PIPE_WIDTH = 160
PHASES = {"ready": "green", "degraded": "yellow", "failed": "red", "starting": "yellow", "stopped": "dim"}


def show(status: Status) -> None:
    """Print a robot's status as a table."""
    screen = Console(highlight=False, width=None if sys.stdout.isatty() else PIPE_WIDTH)
    table = Table(box=None, pad_edge=False, header_style="bold")
    away = any(capability.host for capability in status.capabilities)
    for name in ("capability", "kind", *(("host",) if away else ()), "state", "pid"):
        table.add_column(name, no_wrap=True)
    for name in ("restarts", "up s", "CPU %", "MB"):
        table.add_column(name, justify="right", no_wrap=True)
    table.add_column("rates in Hz", overflow="fold")
    for capability in status.capabilities:
        table.add_row(*(Text(*cell) for cell in _cells(capability, away=away)))
    words = state_of(status)[1]
    title = f"{status.robot} ({status.profile}): {words}; pid {status.pid}, up {status.uptime_s:.0f} s"
    screen.print(Text(title, style="bold red" if status.estop.engaged else "bold"))
    screen.print(table)
    for capability in status.capabilities:
        if capability.reason:
            screen.print(Text(f"{capability.name}: {capability.reason}", style=PHASES.get(capability.phase, "")))
        if capability.last_end and capability.last_end != capability.reason:
            screen.print(Text(f"{capability.name}: before that {capability.last_end}"))
    for problem in status.problems:
        screen.print(Text(f"rows: {problem}", style="red"))
    if status.estop.waiting:
        screen.print(Text(status.estop.text, style="red"))


def _cells(capability: CapabilityStatus, *, away: bool) -> list[tuple[str, str]]:
    rates = "  ".join(f"{name} {rate:.0f}" for name, rate in sorted(capability.rates_hz.items()) if rate)
    return [
        (capability.name, "bold"),
        (capability.kind, ""),
        *([(capability.host or "-", "")] if away else []),
        (capability.phase, PHASES.get(capability.phase, "")),
        (f"{capability.pid or '-'} {capability.process}".rstrip(), ""),
        (str(capability.restarts), "yellow" if capability.restarts else ""),
        (_number(capability.uptime_s), ""),
        (_number(capability.cpu_percent), ""),
        (_number(capability.memory_mb), ""),
        (rates, ""),
    ]


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.0f}"
