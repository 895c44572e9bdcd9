"""The recording of a process for a recorder with lines: the bytes of its devices, and its commands with their answers.

Without a subscriber it is empty and costs nothing.
"""

import time
from collections.abc import Mapping

from msgspec import Raw, Struct

from lbr.bus import keys, wire
from lbr.bus.transport import Transport
from lbr.capability.calls import BusCall
from lbr.capability.tap import Tap
from lbr.messages.taped import Taped, TapedCommand, TapedLine

SEND_S = 0.2
MOST_COMMANDS = 1000
"""The most commands between two messages to the recorder; no capability answers so many."""


class Tape:
    """The publications of a process while a recorder listens. Only one thread may use it."""

    def __init__(self, bus: Transport, robot: str, name: str, taps: Mapping[str, Tap]) -> None:
        self._taps = taps
        self._commands: list[TapedCommand] = []
        self._on = False
        self._send_at = 0.0
        self._publisher = bus.publisher(keys.taped(robot, name), name, watching=lambda: None)

    def answered(self, call: BusCall, answer: Struct) -> None:
        """Add a command with its answer."""
        if self._on and len(self._commands) < MOST_COMMANDS:
            self._commands.append(
                TapedCommand(
                    name=call.name,
                    source=call.source,
                    at_ns=int(call.arrived * 1e9),
                    payload=call.payload,
                    answerable=call.answerable,
                    answered_ns=time.monotonic_ns(),
                    reply=Raw(wire.encode(answer)),
                )
            )

    def step(self, now: float) -> None:
        """Publish the additions a few times a second, and follow whether there is a subscriber."""
        if self._on != self._publisher.watched:
            self._on = self._publisher.watched
            self._commands.clear()
            for tap in self._taps.values():
                tap.listen(on=self._on)
            if self._on:
                openings = {name: tap.opening for name, tap in self._taps.items() if tap.is_line}
                self._publish([TapedLine(device=name, pieces=found, opening=True) for name, found in openings.items()])
        if self._on and now >= self._send_at:
            self._send_at = now + SEND_S
            taken = {name: tap.take() for name, tap in self._taps.items()}
            lines = [
                TapedLine(device=name, pieces=pieces, lost=lost)
                for name, (pieces, lost) in taken.items()
                if pieces or lost
            ]
            if lines or self._commands:
                self._publish(lines)

    def _publish(self, lines: list[TapedLine]) -> None:
        commands, self._commands = tuple(self._commands), []
        self._publisher.put(Taped(now_ns=time.monotonic_ns(), lines=tuple(lines), commands=commands))
