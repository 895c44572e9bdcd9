"""Protocol 1.0 of Dynamixel, also used by other servos: instructions out, bytes back into status packets. No I/O.

    FF FF | id | length | instruction or error | parameters ... | checksum       length = parameters + 2

Source: ROBOTIS e-manual, protocol 1.0.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

HEADER = b"\xff\xff"
BROADCAST = 0xFE
HIGHEST_ID = 0xFC
HIGHEST_ANSWERING = 0xFD
"""The highest id in an answer; an adapter may use it for itself."""
OVERHEAD_BYTES = 6
"""The size of a packet without parameters."""
MAX_SYNC_WRITE = 123
"""The length byte of the longest SYNC WRITE: a USB2AX answers longer ones with an error of its own (v05)."""
PING, READ, WRITE, SYNC_READ, SYNC_WRITE = 0x01, 0x02, 0x03, 0x82, 0x83


@dataclass(frozen=True, slots=True)
class Status:
    """A servo's answer: its error bits and the requested bytes."""

    id: int
    error: int
    params: bytes


def instruction(servo: int, code: int, params: bytes = b"") -> bytes:
    """Return an instruction packet."""
    if not 0 <= servo <= BROADCAST:
        raise ValueError(f"id {servo} is outside 0..{BROADCAST}")
    body = bytes((servo, len(params) + 2, code)) + params
    return HEADER + body + bytes((~sum(body) & 0xFF,))


def ping(servo: int) -> bytes:
    """Return a PING; every servo answers it, whatever its status return level."""
    return instruction(servo, PING)


def read(servo: int, address: int, count: int) -> bytes:
    """Return a READ of `count` bytes of the control table."""
    return instruction(servo, READ, bytes((address, count)))


def write(servo: int, address: int, data: bytes) -> bytes:
    """Return a WRITE into the control table."""
    return instruction(servo, WRITE, bytes((address,)) + data)


def sync_read(address: int, count: int, servos: Iterable[int]) -> bytes:
    """Return a SYNC READ of the same bytes of several servos, which answer in turn; not all makes support it."""
    return instruction(BROADCAST, SYNC_READ, bytes((address, count, *servos)))


def sync_write(address: int, blocks: Mapping[int, bytes]) -> list[bytes]:
    """Return the SYNC WRITEs that give every servo its block, all of one size; several if one would be too long."""
    sizes = {len(block) for block in blocks.values()}
    if len(sizes) != 1:
        raise ValueError("a sync write needs blocks of one size for at least one servo")
    size = sizes.pop()
    each = (MAX_SYNC_WRITE - 4) // (size + 1)
    pieces = [bytes((servo,)) + block for servo, block in blocks.items()]
    return [
        instruction(BROADCAST, SYNC_WRITE, bytes((address, size)) + b"".join(pieces[first : first + each]))
        for first in range(0, len(pieces), each)
    ]


class StatusParser:
    """Turns bytes, in pieces of any size, into status packets; it holds less than one packet.

    Bytes that cannot begin a packet are dropped one by one. `noise` counts the dropped bytes, `corrupt` the packets
    with a wrong checksum.
    """

    def __init__(self) -> None:
        self.noise = 0
        self.corrupt = 0
        self._held = bytearray()

    def feed(self, data: bytes) -> list[Status]:
        """Return the status packets that these bytes complete."""
        self._held += data
        packets: list[Status] = []
        at = 0
        while (at := self._candidate(at)) + 4 <= len(self._held):
            end = at + self._held[at + 3] + 4
            if end > len(self._held):
                break
            if sum(self._held[at + 2 : end]) & 0xFF == 0xFF:
                packets.append(Status(self._held[at + 2], self._held[at + 4], bytes(self._held[at + 5 : end - 1])))
                at = end
            else:
                self.corrupt += 1
                self.noise += 1
                at += 1
        del self._held[:at]
        return packets

    def reset(self) -> None:
        """Forget the unfinished packet."""
        self._held.clear()

    @property
    def held_bytes(self) -> int:
        """Return how many bytes of an unfinished packet it holds."""
        return len(self._held)

    def _candidate(self, at: int) -> int:
        """Return where a packet may begin, at `at` or later; bytes before it count as noise."""
        start = at
        while not self._possible(at):
            at = self._held.find(b"\xff", at + 1)
            if at < 0:
                at = len(self._held)
        self.noise += at - start
        return at

    def _possible(self, at: int) -> bool:
        """Return whether the bytes there can be the beginning of a status packet."""
        head = self._held[at : at + 5]
        return all(_FITS[place](byte) for place, byte in enumerate(head))


_FITS = (
    lambda byte: byte == 0xFF,
    lambda byte: byte == 0xFF,
    lambda byte: byte <= HIGHEST_ANSWERING,  # three FF in a row are a shifted header
    lambda byte: byte >= 2,
    lambda byte: byte <= 0x7F,
)
