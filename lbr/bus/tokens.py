"""Tokens: the proof of a user on another machine to a robot, and of the robot to that machine."""

import hashlib
import re
from base64 import urlsafe_b64encode

from msgspec import Struct

from lbr.bus.access import Credentials
from lbr.errors import InputError

FINGERPRINT_CHARACTERS = 22  # 132 bits
MEMORY_KIB, ROUNDS, LANES = 19 * 1024, 2, 1
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,39}")
_SHAPE = re.compile(rf"({_NAME.pattern})\.([A-Za-z0-9_-]{{43}})\.([A-Za-z0-9_-]{{{FINGERPRINT_CHARACTERS}}})")


class Token(Struct, frozen=True, kw_only=True):
    """A name, the secret that proves it, and the fingerprint of the robot's certificate; dots separate them."""

    name: str
    secret: str
    fingerprint: str

    def __str__(self) -> str:
        return f"{self.name}.{self.secret}.{self.fingerprint}"

    @property
    def credentials(self) -> Credentials:
        """Return its holder's credentials on the bus."""
        return Credentials(user=self.name, password=self.secret)


def parse(text: str) -> Token:
    """Parse a token; raise InputError without repeating the text."""
    match = _SHAPE.fullmatch(text.strip())
    if match is None:
        raise InputError(
            "this is not a token: tokens look like NAME.SECRET.FINGERPRINT, and 'lbr token add' prints them"
        )
    return Token(name=match[1], secret=match[2], fingerprint=match[3])


def is_one(text: str) -> bool:
    """Return whether a text looks like a token."""
    return _SHAPE.fullmatch(text.strip()) is not None


def check_name(name: str) -> str:
    """Return a valid token name; raise InputError with the allowed ones."""
    if _NAME.fullmatch(name) is None:
        raise InputError("a token's name has up to 40 letters, digits, - and _, and begins with a letter or digit")
    return name


def fingerprint(certificate_der: bytes) -> str:
    """Return the form of a certificate's fingerprint in tokens and on the screen."""
    return text(hashlib.sha256(certificate_der).digest())[:FINGERPRINT_CHARACTERS]


def hashed(secret: str) -> str:
    """Return the hash of a secret for the rows: argon2id, at OWASP's lowest cost."""
    import argon2

    return argon2.PasswordHasher(time_cost=ROUNDS, memory_cost=MEMORY_KIB, parallelism=LANES).hash(secret)


def fits(secret: str, stored: str) -> bool:
    """Return whether a hash is of this secret; takes some 25 ms."""
    import argon2

    try:
        return argon2.PasswordHasher().verify(stored, secret)
    except (argon2.exceptions.VerificationError, argon2.exceptions.InvalidHashError, UnicodeEncodeError):
        return False


def text(raw: bytes) -> str:
    """Return bytes as letters, digits, - and _."""
    return urlsafe_b64encode(raw).decode().rstrip("=")
