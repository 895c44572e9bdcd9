"""What this home proves itself by: the certificate of its bus, and the key that its tokens come from.

A token is made anew from the key and its row whenever it is needed, and is never written down; the row has its hash.
"""

import datetime as dt
import fcntl
import hmac
import os
import secrets
import socket
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from lbr import home
from lbr.bus import tokens

CERTIFICATE_YEARS = 20
_KEY_BYTES = 32


def token_key() -> bytes:
    """Return the key of this home's tokens, made on first use."""
    folder = home.directory("credentials")
    path = folder / "token.key"
    with _alone(folder):
        if not path.exists():
            _write(path, secrets.token_bytes(_KEY_BYTES))
    return path.read_bytes()


def token_secret(key: bytes, name: str, created_at: str) -> str:
    """Return the secret part of a token: 43 characters of which nobody can guess any without the key."""
    return tokens.text(hmac.digest(key, f"{name}|{created_at}".encode(), "sha256"))


def bus_certificate() -> tuple[Path, Path]:
    """Return the files of the bus's private key and certificate, both PEM, made on first use."""
    folder = home.directory("credentials")
    key, certificate = folder / "bus.key", folder / "bus.crt"
    with _alone(folder):
        if not (key.exists() and certificate.exists()):
            private, public = _self_signed()
            _write(key, private)
            _write(certificate, public)
    return key, certificate


def _self_signed() -> tuple[bytes, bytes]:
    from cryptography import x509  # noqa: PLC0415 - needed once in the life of a home
    from cryptography.hazmat.primitives import hashes  # noqa: PLC0415
    from cryptography.hazmat.primitives.asymmetric import ec  # noqa: PLC0415
    from cryptography.hazmat.primitives.serialization import Encoding, NoEncryption, PrivateFormat  # noqa: PLC0415
    from cryptography.x509.oid import NameOID  # noqa: PLC0415

    key = ec.generate_private_key(ec.SECP256R1())
    name = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, f"lbr on {socket.gethostname()}"[:64])])
    now = dt.datetime.now(dt.UTC)
    certificate = (
        x509.CertificateBuilder()
        .subject_name(name)
        .issuer_name(name)
        .public_key(key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(now - dt.timedelta(days=1))  # a robot without a clock of its own may be behind
        .not_valid_after(now + dt.timedelta(days=365 * CERTIFICATE_YEARS))
        .add_extension(x509.SubjectAlternativeName([x509.DNSName("robot.lbr")]), critical=False)
        .sign(key, hashes.SHA256())
    )
    return key.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption()), certificate.public_bytes(Encoding.PEM)


@contextmanager
def _alone(folder: Path) -> Iterator[None]:
    """Let one process at a time make what is missing, so that key and certificate are of one piece."""
    fd = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
    try:
        fcntl.flock(fd, fcntl.LOCK_EX)
        yield
    finally:
        os.close(fd)


def _write(path: Path, content: bytes) -> None:
    new = path.with_suffix(".new")
    with os.fdopen(os.open(new, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_CLOEXEC, 0o600), "wb") as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())
    new.replace(path)
