"""The command path with zenoh-python alone, as programs: `bare.py router|drive|motors|load|source|sink ENDPOINT ...`.

`drive` answers commands: it decodes, checks lease, holder and newest range, and sends the nearest setpoint within its
slew, at once and at 50 Hz. `motors` checks lease and age, and writes it to a line. Both work within Zenoh's callbacks,
like a minimal program. `load` sends and receives three streams at 100 Hz and pictures. `source` sends messages at 1
kHz, which `sink` decodes. All print "ready", and end with their input.
"""

import json
import os
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import msgspec
import zenoh
from msgspec import Struct

from benchmarks.instruments.stages import FOLDER_VARIABLE, NAMES, Stamps

PERIOD_S = 0.02
SLEW_PER_S = 2.0
OLDEST_S = 0.3
LEASE = "0123456789abcdef"
PICTURE = bytes(30_000)
FILLER = "x" * 160
BUFFERED = 2048


class Command(Struct):
    """A client's request."""

    power: float
    angle_deg: float
    lease: str = ""


class Reply(Struct):
    """The answer to a client."""

    accepted: bool
    lease: str
    reason: str = ""


class Setpoint(Struct):
    """The command to the motors."""

    left: float
    right: float
    lease: str
    sent_ns: int


class Ranges(Struct):
    """The nearest obstacle."""

    forward_cm: float


class Tick(Struct):
    """One message of a stream."""

    sent_ns: int
    text: str = FILLER


encode = msgspec.json.Encoder().encode
_reached = Stamps(os.environ[FOLDER_VARIABLE]).reached if FOLDER_VARIABLE in os.environ else None


def reached(name: str, number: int = 0) -> None:
    """Note a stage, if that is requested."""
    if _reached is not None:
        _reached(NAMES.index(name), number)


def settings(mode: str, endpoint: str) -> zenoh.Config:
    """Return the configuration of a program that searches for nobody."""
    way = "listen" if mode == "router" else "connect"
    return zenoh.Config.from_json5(
        json.dumps(
            {
                "mode": mode,
                way: {"endpoints": [endpoint]},
                "scouting": {"multicast": {"enabled": False}, "gossip": {"enabled": False}},
            }
        )
    )


def hears(session: zenoh.Session, key: str, handle: Callable[[Any], None]) -> Any:
    """Subscribe; `handle` runs on Zenoh's thread."""
    return session.declare_subscriber(key, zenoh.handlers.Callback(handle, indirect=False))


def every(period_s: float, once: Callable[[], None]) -> None:
    """Call `once` at a rate, in a thread."""

    def go() -> None:
        due = time.monotonic()
        while True:
            once()
            due = max(due + period_s, time.monotonic())
            time.sleep(max(0.0, due - time.monotonic()))

    threading.Thread(target=go, daemon=True).start()


class Drive:
    """Decides the power of the motors."""

    def __init__(self, session: zenoh.Session) -> None:
        self._decode = msgspec.json.Decoder(Command).decode
        self._ranges = msgspec.json.Decoder(Ranges).decode
        self._asked = self._now = self._forward_cm = 0.0
        self._at = time.monotonic()
        self._lock = threading.Lock()
        self._out = session.declare_publisher(
            "bare/setpoint",
            express=True,
            priority=zenoh.Priority.REAL_TIME,
            congestion_control=zenoh.CongestionControl.DROP,
        )
        self._heard = hears(session, "bare/ranges", self._range)
        self._commands = session.declare_queryable(
            "bare/command", zenoh.handlers.Callback(self._command, indirect=False), complete=True
        )
        every(PERIOD_S, self._send)

    def _range(self, sample: zenoh.Sample) -> None:
        self._forward_cm = self._ranges(sample.payload.to_bytes()).forward_cm

    def _command(self, query: zenoh.Query) -> None:
        reached("arrived")
        with query:
            assert query.payload is not None
            command = self._decode(query.payload.to_bytes())
            accepted = command.lease in {"", LEASE} and self._forward_cm > 10.0
            if accepted:
                self._asked = command.power
                self._send()
            query.reply("bare/command", encode(Reply(accepted, LEASE)))
        reached("replied")

    def _send(self) -> None:
        with self._lock:
            now = time.monotonic()
            self._now = min(self._asked, self._now + SLEW_PER_S * (now - self._at))
            self._at = now
            reached("sent", round(self._now * 1000))
            self._out.put(encode(Setpoint(self._now, -self._now, LEASE, time.monotonic_ns())))
            reached("given", round(self._now * 1000))


class Motors:
    """Writes setpoints to a line."""

    def __init__(self, session: zenoh.Session, path: str) -> None:
        self._decode = msgspec.json.Decoder(Setpoint).decode
        self._line = os.open(path, os.O_WRONLY | os.O_NOCTTY | os.O_NONBLOCK)
        self._heard = hears(session, "bare/setpoint", self._hear)

    def _hear(self, sample: zenoh.Sample) -> None:
        reached("heard")
        setpoint = self._decode(sample.payload.to_bytes())
        if setpoint.lease == LEASE and time.monotonic_ns() - setpoint.sent_ns < OLDEST_S * 1e9:
            left, right = round(setpoint.left * 1000), round(setpoint.right * 1000)
            os.write(self._line, b"!M %d %d\r" % (left, right))
            reached("written", abs(left))


def load(session: zenoh.Session) -> list[Any]:
    """Send and receive streams and pictures."""
    kept: list[Any] = [hears(session, "bench/load/*", lambda sample: sample.payload.to_bytes())]
    for key in ("one", "two", "three"):
        out = session.declare_publisher(f"bench/load/{key}")
        kept.append(out)
        every(0.01, lambda out=out: out.put(encode(Tick(time.monotonic_ns()))))  # type: ignore[misc]
    pictures = session.declare_publisher("bench/load/pictures", priority=zenoh.Priority.DATA_LOW)
    every(1 / 15, lambda: pictures.put(PICTURE))
    return [*kept, pictures]


def source(session: zenoh.Session) -> Any:
    """Send a thousand messages a second."""
    out = session.declare_publisher("bare/ticks")
    every(0.001, lambda: out.put(encode(Tick(time.monotonic_ns()))))
    return out


def sink(session: zenoh.Session, path: str) -> Any:
    """Decode messages, and write their ages in microseconds."""
    decode, file = msgspec.json.Decoder(Tick).decode, Path(path).open("w", buffering=BUFFERED)  # noqa: SIM115

    def hear(sample: zenoh.Sample) -> None:
        tick = decode(sample.payload.to_bytes())
        file.write(f"{(time.monotonic_ns() - tick.sent_ns) / 1e3:.1f}\n")

    return hears(session, "bare/ticks", hear), file


def main(role: str, endpoint: str, *more: str) -> None:
    """Run one of the programs."""
    with zenoh.open(settings("router" if role == "router" else "client", endpoint)) as session:
        roles: dict[str, Callable[..., Any]] = {
            "router": lambda _session: None,
            "drive": Drive,
            "motors": Motors,
            "load": load,
            "source": source,
            "sink": sink,
        }
        kept = roles[role](session, *more)
        print("ready", flush=True)
        sys.stdin.read()
        del kept
        os._exit(0)


if __name__ == "__main__":
    main(*sys.argv[1:])
