"""The stamp of every publication, and the seal that proves the author of a setpoint."""

import hashlib
import hmac
import time
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

import msgspec
from msgspec.structs import replace

from lbr.bus.codec import Decoder
from lbr.errors import MalformedError
from lbr.messages.system import Stamp

_decoder = Decoder(Stamp)
_encoder = msgspec.json.Encoder()
MAX_STAMP_BYTES = 2048


class Origin(NamedTuple):
    """The original sender of a passed-on request, and when it was typed or written, on our monotonic clock."""

    source: str
    written_s: float


@lru_cache(maxsize=1)
def boot_id() -> str:
    """Return the identity of this machine's boot, within which monotonic times can be compared; empty if unknown."""
    try:
        return Path("/proc/sys/kernel/random/boot_id").read_text()[:8]
    except OSError:
        return ""


def _seal(key: bytes, payload: bytes, seq: int, mono_ns: int, boot: str) -> bytes:
    sealed = payload + b"|%d|%d|" % (seq, mono_ns) + boot.encode()
    return hashlib.blake2b(sealed, key=key, digest_size=16).hexdigest().encode()


def make(
    source: str,
    seq: int,
    payload: bytes = b"",
    key: bytes = b"",
    *,
    sent_s: float | None = None,
    token: str = "",
    waited_s: float = 0.0,
    origin: Origin | None = None,
) -> bytes:
    """Return the attachment of a publication; a key seals it, as proof that its author owns the key.

    `token` names the token whose secret is the key, for a robot's door on another machine. `sent_s` is when a passed-on
    message was first sent, on this machine's monotonic clock; by default, now. `waited_s` is how long it had waited
    here by then. `origin` is its original sender.
    """
    mono_ns = time.monotonic_ns() if sent_s is None else round(sent_s * 1e9)
    if origin is not None:
        waited_s = mono_ns / 1e9 - origin.written_s
    seal = _seal(key, payload, seq, mono_ns, boot_id()).decode() if key else ""
    stamp = Stamp(
        source=source,
        seq=seq,
        mono_ns=mono_ns,
        wall_ns=time.time_ns(),
        boot=boot_id(),
        seal=seal,
        token=token,
        waited_s=max(0.0, waited_s),
        by=origin.source if origin is not None else "",
    )
    return _encoder.encode(stamp)


def passed_on(attachment: bytes, via: str, token: str = "") -> bytes:
    """Return the attachment with which the door `via` passes on a message from another machine: never sealed.

    `token` names its sender's verified token.
    """
    found = read(attachment) or Stamp(source="", seq=0, mono_ns=0, wall_ns=0)
    return _encoder.encode(replace(found, seal="", via=via, token=token))


def read(attachment: bytes | None) -> Stamp | None:
    """Return the stamp in an attachment; None if it lacks one or the stamp is broken."""
    if not attachment or len(attachment) > MAX_STAMP_BYTES:
        return None
    try:
        return _decoder.decode(attachment)
    except MalformedError:
        return None


def genuine(stamp: Stamp | None, payload: bytes, key: bytes) -> bool:
    """Return whether a stamp's seal fits its payload and key; never without a key, since anybody could make it."""
    if stamp is None or not key:
        return False
    expected = _seal(key, payload, stamp.seq, stamp.mono_ns, stamp.boot)
    return hmac.compare_digest(stamp.seal.encode(errors="replace"), expected)


def sent_s(stamp: Stamp | None, arrived: float) -> float:
    """Return when a message was sent, on our monotonic clock; its arrival, if its sender has another clock."""
    if stamp is None or not stamp.boot or stamp.boot != boot_id():
        return arrived
    return min(arrived, stamp.mono_ns / 1e9)
