"""The secrets of this home: the certificate of its bus, the key of its tokens, and new tokens.

A token is never stored. It is derived from the key and its row whenever it is needed; the row holds its hash.
"""

import hashlib
import hmac
import re
import secrets
from collections.abc import Iterable
from datetime import UTC, datetime
from pathlib import Path

from msgspec import Struct

from lbr import home
from lbr.bus import certificates, tokens
from lbr.database.rows import GoodFor, TokenRow
from lbr.database.store import Database, moment_text
from lbr.errors import InputError
from lbr.messages.system import TokenRole
from lbr.names import first_free, without_marks

_KEY_BYTES = 32
_LONGEST_OF_A_DEVICE = 32
"""In characters: with a number appended, the name is still short enough for a token."""


def token_key() -> bytes:
    """Return the key of this home's tokens, made on first use."""
    (path,) = home.credentials(lambda: [secrets.token_bytes(_KEY_BYTES)], "token.key")
    key = path.read_bytes()
    if len(key) != _KEY_BYTES:
        do = f"put your copy of it back, or `rm {path}`: a new one is made, and every token is void"
        raise InputError(f"{path} has {len(key)} bytes, and a key has {_KEY_BYTES}: {do}")
    return key


def token_secret(key: bytes, name: str, created_at: str) -> str:
    """Return the secret part of a token: 43 characters that nobody can guess without the key."""
    return tokens.text(hmac.digest(key, f"{name}|{created_at}".encode(), "sha256"))


def bus_certificate() -> tuple[Path, Path]:
    """Return the files of the bus's private key and certificate, both PEM, made on first use."""
    key, certificate = home.credentials(certificates.self_signed, *certificates.FILES)
    return key, certificate


def certificate_der() -> bytes:
    """Return the certificate of the bus. The web server uses it too, unless the owner installed another."""
    return certificates.first_der(bus_certificate()[1])


def fingerprint_shown() -> str:
    """Return the SHA-256 of the certificate that browsers receive, in capital letters with colons."""
    shown = home.given_credentials(*certificates.OWN_FILES) or bus_certificate()
    return hashlib.sha256(certificates.first_der(shown[1])).digest().hex(":").upper()


def is_own_shown() -> bool:
    """Return whether browsers receive a certificate that the owner installed."""
    return bool(home.given_credentials(*certificates.OWN_FILES))


class NewToken(Struct, frozen=True, kw_only=True):
    """A new token, which is shown only once, its role, and the part that its row keeps."""

    token: tokens.Token
    role: TokenRole
    hash: str


def new_token(
    rows: Database,
    name: str,
    role: TokenRole,
    *,
    good_for: GoodFor,
    ends: datetime | None = None,
    paired_from: str | None = None,
) -> NewToken:
    """Make a token and write its row, durably; InputError if the name is invalid, or a valid token has it."""
    fingerprint = tokens.fingerprint(certificate_der())
    created_at = moment_text(datetime.now(UTC))
    secret = token_secret(token_key(), tokens.check_name(name), created_at)
    row = TokenRow(
        name=name,
        role=role,
        hash=tokens.hashed(secret),
        created_at=created_at,
        expires_at=moment_text(ends) if ends is not None else None,
        good_for=good_for,
        paired_from=paired_from,
    )
    rows.add_token(row)
    return NewToken(token=tokens.Token(name=name, secret=secret, fingerprint=fingerprint), role=role, hash=row.hash)


def device_name(said: str, taken: Iterable[str]) -> str:
    """Return a free token name for a device: the letters and digits of its own name, numbered if that name is taken."""
    name = re.sub(r"[^A-Za-z0-9]+", "-", without_marks(said)).strip("-")[:_LONGEST_OF_A_DEVICE].strip("-") or "phone"
    there = {one.lower() for one in taken}
    return first_free(name, lambda one: one.lower() in there, "-")
