"""`lbr status`."""

import sys
from typing import TYPE_CHECKING

import click

from lbr.commands.options import Whom, json_option, print_json, robot_options
from lbr.errors import BusError
from lbr.messages.system import Status

if TYPE_CHECKING:
    from lbr.console.target import Target
    from lbr.messages.system import CapabilityStatus

PIPE_WIDTH = 160
PHASES = {"ready": "green", "degraded": "yellow", "failed": "red", "starting": "yellow", "stopped": "dim"}


@click.command("status")
@robot_options
@json_option
def command(whom: Whom, as_json: bool) -> int:
    """Show every capability of a running robot: state, process, restarts, rates and the reason if it is not ready."""
    from lbr.console import target  # noqa: PLC0415 - the bus is for those who use it

    status = ask(target.find(*whom), "lbr status")
    if as_json:
        print_json(status)
    else:
        show(status)
    return 0


def ask(found: "Target", who: str) -> "Status":
    """Return a robot's status; BusError if it does not answer."""
    import msgspec  # noqa: PLC0415

    from lbr.bus import keys, wire  # noqa: PLC0415
    from lbr.console import target  # noqa: PLC0415

    with target.connected(found) as bus:
        answers = wire.ask(bus, keys.status(found.robot), None, source=target.source(who))
    if not answers:
        raise BusError(f"robot '{found.robot}' does not answer")
    return msgspec.json.decode(answers[0].payload, type=Status)


def show(status: "Status") -> None:
    """Print a robot's status as a table."""
    from rich.console import Console  # noqa: PLC0415 - tables are for people
    from rich.table import Table  # noqa: PLC0415
    from rich.text import Text  # noqa: PLC0415

    from lbr.console.toolbar import state_of  # noqa: PLC0415

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


def _cells(one: "CapabilityStatus", *, away: bool) -> list[tuple[str, str]]:
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
