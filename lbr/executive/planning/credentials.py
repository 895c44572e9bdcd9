"""What this home proves itself by: the certificate of its bus, and the key that its tokens come from.

A token is made again from the key and its row whenever it is needed, and is never written down; the row has its hash.
"""

import hmac
import secrets
from pathlib import Path

from lbr import home
from lbr.bus import certificates, tokens
from lbr.errors import InputError

_KEY_BYTES = 32


def token_key() -> bytes:
    """Return the key of this home's tokens, made on first use."""
    (path,) = home.credentials(lambda: [secrets.token_bytes(_KEY_BYTES)], "token.key")
    key = path.read_bytes()
    if len(key) != _KEY_BYTES:
        do = f"put your copy of it back, or `rm {path}`: a new one is made, and every token is void"
        raise InputError(f"{path} has {len(key)} bytes, and a key has {_KEY_BYTES}: {do}")
    return key


def token_secret(key: bytes, name: str, created_at: str) -> str:
    """Return the secret part of a token: 43 characters which cannot be guessed without the key."""
    return tokens.text(hmac.digest(key, f"{name}|{created_at}".encode(), "sha256"))


def bus_certificate() -> tuple[Path, Path]:
    """Return the files of the bus's private key and certificate, both PEM, made on first use."""
    key, certificate = home.credentials(certificates.self_signed, *certificates.FILES)
    return key, certificate
