"""The cookies that browsers were given for the token: each can be ended, and each ends by itself.

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

    def begin(self) -> str:
        """Return the cookie of a new session."""
        cookie = secrets.token_urlsafe(32)
        self._ends = self._living()
        self._ends[self._mark(cookie)] = self._now() + LIFE_S
        while len(self._ends) > MOST:
            del self._ends[min(self._ends, key=lambda mark: self._ends[mark])]
        self._write()
        return cookie

    def knows(self, cookie: str) -> bool:
        """Say whether a cookie is of a session that goes on."""
        return self._mark(cookie) in self._living()

    def end(self, cookie: str) -> None:
        """End the session of a cookie."""
        if self._ends.pop(self._mark(cookie), None) is not None:
            self._write()

    def end_all(self) -> None:
        """End every session."""
        self._ends.clear()
        self._write()

    def _living(self) -> dict[str, float]:
        now = self._now()
        return {mark: end for mark, end in self._ends.items() if now < end <= now + LIFE_S}

    def _mark(self, cookie: str) -> str:
        return blake2b(cookie.encode("utf-8", "replace"), key=self._key, digest_size=32).hexdigest()

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
