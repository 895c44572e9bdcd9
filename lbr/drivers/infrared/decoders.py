"""The protocols that the kernel decodes for a receiver, from /sys/class/rc/rcN/protocols: enabled ones in brackets."""

import re
from collections.abc import Iterable
from pathlib import Path

from msgspec import Struct

SYS = Path("/sys/class")
NAMES = {
    2: "rc-5", 3: "rc-5", 4: "rc-5-sz", 5: "jvc", 6: "sony", 7: "sony", 8: "sony", 9: "nec", 10: "nec", 11: "nec",
    12: "sanyo", 13: "mce_kbd", 14: "mce_kbd", 15: "rc-6", 16: "rc-6", 17: "rc-6", 18: "rc-6", 19: "rc-6", 20: "sharp",
    21: "xmp", 22: "cec", 23: "imon", 24: "rc-mm", 25: "rc-mm", 26: "rc-mm", 27: "xbox-dvd",
}  # fmt: skip
"""The kernel's name of a decoder, by the protocol numbers (`enum rc_proto`) that it decodes."""
PULSES = "lirc"
"""The interface that only passes pulses on: always enabled, and not a decoder."""
_ENABLED = re.compile(r"\[(\S+)\]")


class Decoders(Struct, frozen=True, kw_only=True):
    """A receiver's name in /sys/class/rc, and its enabled decoders."""

    receiver: str
    enabled: frozenset[str]

    def lacks(self, protocols: Iterable[int] = ()) -> str:
        """Return the problem and the cure, or an empty string if one of `protocols` (without any: one at all) is
        decoded."""
        wanted = sorted({NAMES[number] for number in protocols if number in NAMES})
        if self.enabled & set(wanted) if wanted else self.enabled:
            return ""
        trouble = (
            f"decodes {' and '.join(sorted(self.enabled))}, not {' or '.join(wanted)}"
            if self.enabled
            else "decodes nothing"
        )
        names = ",".join(sorted({*self.enabled, *wanted}) or ["sony"])
        return f"{trouble}: sudo ir-keytable -s {self.receiver} -p {names}"


def of(node: str) -> Decoders | None:
    """Return the decoders of the receiver behind /dev/lircN or an input device; None if the kernel lists none."""
    name = Path(node).resolve().name
    for place in (SYS / "lirc" / name / "device", SYS / "input" / name / "device" / "device"):
        try:
            text = (place / "protocols").read_text()
        except OSError:
            continue
        return Decoders(receiver=place.resolve().name, enabled=frozenset(_ENABLED.findall(text)) - {PULSES})
    return None
