"""`lbr get`."""

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import click
import msgspec
from msgspec import Struct

from lbr import home
from lbr.capability import registry
from lbr.commands.completing import complete_setting
from lbr.commands.options import complete_robot, database_option, json_option, print_json, refuse_unknown
from lbr.commands.rows import opened, robot_meant
from lbr.commands.set import parted
from lbr.database.rows import CapabilityRow
from lbr.errors import InputError, LbrError
from lbr.messages.plain import one_line
from lbr.messages.rows import short
from lbr.messages.schema import JsonObject
from lbr.names import did_you_mean


class Setting(Struct, frozen=True):
    """A setting of a part; `in_row`: its row has it, otherwise it is the kind's default."""

    part: str
    setting: str
    value: Any
    in_row: bool

    def __str__(self) -> str:
        text = f"{self.part}.{self.setting} {_as_typed(self.value)}"
        return text if self.in_row else f"{text} (by its kind)"


@click.command("get")
@click.argument("setting", metavar="[PART[.SETTING]]", default="", shell_complete=complete_setting)
@click.option("--robot", metavar="NAME", shell_complete=complete_robot, help="The settings of this robot's parts.")
@database_option
@json_option
def command(setting: str, robot: str | None, database: Path | None, as_json: bool) -> None:
    """Print a setting, all settings of a part, or the settings in the rows of all parts. 'lbr set' changes one."""
    part, name = parted(setting)
    with opened(database) as rows:
        whose = robot_meant(rows, robot)
        parts = rows.load(whose).capabilities
    if part:
        refuse_unknown(part, (row.name for row in parts), whose)
    settings = [entry for row in parts if part in {"", row.name} for entry in _of(row) if part or entry.in_row]
    if name:
        settings = [_chosen(part, name, settings)]
    if as_json:
        print_json(settings)
    elif name:
        click.echo(one_line(_as_typed(settings[0].value)))
    else:
        for entry in settings:
            click.echo(one_line(str(entry)))
        if not settings:
            click.echo(f"{short(part)} has no settings" if part else f"no row of '{short(whose)}' sets anything")


def _of(row: CapabilityRow) -> Iterator[Setting]:
    """Yield a part's settings: those of its row, then its kind's defaults, unless the row's are invalid."""
    try:
        in_row = msgspec.json.decode(row.settings, type=JsonObject)
    except (msgspec.MsgspecError, ValueError):
        in_row = {}
    try:
        whole = msgspec.to_builtins(registry.find(row.kind, home.home()).parse(row.settings))
    except (LbrError, msgspec.MsgspecError, ValueError, TypeError):  # 'lbr db check' reports the fault
        whole = {}
    for name, value in {**whole, **in_row}.items():
        yield Setting(row.name, name, value, name in in_row)


def _chosen(part: str, name: str, settings: Iterable[Setting]) -> Setting:
    by_name = {entry.setting: entry for entry in settings}
    if name not in by_name:
        raise InputError(f"{short(part)} has no setting '{short(name)}'; {did_you_mean(name, by_name)}", "unknown_name")
    return by_name[name]


def _as_typed(value: object) -> str:
    """Return a value in the form that `lbr set` accepts."""
    return value if isinstance(value, str) else msgspec.json.encode(value).decode()
