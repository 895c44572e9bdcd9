"""`lbr set`."""

from typing import Any

import click

from lbr.commands.completing import complete_setting
from lbr.commands.options import refuse_unknown
from lbr.commands.row_past import Changing, change_options, tell
from lbr.commands.row_touched import Touching, change_rows
from lbr.commands.rows import opened, robot_meant
from lbr.database import changes, edits
from lbr.database.changes import Change
from lbr.database.columns import json_strictly
from lbr.database.reading import RawTables
from lbr.database.tables import Schema
from lbr.errors import InputError
from lbr.messages.rows import short


@click.command("set", context_settings={"ignore_unknown_options": True})
@click.argument("setting", metavar="PART.SETTING", shell_complete=complete_setting)
@click.argument("value", type=click.UNPROCESSED)
@change_options
def command(setting: str, value: str, how: Changing) -> int:
    """Set one setting of one part, such as drive.max_power 0.3; all others stay. A running robot follows.

    VALUE is JSON, or else a text: 0.3, true, '[100, 130]', slow, '"12"'. It is checked as at a start: exit code 2 if it
    is bad, and nothing is changed.

    'lbr db undo' takes it back, 'lbr get PART' lists the settings.
    """
    part, name = parted(setting)
    if not name:
        raise InputError(f"'{short(setting)}' names no setting: say PART.SETTING, such as drive.max_power")
    with opened(how.database) as rows:
        whose = robot_meant(rows, how.robot)

        def wanted(tables: RawTables, schema: Schema) -> tuple[Change, ...]:
            refuse_unknown(part, (row["name"] for row in tables["capability"] if row["robot"] == whose), whose)
            after = edits.with_setting(tables, whose, part, name, _read(value))
            return changes.between(tables, after, schema, whose)

        touching = Touching(rows)
        proposed = change_rows(rows, wanted, f"set {part}.{name}", touching, how.expected, dry_run=how.dry_run)
        touched = touching.effects()
    done = f"{part}.{name} is {short(value)}"
    return tell(proposed, done, how, touched=touched)


def parted(setting: str) -> tuple[str, str]:
    """Return the part and the setting of `PART.SETTING`; the setting may be empty."""
    part, _, name = setting.partition(".")
    return part, name


def _read(value: str) -> Any:
    """Return a typed value: JSON, or else a text."""
    try:
        return json_strictly(value)
    except (ValueError, RecursionError):
        return value
