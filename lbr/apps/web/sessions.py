"""The cookies that browsers receive for a token: each allows looking only, can be ended, and expires.

A cookie is good for the user of this machine whose browser received it, or for other machines. Browsers send it to any
port of this host, so also to servers of other users; those cannot use it. A file of the owner's keeps the hashes, so
that a restart ends no session; a reader of the file cannot sign in with it.
"""

import secrets
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from hashlib import blake2b
from pathlib import Path

import msgspec

from lbr import disk, home
from lbr.errors import InputError
from lbr.messages.unreadable import UNREADABLE

LIFE_S = 30 * 24 * 3600
MOST = 32
"""The most sessions at once; the oldest makes room."""


class Sessions:
    """The sessions of tokens; `keys` are the tokens' secrets by name. A removed token ends its sessions.

    All but `knows` and changes of tokens is for the server's thread.
    """

    def __init__(self, path: Path, keys: Mapping[str, str], now: Callable[[], float] = time.time) -> None:
        self._path = path
        self.use(keys)
        self._now = now
        self._ends = self._read()

    def use(self, keys: Mapping[str, str]) -> None:
        """Use these tokens only; from any thread."""
        self._keys = {name: key.encode()[:64] for name, key in keys.items()}

    def begin(self, name: str, whose: str) -> str:
        """Begin a session of a token for a user, as `peers.whose` names it; return its cookie.

        A session that cannot be written ends with this process.
        """
        cookie = secrets.token_urlsafe(32)
        self._ends = self._living()
        self._ends[_mark(name, self._keys.get(name, b""), whose, cookie)] = self._now() + LIFE_S
        while len(self._ends) > MOST:
            del self._ends[min(self._ends, key=lambda mark: self._ends[mark])]
        with suppress(InputError):
            self._write()
        return cookie

    def find(self, cookie: str, whose: str) -> str:
        """Return the mark of the session of a user's cookie; empty without a valid one."""
        marks = (_mark(name, key, whose, cookie) for name, key in self._keys.items())
        return next((mark for mark in marks if self.knows(mark)), "")

    def knows(self, mark: str) -> bool:
        """Return whether a session or a token is valid, by the mark of its client."""
        return mark in self._keys or (name_in(mark) in self._keys and mark in self._living())

    def end(self, mark: str) -> None:
        """End the session of a mark."""
        self._drop(lambda one: one == mark)

    def end_all(self, name: str) -> None:
        """End every session of a token."""
        self._drop(lambda one: name_in(one) == name)

    def _drop(self, meant: Callable[[str], bool]) -> None:
        left = {mark: end for mark, end in self._ends.items() if not meant(mark)}
        if len(left) < len(self._ends):
            self._ends = left
            self._write()

    def _living(self) -> dict[str, float]:
        now = self._now()
        return {mark: end for mark, end in self._ends.items() if now < end <= now + LIFE_S}

    def _read(self) -> dict[str, float]:
        try:
            self._ends = msgspec.json.decode(self._path.read_bytes(), type=dict[str, float])
        except (OSError, *UNREADABLE):
            return {}
        return self._living()

    def _write(self) -> None:
        try:
            home.directory(self._path.parent.name)
            disk.write(self._path, msgspec.json.encode(self._ends))
        except OSError as err:
            raise InputError(f"{self._path} cannot be written ({err.strerror}): check the disk") from err


def _mark(name: str, key: bytes, whose: str, cookie: str) -> str:
    shown = f"{whose}\n{cookie}".encode("utf-8", "replace")
    return f"{name}:{blake2b(shown, key=key, digest_size=32).hexdigest()}"


def name_in(mark: str) -> str:
    """Return the name of a session's token."""
    return mark.partition(":")[0]
