"""A robot's certificate for its TLS links: self-signed, known to clients by its fingerprint."""

import datetime as dt
import socket
from pathlib import Path

from lbr.errors import InputError

NAME = "robot.lbr"
"""The host name in all robots' certificates; the fingerprint is the robot's own."""
VALID = (dt.datetime(1970, 1, 1, tzinfo=dt.UTC), dt.datetime(9999, 12, 31, 23, 59, 59, tzinfo=dt.UTC))
"""For ever (RFC 5280, 4.1.2.5).

Either machine may have no clock, and the fingerprint is what is trusted.
"""
FILES = ("bus.key", "bus.crt")
"""Their names in `credentials/`."""
OWN_FILES = ("web.key", "web.crt")
"""The owner's own certificate for browsers, such as one from an authority that phones trust."""


def first_der(path: Path) -> bytes:
    """Return the first certificate of a PEM file, which a server presents as its own; InputError if it has none."""
    import ssl  # noqa: PLC0415 - of 1 MiB, and only doors to other machines need it

    text = path.read_text(encoding="ascii", errors="replace")
    begin = text.find(ssl.PEM_HEADER)
    end = text.find(ssl.PEM_FOOTER, max(begin, 0))
    try:
        return ssl.PEM_cert_to_DER_cert(text[begin : end + len(ssl.PEM_FOOTER)] if 0 <= begin < end else "")
    except ValueError:
        raise InputError(f"{path} has no certificate in it: PEM begins with '{ssl.PEM_HEADER}'") from None


def untimely(der: bytes, now: dt.datetime) -> str:
    """Return a certificate's dates, in words, if it is not valid now; those of older robots expire."""
    from cryptography import x509

    found = x509.load_der_x509_certificate(der)
    begin, end = found.not_valid_before_utc, found.not_valid_after_utc
    return "" if begin <= now <= end else f"from {begin:%Y-%m-%d} to {end:%Y-%m-%d}"


def self_signed() -> tuple[bytes, bytes]:
    """Return a new private key and its certificate, both PEM."""
    from cryptography import x509
    from cryptography.hazmat.primitives import hashes
    from cryptography.hazmat.primitives.asymmetric import ec
    from cryptography.hazmat.primitives.serialization import Encoding, NoEncryption, PrivateFormat
    from cryptography.x509.oid import NameOID

    key = ec.generate_private_key(ec.SECP256R1())
    name = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, f"lbr on {socket.gethostname()}"[:64])])
    certificate = (
        x509.CertificateBuilder()
        .subject_name(name)
        .issuer_name(name)
        .public_key(key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(VALID[0])
        .not_valid_after(VALID[1])
        .add_extension(x509.SubjectAlternativeName([x509.DNSName(NAME)]), critical=False)
        .sign(key, hashes.SHA256())
    )
    return key.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption()), certificate.public_bytes(Encoding.PEM)
