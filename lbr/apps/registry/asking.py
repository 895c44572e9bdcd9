"""Requests to the service, by TLS. Nothing is sent before it shows the certificate that the token names."""

import http.client
import ssl
from hmac import compare_digest
from typing import Literal
from urllib.parse import urlsplit

import msgspec

from lbr.bus import tokens
from lbr.bus.tokens import Token
from lbr.errors import BusError, InputError, LbrError
from lbr.messages.plain import one_line
from lbr.messages.unreadable import UNREADABLE

ANSWER_S = 5.0
LARGEST_BYTES = 1024 * 1024
PATH = "/api/robots"


class NotTakenError(LbrError):
    """The service refused; the text is the reason."""


def ask(
    url: str, token: Token, method: Literal["GET", "POST", "DELETE"], body: bytes = b"", *, within_s: float = ANSWER_S
) -> bytes:
    """Return the answer of the service; NotTakenError if it refuses, BusError if it is unreachable or another one."""
    try:
        where = urlsplit(url)
        scheme, host, port = where.scheme, where.hostname, where.port or 443
        connection = http.client.HTTPSConnection(host or "", port, timeout=within_s, context=_whichever())
    except (ValueError, http.client.InvalidURL):
        scheme, host = "", None
    if scheme != "https" or not host:
        raise InputError(f"'{url[:80]}' is no address of a registry; addresses look like https://HOST:9147")
    try:
        connection.connect()
        _check(connection, url, token)
        headers = {"Authorization": f"Bearer {token}", "Content-Type": "application/json"}
        connection.request(method, PATH, body=body or None, headers=headers)
        answer = connection.getresponse()
        content = answer.read(LARGEST_BYTES)
    except UnicodeError as err:  # an empty or too long label, or bytes that are not text
        raise InputError(f"'{host[:80]}' is no name or address of a machine") from err
    except (OSError, http.client.HTTPException) as err:
        raise BusError(f"the registry at {url} cannot be reached ({err or type(err).__name__})") from err
    finally:
        connection.close()
    if answer.status != http.client.OK:
        raise NotTakenError(f"the registry at {url} refuses ({answer.status}): {_reason(content)}")
    return content


def _whichever() -> ssl.SSLContext:
    """Return a TLS context that accepts any certificate: the token's fingerprint proves the right one."""
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    context.minimum_version = ssl.TLSVersion.TLSv1_2
    context.check_hostname = False
    context.verify_mode = ssl.CERT_NONE
    return context


def _check(connection: http.client.HTTPSConnection, url: str, token: Token) -> None:
    shown = connection.sock.getpeercert(binary_form=True) or b""
    if not compare_digest(tokens.fingerprint(shown), token.fingerprint):
        raise BusError(
            f"{url} shows another certificate than the one of this token: it is another registry, or a forgery"
        )


def _reason(said: bytes) -> str:
    """Return the reason in an answer, as one printable line."""
    try:
        text = str(msgspec.json.decode(said, type=dict[str, object]).get("reason", ""))
    except UNREADABLE:
        text = ""
    return one_line(text)[:200] or "without a reason"
