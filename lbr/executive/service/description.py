"""The description of the robot for programs and pages that know nothing about it: from the running plan. Pure."""

from collections.abc import Iterable
from typing import Any

import msgspec

from lbr.bus import keys
from lbr.executive.planning.plan import Plan
from lbr.executive.planning.process_specs import ProcessSpec
from lbr.messages.description import (
    BaseDescription,
    CapabilityDescription,
    CommandDescription,
    RobotDescription,
    Schema,
)
from lbr.messages.drive import TwistCommand
from lbr.messages.kinematics import Kinematics, Wheel, base_of
from lbr.messages.rows import Row
from lbr.messages.sensing import RangeSensor
from lbr.messages.speech import Phrase


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
        if not all(hasattr(settings, name) for name in ("track_m", "max_speed_mps", "max_power")):
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
