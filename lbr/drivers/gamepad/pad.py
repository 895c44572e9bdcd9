"""The state of a gamepad from its events, by Linux's gamepad specification and the habits of other pads. Pure."""

from collections.abc import Iterable, Mapping
from typing import NamedTuple

from lbr.drivers.input_events import EV_ABS, EV_KEY, EV_SYN, SYN_DROPPED, SYN_REPORT, InputEvent
from lbr.messages.gamepad import Axis, Button

BUTTONS: Mapping[int, Button] = {
    0x120: "trigger", 0x121: "thumb", 0x122: "thumb2", 0x123: "top", 0x124: "top2", 0x125: "pinkie",
    0x126: "base", 0x127: "base2", 0x128: "base3", 0x129: "base4", 0x12A: "base5", 0x12B: "base6",
    0x130: "a", 0x131: "b", 0x132: "c", 0x133: "x", 0x134: "y", 0x135: "z",
    0x136: "tl", 0x137: "tr", 0x138: "tl2", 0x139: "tr2", 0x13A: "select", 0x13B: "start", 0x13C: "mode",
    0x13D: "thumbl", 0x13E: "thumbr",
    0x220: "dpad_up", 0x221: "dpad_down", 0x222: "dpad_left", 0x223: "dpad_right",
}  # fmt: skip
X, Y, Z, RX, RY, RZ, GAS, BRAKE = 0x00, 0x01, 0x02, 0x03, 0x04, 0x05, 0x09, 0x0A
HAT0X, HAT0Y, HAT2X, HAT2Y = 0x10, 0x11, 0x14, 0x15
AXES = (X, Y, Z, RX, RY, RZ, GAS, BRAKE, HAT0X, HAT0Y, HAT2X, HAT2Y)
"""Codes of all axes that may have a meaning."""
_TRIGGERS = frozenset[Axis]({"left_trigger", "right_trigger"})
_UP = frozenset[Axis]({"left_y", "right_y", "dpad_y"})
"""The axes whose kernel value grows downwards, ours upwards."""
_OF_HAT: Mapping[Axis, tuple[Button, Button]] = {
    "dpad_x": ("dpad_left", "dpad_right"),
    "dpad_y": ("dpad_down", "dpad_up"),
}


class Span(NamedTuple):
    """The range of an axis: the least value, the most, and the distance from rest that still counts as rest."""

    least: int
    most: int
    flat: int = 0


STANDARD: Mapping[int, Span] = {
    **dict.fromkeys((X, Y, RX, RY), Span(-32768, 32767, 128)),
    **dict.fromkeys((Z, RZ), Span(0, 255)),
    **dict.fromkeys((HAT0X, HAT0Y), Span(-1, 1)),
}
"""The axes of a usual pad, for one that does not report its own."""


def named(codes: Iterable[int]) -> dict[int, Axis]:
    """Return the meaning of a pad's axes: without RX and RY, its right stick is Z and RZ, and it has no triggers."""
    axes: dict[int, Axis] = {X: "left_x", Y: "left_y", HAT0X: "dpad_x", HAT0Y: "dpad_y"}
    axes |= {HAT2X: "right_trigger", HAT2Y: "left_trigger", GAS: "right_trigger", BRAKE: "left_trigger"}
    present = set(codes)
    if {RX, RY} <= present:
        axes |= {RX: "right_x", RY: "right_y", Z: "left_trigger", RZ: "right_trigger"}
    else:
        axes |= {Z: "right_x", RZ: "right_y"}
    return {code: axis for code, axis in axes.items() if code in present}


def way(value: int, span: Span, axis: Axis) -> float:
    """Return the deflection of an axis: -1 to 1 to the right and up, a trigger 0 to 1; 0 for an axis without range."""
    extent = span.most - span.least
    if extent <= 0:
        return 0.0
    rest, full = (span.least, extent) if axis in _TRIGGERS else ((span.least + span.most) / 2.0, extent / 2.0)
    flat = min(max(span.flat, 0), full / 2.0)
    off = value - rest
    share = round(max(0.0, min(1.0, (abs(off) - flat) / (full - flat))), 4)
    if axis in _TRIGGERS:
        return share if off > 0 else 0.0
    return -share if share and (off > 0) == (axis in _UP) else share


class Held(NamedTuple):
    """The state at the end of a packet."""

    axes: dict[Axis, float]
    pressed: tuple[Button, ...]


class Pad:
    """Follows a gamepad. After the kernel has dropped events its state is `unknown`, until `tell` sets it."""

    def __init__(self, spans: Mapping[int, Span] = STANDARD) -> None:
        self.unknown = False
        self._skips = False
        self._spans = {code: span for code, span in spans.items() if code in AXES}
        self._axes = named(self._spans)
        self._values: dict[int, int] = {}
        self._pressed: set[int] = set()

    def tell(self, values: Mapping[int, int], pressed: Iterable[int]) -> None:
        """Set the current state as the kernel reports it: the values of axes, the codes of held buttons."""
        self.unknown = False
        self._values = {code: value for code, value in values.items() if code in self._axes}
        self._pressed = {code for code in pressed if code in BUTTONS}

    def feed(self, events: Iterable[InputEvent]) -> list[Held]:
        """Return the state at the end of each packet; after a gap, events up to the end of that packet are ignored."""
        states = []
        for event in events:
            if (event.type, event.code) == (EV_SYN, SYN_DROPPED):
                self._skips = self.unknown = True
            elif self._skips:
                self._skips = (event.type, event.code) != (EV_SYN, SYN_REPORT)
            elif event.type == EV_KEY and event.code in BUTTONS:
                (self._pressed.add if event.value else self._pressed.discard)(event.code)
            elif event.type == EV_ABS and event.code in self._axes:
                self._values[event.code] = event.value
            elif (event.type, event.code) == (EV_SYN, SYN_REPORT):
                states.append(self.held())
        return states

    def held(self) -> Held:
        """Return the state: an axis without a value is at rest; of two with one meaning the more deflected counts."""
        axes: dict[Axis, float] = dict.fromkeys(self._axes.values(), 0.0)
        for code, value in self._values.items():
            axis = self._axes[code]
            axes[axis] = max(axes[axis], way(value, self._spans[code], axis), key=abs)
        pressed = {BUTTONS[code] for code in self._pressed}
        for axis, (less, more) in _OF_HAT.items():
            if axes.get(axis, 0.0):
                pressed.add(more if axes[axis] > 0.0 else less)
        return Held(axes, tuple(sorted(pressed)))
