"""Bytes made worse: what fuzzers do to lines, payloads and traces."""

import random

NASTY = (
    b"nan", b"inf", b"-inf", b"1e309", b"1e-3", b"0x10", b"1_0", b"+0.5", b"-0", b"1.", b".5", b"--1", b"1,5", b"", b" ",
    b"0.30000000000000004", b"1.0000000001", b"-0.0001", b"361", b"-361", b"770", b"3601", b"9" * 400, b"0" * 200 + b"1",
    "\u0661".encode(), "\u00bd".encode(), "\uff11".encode(), b"true", b"None", b"null", b"%s%n", b"../..", b"$(touch x)",
    b"`id`", b";reboot", b"'", b'"', b"\\", b"forward", b"FORWARD", b"bottom", b"sideways",
)  # fmt: skip
"""Values that parsers have been known to take, or to fall over."""
SPLINTERS = (
    b"\x00", b"\x1b[2J", b"\x1b]0;t\x07", b"\x7f", b"\xff", b"\xc3", b"\xed\xa0\x80", b"\xf4\x90\x80\x80", b"\r", b"\t",
    "\u202e".encode(), "\u2028".encode(), "\u00a0".encode(), "\u0085".encode(), "\u200b".encode(), "\U0010ffff".encode(),
    "é".encode(), "e\u0301".encode(), b"/", b"//", b"{", b"}", b"#", b"!", b" ", b"\x1c",
)  # fmt: skip
"""Pieces that do not belong into a line: control, broken UTF-8, look-alikes, the grammar's own signs."""


def mutated(dice: random.Random, data: bytes, pieces: tuple[bytes, ...] = SPLINTERS, times: int = 2) -> bytes:
    """Return the bytes with up to `times` things done to them."""
    for _ in range(dice.randint(1, times)):
        data = dice.choice(_WAYS)(dice, data, pieces)
    return data


def noise(dice: random.Random, most: int = 64) -> bytes:
    """Return some bytes of no meaning."""
    return dice.randbytes(dice.randint(1, most))


def flipped(dice: random.Random, data: bytes, bits: int = 1) -> bytes:
    """Return the bytes with some bits the other way."""
    changed = bytearray(data)
    for _ in range(bits if changed else 0):
        changed[dice.randrange(len(changed))] ^= 1 << dice.randrange(8)
    return bytes(changed)


def _insert(dice: random.Random, data: bytes, pieces: tuple[bytes, ...]) -> bytes:
    at = dice.randint(0, len(data))
    return data[:at] + dice.choice(pieces) + data[at:]


def _cut(dice: random.Random, data: bytes, _pieces: tuple[bytes, ...]) -> bytes:
    return data[: dice.randint(0, len(data))]


def _drop(dice: random.Random, data: bytes, _pieces: tuple[bytes, ...]) -> bytes:
    at = dice.randint(0, len(data))
    return data[:at] + data[at + dice.randint(1, 4) :]


def _repeat(dice: random.Random, data: bytes, _pieces: tuple[bytes, ...]) -> bytes:
    at, end = sorted((dice.randint(0, len(data)), dice.randint(0, len(data))))
    return data[:end] + data[at:end] * dice.choice((1, 1, 2, 50)) + data[end:]


def _flip(dice: random.Random, data: bytes, _pieces: tuple[bytes, ...]) -> bytes:
    return flipped(dice, data)


def _case(dice: random.Random, data: bytes, _pieces: tuple[bytes, ...]) -> bytes:
    return dice.choice((data.upper(), data.lower(), data.swapcase()))


_WAYS = (_insert, _insert, _cut, _drop, _repeat, _flip, _case)
