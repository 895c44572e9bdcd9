"""The tokens that the service has issued: a name and a digest of the secret each, in a private file."""

import hashlib
import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from hmac import compare_digest
from pathlib import Path

import msgspec
from msgspec import Struct

from lbr import disk, home, ownership
from lbr.apps.http import listening
from lbr.bus import certificates, tokens
from lbr.bus.tokens import Token
from lbr.errors import InputError
from lbr.messages.unreadable import UNREADABLE

FOLDER, FILE = "registry", "tokens.json"


class Guest(Struct, frozen=True, kw_only=True):
    """A token without its secret. That has 256 bits, so a plain digest reveals nothing."""

    digest: str
    since: str


class Guests:
    """The file of tokens in this home; changes by other processes apply from the next read on."""

    def __init__(self) -> None:
        self.path = home.directory(FOLDER) / FILE
        self._read: tuple[int, int] = (-1, -1)
        self._known: dict[str, Guest] = {}

    def names(self) -> dict[str, str]:
        """Return the tokens' names, and since when each exists."""
        return {name: guest.since for name, guest in sorted(self._now().items())}

    def add(self, name: str) -> Token:
        """Make a token; raise InputError if the name is invalid, or taken."""
        tokens.check_name(name)
        secret = tokens.text(secrets.token_bytes(32))
        with self._changing() as known:
            if name in known:
                raise InputError(f"'{name}' has a token already: revoke it first, or take another name", "exists")
            known[name] = Guest(digest=_digest(secret), since=datetime.now(UTC).isoformat(timespec="seconds"))
        shown = certificates.first_der(Path(listening.certificate()[1]))
        return Token(name=name, secret=secret, fingerprint=tokens.fingerprint(shown))

    def revoke(self, name: str) -> None:
        """Revoke a token."""
        with self._changing() as known:
            if known.pop(name, None) is None:
                raise InputError(f"nobody has a token called '{name}'", "unknown_name")

    def proven(self, shown: str) -> str:
        """Return the name of a valid token, or an empty string."""
        try:
            token = tokens.parse(shown)
        except InputError:
            return ""
        guest = self._now().get(token.name)
        right = guest.digest if guest is not None else _digest("")
        return token.name if compare_digest(_digest(token.secret), right) and guest is not None else ""

    def _now(self) -> dict[str, Guest]:
        try:
            status = self.path.stat()
        except FileNotFoundError:
            self._known = {}
            return self._known
        if (status.st_mtime_ns, status.st_ino) != self._read:
            ownership.refuse(ownership.faults(self.path, secret=True))
            try:
                self._known = msgspec.json.decode(self.path.read_bytes(), type=dict[str, Guest])
            except (OSError, *UNREADABLE) as err:
                raise InputError(f"{self.path} cannot be read ({err}): remove it, and give new tokens") from err
            self._read = (status.st_mtime_ns, status.st_ino)
        return self._known

    @contextmanager
    def _changing(self) -> Iterator[dict[str, Guest]]:
        """Change the file, one process at a time, as a whole or not at all."""
        with disk.locked(self.path.parent):
            known = dict(self._now())
            yield known
            disk.write(self.path, msgspec.json.format(msgspec.json.encode(known)))


def _digest(secret: str) -> str:
    return hashlib.sha256(secret.encode()).hexdigest()
