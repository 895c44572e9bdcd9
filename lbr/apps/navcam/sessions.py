"""The cookies that browsers were given for the token: each can be ended, and each ends by itself.

Each is good for the user of this machine whose browser was given it, and for nobody else here, or for other machines alone:
cookies know no ports, so a browser shows them to whatever else another user serves at this host.

Kept in a file of the owner's, as hashes, so that a restart ends none; whoever reads the file cannot come in by it.
"""

import secrets
import time
from collections.abc import Callable
from hashlib import blake2b
from pathlib import Path

import msgspec

from lbr import home
from lbr.errors import InputError

FILE = "navcam.sessions"
LIFE_S = 30 * 24 * 3600
MOST = 32
"""Browsers at once; the one that came in longest ago makes room."""


class Sessions:
    """The sessions of one token, which is `key`; with another token none of them is known any more."""

    def __init__(self, path: Path, key: str, now: Callable[[], float] = time.time) -> None:
        self._path = path
        self._key = key.encode()[:64]
        self._now = now
        self._ends = self._read()

    def begin(self, whose: str) -> str:
        """Return the cookie of a new session of a user's: as `peers.whose` says."""
        cookie = secrets.token_urlsafe(32)
        self._ends = self._living()
        self._ends[self.mark(cookie, whose)] = self._now() + LIFE_S
        while len(self._ends) > MOST:
            del self._ends[min(self._ends, key=lambda mark: self._ends[mark])]
        self._write()
        return cookie

    def knows(self, mark: str) -> bool:
        """Say whether a mark is of a session that goes on."""
        return mark in self._living()

    def end(self, mark: str) -> None:
        """End the session of a mark."""
        if self._ends.pop(mark, None) is not None:
            self._write()

    def end_all(self) -> None:
        """End every session."""
        self._ends.clear()
        self._write()

    def _living(self) -> dict[str, float]:
        now = self._now()
        return {mark: end for mark, end in self._ends.items() if now < end <= now + LIFE_S}

    def mark(self, cookie: str, whose: str) -> str:
        """Return what is kept of a cookie that a user shows; another user who shows it gets another mark."""
        return blake2b(f"{whose}\n{cookie}".encode("utf-8", "replace"), key=self._key, digest_size=32).hexdigest()

    def _read(self) -> dict[str, float]:
        try:
            self._ends = msgspec.json.decode(self._path.read_bytes(), type=dict[str, float])
        except (OSError, msgspec.DecodeError):
            return {}
        return self._living()

    def _write(self) -> None:
        try:
            home.write_private(self._path, msgspec.json.encode(self._ends))
        except OSError as err:
            raise InputError(f"{self._path} cannot be written ({err.strerror}): check the disk") from err
