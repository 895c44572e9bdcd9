"""The reports of the robot at the console: as data, and as text."""

import json
import time
from collections.abc import Callable, Iterable
from typing import Any

import msgspec

from lbr import home
from lbr.bus import keys, latest
from lbr.bus.session import Session
from lbr.console import wiring
from lbr.errors import InputError
from lbr.executive.planning.facts import facts
from lbr.executive.planning.plan import Plan
from lbr.executive.planning.process_specs import ProcessSpec
from lbr.executive.service.completion_values import REPORTS, choices
from lbr.executive.service.robot import Robot
from lbr.messages import readable
from lbr.messages.camera import JpegFrame
from lbr.messages.description import (
    BaseDescription,
    CapabilityDescription,
    CommandDescription,
    RobotDescription,
    Schema,
)
from lbr.messages.drive import DriveState, TwistCommand
from lbr.messages.joints import JointsState
from lbr.messages.kinematics import Kinematics, Wheel, base_of
from lbr.messages.rows import Row
from lbr.messages.schema import JsonObject
from lbr.messages.sensing import RangeSensor
from lbr.messages.speech import Phrase
from lbr.messages.telemetry import Telemetry


def describe(plan: Plan, words: Iterable[dict[str, object]]) -> RobotDescription:
    """Return the description of a robot that runs a plan; `words` are the words of its console."""
    return RobotDescription(
        robot=plan.robot,
        simulated=any(unit.config.simulated for unit in plan.units.values()),
        revision=plan.rows.revision,
        capabilities=tuple(_capability(plan, unit) for unit in plan.units.values()),
        words=tuple(words),
        wheels=_rows(plan, Wheel),
        ranges=_rows(plan, RangeSensor),
        phrases=_rows(plan, Phrase),
        base=_base(plan),
    )


def _base(plan: Plan) -> BaseDescription | None:
    """Return the abilities of the base: by the first capability that takes a twist, and by its speed at full power."""
    for unit in plan.units.values():
        kind = plan.kinds[unit.name]
        if not any(kind.command(name).message is TwistCommand for name in kind.commands):
            continue
        settings: Any = kind.parse(bytes(unit.config.settings))
        if not all(hasattr(settings, name) for name in ("track_m", "max_speed_mps", "max_power", "max_run_s")):
            continue
        base = base_of(plan.rows.of(Kinematics), plan.rows.of(Wheel), settings.track_m)
        most_mps = settings.max_speed_mps * settings.max_power
        return BaseDescription(
            capability=unit.name,
            kind=base.kind,
            sideways=base.holonomic,
            max_speed_mps=round(most_mps, 4),
            max_turn_rps=round(2 * most_mps / base.track_m, 4),
            max_power=settings.max_power,
            max_run_s=settings.max_run_s,
        )
    return None


def _capability(plan: Plan, unit: ProcessSpec) -> CapabilityDescription:
    kind = plan.kinds[unit.name]
    return CapabilityDescription(
        name=unit.name,
        kind=unit.kind,
        family=unit.family,
        summary=kind.summary,
        outputs={name: _schema(plan, unit, name) for name in _published(plan, unit)},
        commands={name: _command(plan, unit, name) for name in plan.commands(unit.name)},
    )


def _published(plan: Plan, unit: ProcessSpec) -> list[str]:
    """Return the outputs whose key has the capability's own name; a setpoint goes to the key of its driver."""
    wires = unit.config.outputs.items()
    return [name for name, keyed in wires if keys.port(plan.robot, unit.name, name) in {wire.key for wire in keyed}]


def _schema(plan: Plan, unit: ProcessSpec, name: str) -> Schema:
    kind = plan.kinds[unit.name]
    message = {**kind.outputs, **kind.messages}.get(name)
    return kind.schema(name, message) if message is not None else {}


def _command(plan: Plan, unit: ProcessSpec, name: str) -> CommandDescription:
    kind = plan.kinds[unit.name]
    leased = name in kind.commands and kind.command(name).leased
    return CommandDescription(schema=_schema(plan, unit, name), role=kind.role(name), leased=leased)


def _rows(plan: Plan, row: type[Row]) -> tuple[dict[str, object], ...]:
    return tuple(msgspec.to_builtins(one) for one in plan.rows.of(row))


ANSWERS_WITHIN_S = 1.0
SECRET = frozenset({"user_token"})
"""Tables that never leave a robot."""


class Reports:
    """Makes reports; may be used from any thread."""

    def __init__(self, robot: Robot, bus: Session) -> None:
        self._robot = robot
        self._bus = bus

    def make(self, name: str) -> tuple[Any, str]:
        """Return a report's data and its text; raise InputError if no report has this name."""
        makers: dict[str, Callable[[], Any]] = {
            "telemetry": self.telemetry,
            "settings": self._settings,
            "statistics": self._statistics,
            "health": lambda: msgspec.to_builtins(self._robot.status()),
            "events": lambda: [msgspec.to_builtins(event) for event in self._robot.recent_events()],
            "wiring": self._wiring,
            "robot": self._description,
            "streams": lambda: streams(self._robot.plan),
            "rows": lambda: rows(self._robot.plan, self._robot.status().profile),
        }
        if name not in makers:
            raise InputError(f"there is no report '{name}': {', '.join(REPORTS)}", "unknown_name")
        data = makers[name]()
        texts: dict[str, Callable[[], str]] = {
            "health": self.health,
            "events": lambda: _events_text(data),
            "telemetry": lambda: self._telemetry_text(data),
            "settings": lambda: "\n".join(f"{name}: {_as_written(settings)}" for name, settings in data.items()),
            "wiring": lambda: "\n".join(wiring.tree(wiring.from_plain(data))),
            "streams": lambda: "\n".join(f"{one['key']}: {one['message'] or 'unknown'}" for one in data["streams"]),
            "rows": lambda: "\n".join(f"{name}: {len(own)} rows" for name, own in data["tables"].items()),
            "robot": lambda: "\n".join(
                f"{one['name']} ({one['kind']}): {one['summary']}" for one in data["capabilities"]
            ),
        }
        return data, texts[name]() if name in texts else flat(data)

    def telemetry(self) -> dict[str, object]:
        """Return the latest message of every stream except pictures, with its age."""
        return self._latest(key for _, _, key, message in self._robot.plan.outputs() if message is not JpegFrame)

    def _latest(self, keys: Iterable[str]) -> JsonObject:
        """Return the latest messages by capability and output; all streams are asked at once."""
        found = latest.ask(self._bus, keys, source="executive", timeout_s=ANSWERS_WITHIN_S)
        return {
            topic: said.message | ({"age_s": round(said.age_s, 3)} if said.age_s is not None else {})
            for topic, said in sorted(found.items())
        }

    def _telemetry_text(self, data: JsonObject) -> str:
        """Return the robot's own telemetry package part by part, and then every stream."""
        plan = self._robot.plan
        packages = {key.removeprefix(f"{plan.robot}/") for *_, key, message in plan.outputs() if message is Telemetry}
        parts = {name: part for key in packages for name, part in data.get(key, {}).items() if isinstance(part, dict)}
        return flat(parts | {name: fields for name, fields in data.items() if name not in packages})

    def _wiring(self) -> dict[str, object]:
        graph = wiring.graph(self._robot.plan.rows, *wiring.running(self._robot.status()))
        return dict(msgspec.to_builtins(graph))

    def _description(self) -> dict[str, object]:
        """Return the robot's description: capabilities with their schemas, words, and the rows for people."""
        plan = self._robot.plan
        words = self._robot.vocabulary.entries(choices(plan, home.home()))
        return dict(msgspec.to_builtins(describe(plan, words)))

    def _settings(self) -> dict[str, object]:
        units = self._robot.plan.units.values()
        return {unit.name: {"kind": unit.kind} | msgspec.json.decode(unit.config.settings) for unit in units}

    def _statistics(self) -> JsonObject:
        status = self._robot.status()
        fields = ("rates_hz", "restarts", "uptime_s", "cpu_percent", "memory_mb")
        statistics = {unit.name: {field: getattr(unit, field) for field in fields} for unit in status.capabilities}
        drives = self._latest(
            key for *_, key, message in self._robot.plan.outputs() if message in {DriveState, JointsState}
        )
        loops = {f"{name.partition('/')[0]}/loop": said.get("loop") for name, said in drives.items()}
        return statistics | {name: loop for name, loop in loops.items() if loop}

    def health(self) -> str:
        """Return the health of every capability, a line each."""
        status = self._robot.status()
        lines = [
            f"{unit.name}: {unit.phase}" + (f" ({unit.reason})" if unit.reason else "") for unit in status.capabilities
        ]
        lines += [f"rows: {problem}" for problem in status.problems]
        stop = f"emergency stop: {status.estop.reason}" if status.estop.engaged else "no emergency stop"
        return "\n".join([*lines, stop])


def streams(plan: Plan) -> dict[str, object]:
    """Return the streams of a plan with their schemas, for a recorder: a `RecordedStreams`."""
    recorded = {}
    for name, output, key, message in plan.outputs():
        recorded[key] = {
            "key": key,
            "source": name,
            "message": message.__name__ if message is not None else "",
            "picture": message is JpegFrame,
            "schema": plan.kinds[name].schema(output, message) if message is not None else {},
        }
    programs = [row.name for row in plan.rows.external_commands]
    return {"revision": plan.rows.revision, "streams": list(recorded.values()), "programs": programs}


def rows(plan: Plan, profile: str) -> JsonObject:
    """Return the rows of a plan and their meaning, for a recorder: a `RecordedRows`."""
    tables = {name: own for name, own in plan.rows.tables.own.items() if name not in SECRET}
    return {"revision": plan.rows.revision, "facts": msgspec.to_builtins(facts(plan, profile)), "tables": tables}


def flat(data: JsonObject) -> str:
    """Return one line for each part, for people: values with their units."""
    return "\n".join(f"{name}: {readable.fields(part)}" for name, part in data.items()) or "nothing yet"


def _as_written(settings: dict[str, object]) -> str:
    """Return settings with the names and values of a row."""
    shown = {name: value if isinstance(value, str) else json.dumps(value) for name, value in settings.items()}
    return ", ".join(f"{name} {value}" for name, value in shown.items())


def _events_text(events: list[JsonObject]) -> str:
    lines = [
        f"{time.strftime('%H:%M:%S', time.localtime(e['wall_ns'] / 1e9))} {e['subject']}: {e['text']}" for e in events
    ]
    return "\n".join(lines) or "no events yet"
