"""The sources of a token for a robot elsewhere: a file, the environment, a saved token, the keyring, or the person."""

import getpass
import os
import sys
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import msgspec
from msgspec import Struct

from lbr import disk, home, ownership
from lbr.bus import tokens
from lbr.bus.tokens import Token
from lbr.errors import InputError
from lbr.messages.unreadable import UNREADABLE

VARIABLE = "LBR_TOKEN"
SERVICE = "lbr-token"
"""The key of tokens in a desktop's keyring, with the endpoint as the user."""
LARGEST_BYTES = 4096


class Offered(Struct, frozen=True, kw_only=True):
    """A token and its source, in words; `typed`: just typed, `saved`: typed once."""

    token: Token
    origin: str
    typed: bool = False
    saved: bool = False


def offered(endpoint: str, token_file: Path | None) -> Iterator[Offered]:
    """Yield the tokens to try: the named one, otherwise the saved ones, and then one that the user types."""
    if token_file is not None:
        yield Offered(token=tokens.parse(_read(token_file)), origin=f"the one in {token_file}")
        return
    if text := os.environ.get(VARIABLE):
        yield Offered(token=tokens.parse(text), origin=f"the one in {VARIABLE}")
        return
    if text := _saved().get(endpoint):
        yield Offered(token=tokens.parse(text), origin=f"the one saved in {_path()}", saved=True)
    if text := _of_keyring(endpoint):
        yield Offered(token=tokens.parse(text), origin="the one in your keyring", saved=True)
    while can_ask():
        typed = getpass.getpass(f"token for {endpoint} (empty to leave): ", stream=sys.stderr)
        if not typed.strip():
            return
        yield Offered(token=tokens.parse(typed), origin="this one", typed=True)


def can_ask() -> bool:
    """Return whether there is a user who could type a token."""
    return sys.stdin.isatty() and sys.stderr.isatty()


def save(endpoint: str, token: Token) -> None:
    """Save a token that a robot accepted; only we may read the file."""
    path = _path()
    disk.write(path, msgspec.json.format(msgspec.json.encode(_saved() | {endpoint: str(token)})))


def _saved() -> dict[str, str]:
    path = _path()
    ownership.refuse(ownership.faults(path))
    if not path.is_file():  # reading a pipe would block
        return {}
    try:
        return msgspec.json.decode(path.read_bytes(), type=dict[str, str])
    except (OSError, *UNREADABLE):
        return {}


def _of_keyring(endpoint: str) -> str | None:
    """Return the token of `keyring set lbr-token ENDPOINT`, if that package is installed and its store opens."""
    try:
        import keyring
    except ImportError:
        return None
    with suppress(Exception):  # foreign stores may fail in any way; other tokens are still tried
        return keyring.get_password(SERVICE, endpoint)
    return None


def _path() -> Path:
    return home.directory("credentials") / "robots.json"


def _read(path: Path) -> str:
    try:
        with path.open("rb") as file:
            return file.read(LARGEST_BYTES).decode(errors="replace")
    except OSError as err:
        raise InputError(f"the token's file {path} cannot be read ({err.strerror})") from err
