"""Connecting to a robot on another machine: is it the robot of the token, does it accept us, and in which role?"""

import socket
import ssl
import sys
import time
from datetime import UTC, datetime
from pathlib import Path
from typing import get_args

from msgspec import Struct

from lbr.bus import certificates, keys, session, tokens, wire
from lbr.bus.access import Credentials
from lbr.bus.session import Session
from lbr.bus.tokens import Token
from lbr.console import token_store
from lbr.console.token_store import Offered
from lbr.errors import BusError, InputError
from lbr.messages.rows import short
from lbr.messages.system import Role

HANDSHAKE_S = 3.0
AGAIN_S = 0.5
ROLE_S = 2.0
PROTOCOL = "tls/"
HOW = "'lbr token add NAME' at the robot makes one"


class Entry(Struct, frozen=True, kw_only=True):
    """The credentials for a robot elsewhere: name and secret, and the only certificate that it may present (PEM)."""

    credentials: Credentials
    certificate: str


class AbsentError(BusError):
    """No robot answers at an endpoint; later, one may."""


class RefusedError(BusError):
    """The robot there refuses us, and will until somebody changes that."""


def enter(endpoint: str, token_file: Path | None) -> Entry:
    """Return the entry to an endpoint; otherwise raise BusError or InputError with the reason, in one sentence.

    A typed token is saved once the robot has accepted it.
    """
    der = certificate_at(endpoint)
    refused = ""
    for offered in token_store.offered(endpoint, token_file):
        refused = _why_not(endpoint, offered, der)
        if not refused:
            if offered.typed:
                token_store.save(endpoint, offered.token)
            return _entry(offered.token, der)
        if offered.typed:
            break
        if offered.saved and token_store.can_ask():
            print(f"lbr: {refused}", file=sys.stderr)
            refused = ""
    raise RefusedError(
        refused or f"{short(endpoint)} wants a token: set {token_store.VARIABLE}, or use --token-file; {HOW}"
    )


def role_at(bus: Session, robot: str, source: str) -> Role:
    """Return our highest role at a robot, by the key on which it accepts our console lines."""
    asked: dict[Role, wire.PendingQuery] = {
        role: wire.PendingQuery(bus, keys.console(robot, role), b"", timeout_s=ROLE_S, source=source)
        for role in reversed(get_args(Role))
    }
    end = time.monotonic() + ROLE_S
    for role, question in asked.items():
        while not (question.replies or question.done) and time.monotonic() < end:
            time.sleep(0.001)
        if question.replies:
            return role
    raise BusError(f"robot '{short(robot)}' lets this token in, but does not answer; 'lbr status' there shows why")


def certificate_at(endpoint: str) -> bytes:
    """Return the certificate that an endpoint presents."""
    host, port = _place(endpoint)
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    context.check_hostname = False
    context.verify_mode = ssl.CERT_NONE  # the certificate is compared with the token's fingerprint instead
    try:
        with (
            socket.create_connection((host, port), timeout=HANDSHAKE_S) as plain,
            context.wrap_socket(plain, server_hostname=host) as secure,
        ):
            return secure.getpeercert(binary_form=True) or b""
    except ssl.SSLError as err:
        raise BusError(f"what listens at {short(endpoint)} does not speak TLS; is it another program's port?") from err
    except TimeoutError as err:
        raise AbsentError(f"no robot answers at {short(endpoint)} within {HANDSHAKE_S:g} s") from err
    except socket.gaierror as err:
        raise AbsentError(f"there is no machine '{short(host)}' ({err.strerror})") from err
    except UnicodeError as err:  # an empty or too long part between dots, or invalid bytes
        raise InputError(f"'{short(host)}' is no name or address of a machine") from err
    except OSError as err:
        raise AbsentError(f"nothing listens at {short(endpoint)} ({err.strerror or err})") from err


def _why_not(endpoint: str, offered: Offered, der: bytes) -> str:
    """Return why an endpoint refuses a token; empty if it accepts it."""
    if tokens.fingerprint(der) != offered.token.fingerprint:
        return (
            f"{short(endpoint)} shows another certificate ({tokens.fingerprint(der)}) than the token is for, "
            f"{offered.origin}: this is another robot, or someone in between"
        )
    for patience_s in (AGAIN_S, 0.0):
        try:
            entry = _entry(offered.token, der)
            session.open_client([endpoint], entry.credentials, certificate=entry.certificate, timeout_s=0.0).close()
        except BusError:
            time.sleep(patience_s)  # a door that is just reopening would refuse every client
            certificate_at(endpoint)
        else:
            return ""
    now = datetime.now(UTC)
    if valid := certificates.untimely(der, now):
        clock = f"this machine's clock says {now:%Y-%m-%d}: set the clock"
        return f"{short(endpoint)} shows a certificate that is valid {valid}, and {clock}"
    return f"{short(endpoint)} refuses the token, {offered.origin}: it is unknown, revoked or expired; {HOW}"


def _entry(token: Token, der: bytes) -> Entry:
    return Entry(credentials=token.credentials, certificate=ssl.DER_cert_to_PEM_cert(der))


def _place(endpoint: str) -> tuple[str, int]:
    host, _, port = endpoint.removeprefix(PROTOCOL).rpartition(":")
    if not host or not port.isdecimal() or not 0 < int(port) < 65536:
        raise InputError(f"'{short(endpoint)}' is not an endpoint; one looks like tls/192.168.1.7:7447")
    return host.strip("[]"), int(port)
