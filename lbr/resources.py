"""Finds the files that ship with lbr: inside an installed package, or at the root of a checkout."""

from pathlib import Path

from lbr.errors import InputError

_PACKAGE = Path(__file__).resolve().parent
_ROOTS = (_PACKAGE / "_shipped", _PACKAGE.parent)


def robot_db_sql() -> Path:
    """Return the file that builds a new database."""
    return _find("robot.db.sql")


def launch_profiles() -> Path:
    """Return the folder of the shipped launch profiles."""
    return _find("launch_profiles")


def _find(name: str) -> Path:
    for root in _ROOTS:
        if (root / name).exists():
            return root / name
    raise InputError(f"{name} is not in this installation of lbr ({_PACKAGE}): install lbr again")
