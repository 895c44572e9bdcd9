"""Opening a database for the commands that read rows."""

from pathlib import Path
from typing import TYPE_CHECKING

from lbr.commands.options import DEFAULT_PROFILE
from lbr.errors import InputError

if TYPE_CHECKING:
    from lbr.database.store import Database


def opened(path: Path) -> "Database":
    """Open a database that is there; InputError says how to make one."""
    from lbr.database import store  # noqa: PLC0415 - SQLAlchemy is for those who read rows

    if not path.exists():
        raise InputError(f"there is no database {path}; 'lbr db init' makes one")
    return store.Database.open(path)


def robot_in(database: "Database") -> str:
    """Return the only robot in a database, or of several the one that `lbr run` starts when nothing is said."""
    from lbr.executive import profile  # noqa: PLC0415 - kept out of `lbr --help`

    names = database.robots()
    usual = profile.load(DEFAULT_PROFILE).robot
    if len(names) != 1 and usual not in names:
        raise InputError(f"{database.path} has {len(names)} robots ({', '.join(names)}); say which with --robot NAME")
    return usual if usual in names else names[0]
