"""A UXA-90's servos at the end of a bad line: what they say, what arrives of it, and the truth beside it. No I/O.

`Fuzzer.feed` takes what the driver writes and returns what comes back, each piece with its delay. Every servo rests at a
place of its own, far from its neighbours', so that an answer that is believed of another servo is seen at once.
"""

import random
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

PREAMBLE = bytes.fromhex("FFFFAA55AA5537BA")
CONTROL = PREAMBLE + bytes.fromhex("10000000000101 01")
KINDS = (
    "noise", "mutated", "shifted", "missing", "late", "doubled", "swapped", "cut", "frame", "broken frame", "blob",
)  # fmt: skip
LATE_S = (0.02, 0.35)


@dataclass
class Fuzzer:
    """`share` of the answers are spoilt, by the `kinds` in force."""

    servos: tuple[int, ...] = tuple(range(25))
    kinds: tuple[str, ...] = KINDS
    share: float = 0.05
    seed: int = 1
    reply_s: float = 0.001
    blob_bytes: int = 400
    spoilt_bytes: int = 0
    spoilt: int = 0
    truth: Mapping[int, int] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Put every servo somewhere else."""
        self._random = random.Random(self.seed)
        places = self._random.sample(range(10, 250, 9), len(self.servos))
        self.truth = dict(zip(self.servos, places, strict=True))
        self._last = b""

    def feed(self, data: bytes) -> Iterator[tuple[float, bytes]]:
        """Yield pieces that come back, and how much later than the packets that they answer."""
        while data:
            if data.startswith(PREAMBLE):
                yield self.reply_s, CONTROL if data[8] == 0x10 else b""
                data = data[16:]
                continue
            size = 6 if data[1] >> 5 == 7 else 4
            packet, data = data[:size], data[size:]
            servo = packet[1] & 31
            if servo in self.truth:
                yield from self._answer(bytes((self._random.randrange(40), self.truth[servo])))

    def _answer(self, answer: bytes) -> Iterator[tuple[float, bytes]]:
        before, spoilt, after_s = b"", answer, self.reply_s
        if self._random.random() < self.share:
            kind = self._random.choice(self.kinds)
            before, spoilt = self._before(kind), self._instead(kind, answer)
            after_s = self._random.uniform(*LATE_S) if kind == "late" else self.reply_s
            self.spoilt += 1
            self.spoilt_bytes += len(before) + len(spoilt)
        self._last = answer
        if before:
            yield self.reply_s, before
        yield after_s, spoilt

    def _before(self, kind: str) -> bytes:
        """Return what comes before an answer."""
        match kind:
            case "noise":
                return self._random.randbytes(self._random.randint(1, 6))
            case "shifted":
                return self._random.randbytes(1)
            case "frame":
                return CONTROL
            case "broken frame":
                return CONTROL[: self._random.randint(1, 15)]
            case "blob":
                return self._random.randbytes(self._random.randint(20, self.blob_bytes))
        return b""

    def _instead(self, kind: str, answer: bytes) -> bytes:
        """Return what comes in an answer's place."""
        match kind:
            case "mutated":
                at, bit = self._random.randrange(2), 1 << self._random.randrange(8)
                return bytes(one ^ bit if place == at else one for place, one in enumerate(answer))
            case "missing":
                return b""
            case "doubled":
                return answer * 2
            case "swapped":
                return self._last or answer
            case "cut":
                return answer[:1]
        return answer


def wrong(believed: Mapping[int, int | None], truth: Mapping[int, int], tolerance: int) -> list[tuple[int, int, int]]:
    """Return servo, what is believed of it, and where it is, for all that are farther off than what is plausible."""
    return [
        (servo, place, truth[servo])
        for servo, place in believed.items()
        if place is not None and abs(place - truth[servo]) > tolerance
    ]
