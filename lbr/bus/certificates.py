"""The certificate by which a robot shows on every encrypted line who it is: made by itself, known by its fingerprint."""

import datetime as dt
import socket
import ssl
from pathlib import Path

from lbr.errors import InputError

NAME = "robot.lbr"
"""For whom every robot's certificate is; which robot it is, its fingerprint says."""
CERTIFICATE_YEARS = 20
FILES = ("bus.key", "bus.crt")
"""What they are called below `credentials/`."""
OWN_FILES = ("web.key", "web.crt")
"""What the owner puts there for browsers, such as a certificate by an authority that phones know."""


def first_der(path: Path) -> bytes:
    """Return the first certificate of a PEM file, the one that a server shows as its own; InputError if it has none."""
    text = path.read_text(encoding="ascii", errors="replace")
    begin = text.find(ssl.PEM_HEADER)
    end = text.find(ssl.PEM_FOOTER, max(begin, 0))
    try:
        return ssl.PEM_cert_to_DER_cert(text[begin : end + len(ssl.PEM_FOOTER)] if 0 <= begin < end else "")
    except ValueError:
        raise InputError(f"{path} has no certificate in it: PEM begins with '{ssl.PEM_HEADER}'") from None


def self_signed() -> tuple[bytes, bytes]:
    """Return a new private key and its certificate, both PEM."""
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
        .add_extension(x509.SubjectAlternativeName([x509.DNSName(NAME)]), critical=False)
        .sign(key, hashes.SHA256())
    )
    return key.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption()), certificate.public_bytes(Encoding.PEM)
