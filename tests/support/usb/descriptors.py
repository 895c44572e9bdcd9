"""USB descriptors, from the USB 2.0 specification (chapter 9), CDC 1.2 with PSTN, and UVC 1.1."""

import struct
from dataclasses import dataclass, field

DEVICE, CONFIGURATION, STRING, INTERFACE, ENDPOINT, ASSOCIATION = 1, 2, 3, 4, 5, 11
CLASS_INTERFACE = 0x24
BULK, INTERRUPT = 2, 3
ENGLISH = 0x0409


@dataclass(frozen=True, slots=True)
class Identity:
    """Who a device says it is. udev makes its by-id name of the strings, or of the ids where there is none."""

    vendor: int
    product: int
    manufacturer: str = ""
    name: str = ""
    serial: str = ""
    release: int = 0x0100
    device_class: tuple[int, int, int] = (0, 0, 0)
    strings: tuple[str, ...] = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "strings", (self.manufacturer, self.name, self.serial))

    def descriptor(self) -> bytes:
        """Return the device descriptor; a string that is empty has no index."""
        indices = (number if text else 0 for number, text in enumerate(self.strings, 1))
        head = struct.pack("<HBBBBHHH", 0x0200, *self.device_class, 64, self.vendor, self.product, self.release)
        return of_type(DEVICE, head + bytes((*indices, 1)))

    def string(self, index: int) -> bytes | None:
        """Return a string descriptor; None if there is none."""
        if index == 0:
            return of_type(STRING, struct.pack("<H", ENGLISH))
        text = self.strings[index - 1] if index <= len(self.strings) else ""
        return of_type(STRING, text.encode("utf-16-le")) if text else None


def of_type(kind: int, body: bytes) -> bytes:
    """Return a descriptor: its length, its type and its body."""
    return bytes((len(body) + 2, kind)) + body


def configuration(*parts: bytes, interfaces: int) -> bytes:
    """Return the one configuration: bus powered, 100 mA."""
    body = b"".join(parts)
    return of_type(CONFIGURATION, struct.pack("<HBBBBB", len(body) + 9, interfaces, 1, 0, 0x80, 50)) + body


def interface(number: int, kind: tuple[int, int, int], *endpoints: bytes, extra: bytes = b"") -> bytes:
    """Return an interface with what its class adds, and its endpoints."""
    return of_type(INTERFACE, bytes((number, 0, len(endpoints), *kind, 0))) + extra + b"".join(endpoints)


def endpoint(address: int, kind: int, size: int, interval: int = 0) -> bytes:
    """Return an endpoint; bit 7 of its address is set if it leads to the host."""
    return of_type(ENDPOINT, struct.pack("<BBHB", address, kind, size, interval))


def of_class(subtype: int, body: bytes) -> bytes:
    """Return a descriptor that an interface's class adds."""
    return of_type(CLASS_INTERFACE, bytes((subtype,)) + body)


def split(data: bytes) -> list[bytes]:
    """Cut descriptors that follow one another apart; raise ValueError where their lengths do not add up."""
    found, at = [], 0
    while at < len(data):
        length = data[at]
        if length < 2 or at + length > len(data):
            raise ValueError(f"descriptor of {length} bytes at {at} of {len(data)}")
        found.append(data[at : at + length])
        at += length
    return found
