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
    away = any(one.host for one in status.capabilities)
    for name in ("capability", "kind", *(("host",) if away else ()), "state", "pid"):
        table.add_column(name, no_wrap=True)
    for name in ("restarts", "up s", "CPU %", "MB"):
        table.add_column(name, justify="right", no_wrap=True)
    table.add_column("rates in Hz", overflow="fold")
    for one in status.capabilities:
        table.add_row(*(Text(*cell) for cell in _cells(one, away=away)))
    words = state_of(status)[1]
    title = f"{status.robot} ({status.profile}): {words}; pid {status.pid}, up {status.uptime_s:.0f} s"
    screen.print(Text(title, style="bold red" if status.estop.engaged else "bold"))
    screen.print(table)
    for one in status.capabilities:
        if one.reason:
            screen.print(Text(f"{one.name}: {one.reason}", style=PHASES.get(one.phase, "")))
        if one.last_end and one.last_end != one.reason:
            screen.print(Text(f"{one.name}: before that {one.last_end}"))
    for problem in status.problems:
        screen.print(Text(f"rows: {problem}", style="red"))
    if status.estop.waiting:
        screen.print(Text(status.estop.text, style="red"))


def _cells(one: CapabilityStatus, *, away: bool) -> list[tuple[str, str]]:
    rates = "  ".join(f"{name} {rate:.0f}" for name, rate in sorted(one.rates_hz.items()) if rate)
    return [
        (one.name, "bold"),
        (one.kind, ""),
        *([(one.host or "-", "")] if away else []),
        (one.phase, PHASES.get(one.phase, "")),
        (f"{one.pid or '-'} {one.process}".rstrip(), ""),
        (str(one.restarts), "yellow" if one.restarts else ""),
        (_number(one.uptime_s), ""),
        (_number(one.cpu_percent), ""),
        (_number(one.memory_mb), ""),
        (rates, ""),
    ]


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.0f}"
