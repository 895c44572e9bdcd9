"""A file that a command writes for a person."""

from pathlib import Path

import click

from lbr.errors import InputError


def write_new(path: Path, content: bytes) -> None:
    """Write a new file, and report it; raise InputError if it exists, or cannot be written."""
    try:
        with path.open("xb") as file:
            file.write(content)
    except FileExistsError:
        raise InputError(f"{path} exists already; name another file, or remove it") from None
    except OSError as err:
        raise InputError(f"{path} cannot be written: {err.strerror}") from err
    click.echo(f"wrote {path}")
