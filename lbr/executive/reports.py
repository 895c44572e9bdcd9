"""What the robot tells of itself at the console: data, and the same in words."""

import contextlib
import json
import time
from collections.abc import Callable
from typing import Any

import msgspec

from lbr.bus import codec, stamp, wire
from lbr.bus.session import Session
from lbr.console import wiring
from lbr.errors import InputError, MalformedError
from lbr.executive.robot import Robot

NAMES = ("telemetry", "settings", "statistics", "health", "events", "wiring")


class Reports:
    """Makes reports; from any thread."""

    def __init__(self, robot: Robot, bus: Session) -> None:
        self._robot = robot
        self._bus = bus

    def make(self, name: str) -> tuple[Any, str]:
        """Return a report's data and its text; raise InputError if there is none of this name."""
        makers: dict[str, Callable[[], Any]] = {
            "telemetry": self.telemetry,
            "settings": self._settings,
            "statistics": self._statistics,
            "health": lambda: msgspec.to_builtins(self._robot.status()),
            "events": lambda: [msgspec.to_builtins(event) for event in self._robot.recent_events()],
            "wiring": self._wiring,
        }
        if name not in makers:
            raise InputError(f"there is no report '{name}': {', '.join(NAMES)}")
        data = makers[name]()
        texts: dict[str, Callable[[], str]] = {
            "health": self.health,
            "events": lambda: _events_text(data),
            "wiring": lambda: "\n".join(wiring.tree(wiring.from_plain(data))),
        }
        return data, texts[name]() if name in texts else flat(data)

    def telemetry(self) -> dict[str, Any]:
        """Return what every stream last said, and how long ago."""
        found: dict[str, Any] = {}
        for raw in wire.ask(self._bus, f"{self._robot.plan.robot}/*/*", None, source="executive", timeout_s=1.0):
            said = stamp.read(raw.attachment)
            age = (time.monotonic_ns() - said.mono_ns) / 1e9 if said and said.boot == stamp.boot_id() else None
            with contextlib.suppress(MalformedError):  # a picture, say
                value = codec.decode(raw.payload)
                if isinstance(value, dict):
                    found[raw.key.partition("/")[2]] = value | ({"age_s": round(age, 3)} if age is not None else {})
        return dict(sorted(found.items()))

    def _wiring(self) -> dict[str, Any]:
        return wiring.plain(wiring.graph(self._robot.plan.rows, *wiring.running(self._robot.status())))

    def _settings(self) -> dict[str, Any]:
        units = self._robot.plan.units.values()
        return {unit.name: {"kind": unit.kind} | msgspec.json.decode(unit.config.settings) for unit in units}

    def _statistics(self) -> dict[str, Any]:
        status = self._robot.status()
        fields = ("rates_hz", "restarts", "uptime_s", "cpu_percent", "memory_mb")
        found = {unit.name: {field: getattr(unit, field) for field in fields} for unit in status.capabilities}
        loop = self.telemetry().get("drive/state", {}).get("loop")
        return {**found, **({"drive/loop": loop} if loop else {})}

    def health(self) -> str:
        """Return how every capability is, in lines."""
        status = self._robot.status()
        lines = [
            f"{unit.name}: {unit.phase}" + (f" ({unit.reason})" if unit.reason else "") for unit in status.capabilities
        ]
        lines += [f"rows: {problem}" for problem in status.problems]
        stop = f"emergency stop: {status.estop.reason}" if status.estop.engaged else "no emergency stop"
        return "\n".join([*lines, stop])


def flat(data: dict[str, Any]) -> str:
    """Return a line for each part."""
    lines = []
    for name, fields in data.items():
        shown = ", ".join(f"{key} {_short(value)}" for key, value in fields.items())
        lines.append(f"{name}: {shown}")
    return "\n".join(lines) or "nothing yet"


def _short(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.3g}"
    return json.dumps(value) if isinstance(value, dict | list) else str(value)


def _events_text(events: list[dict[str, Any]]) -> str:
    lines = [
        f"{time.strftime('%H:%M:%S', time.localtime(e['wall_ns'] / 1e9))} {e['subject']}: {e['text']}" for e in events
    ]
    return "\n".join(lines) or "no events yet"
