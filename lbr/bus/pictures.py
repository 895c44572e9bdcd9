"""JPEG pictures without decoding: whether one is whole, and its size."""

MOST_BYTES = 900_000
"""No larger picture is sent: the bus accepts messages of up to a megabyte."""

_BEGIN, _END = b"\xff\xd8", b"\xff\xd9"
_ALONE = {0x01, *range(0xD0, 0xD8)}
_NO_FRAME_HEADER = {0xC4, 0xC8, 0xCC}


def is_whole(data: bytes) -> bool:
    """Return whether bytes begin and end as a JPEG file does."""
    return len(data) > 4 and data.startswith(_BEGIN) and data.endswith(_END)


def size_px(data: bytes) -> tuple[int, int] | None:
    """Return width and height by the picture's frame header; None without a readable one."""
    at = len(_BEGIN)
    while data.startswith(_BEGIN) and at + 4 <= len(data) and data[at] == 0xFF:
        marker = data[at + 1]
        if marker == 0xFF:
            at += 1
        elif marker in _ALONE:
            at += 2
        elif 0xC0 <= marker <= 0xCF and marker not in _NO_FRAME_HEADER:
            header = data[at + 5 : at + 9]
            if len(header) < 4:
                return None
            return int.from_bytes(header[2:], "big"), int.from_bytes(header[:2], "big")
        else:
            at += 2 + max(2, int.from_bytes(data[at + 2 : at + 4], "big"))
    return None


def described(data: bytes) -> str:
    """Return a description of a picture, for people."""
    size = size_px(data)
    return f"JPEG, {f'{size[0]}x{size[1]}, ' if size else ''}{len(data)} bytes"
