"""The facts of a plan about its parts, for the explanation of why one of them stands still. Pure."""

from collections.abc import Mapping
from typing import Any

import msgspec

from lbr.capability.kind import Kind
from lbr.database.rows import CapabilityRow, RobotRows
from lbr.executive.planning.plan import Plan
from lbr.messages.joints import Joint
from lbr.why.snapshot import Channel, Facts, JointLimits, Part, Saying


def facts(plan: Plan, profile: str = "") -> Facts:
    """Return the facts about a robot's parts, including those that are switched off."""
    rows = plan.rows
    given = {end for row in rows.channels for end in (row.source, row.target)}
    made = [
        Channel(source=f"{wire.source}.{wire.key.rpartition('/')[2]}", target=f"{name}.{port}")
        for name, unit in plan.units.items()
        for port, wires in unit.config.wiring.items()
        for wire in wires
        if f"{name}.{port}" not in given
    ]
    return Facts(
        robot=plan.robot,
        profile=profile,
        parts={row.name: _part(row, plan.kinds[row.name], plan) for row in rows.capabilities if row.name in plan.kinds},
        channels=(
            *(
                Channel(source=row.source, target=row.target, enabled=row.enabled, rate_hz=row.rate_hz)
                for row in rows.channels
            ),
            *made,
        ),
        devices={row.name: row.address for row in rows.devices}
        | {one.name: one.address for unit in plan.units.values() for one in unit.config.devices},
        joints=tuple(
            JointLimits(name=row.name, servo=row.device_id, lower_rad=row.lower_rad, upper_rad=row.upper_rad)
            for row in rows.of(Joint)
        ),
        programs={row.name: row.enabled for row in rows.external_commands},
        sayings=tuple(
            Saying(pattern=row.pattern, target=row.target, payload=dict(row.payload or {})) for row in rows.verbs
        ),
        **_past(rows),
    )


def of_bad_rows(rows: RobotRows, problems: tuple[str, ...], profile: str = "") -> Facts:
    """Return the few facts that invalid rows still give."""
    parts = {
        row.name: Part(name=row.name, kind=row.kind, family="", enabled=row.enabled, needs=row.needs)
        for row in rows.capabilities
    }
    return Facts(robot=rows.robot.name, profile=profile, parts=parts, problems=problems, **_past(rows))


def _past(rows: RobotRows) -> dict[str, Any]:
    robot = rows.robot
    return {
        "last_start": robot.last_start or "",
        "last_shutdown": robot.last_shutdown or "",
        "latched": robot.estop_engaged,
        "latched_reason": robot.estop_reason,
    }


def _part(row: CapabilityRow, kind: Kind, plan: Plan) -> Part:
    settings = kind.parse(row.settings)
    unit = plan.units.get(row.name)
    return Part(
        name=row.name,
        kind=row.kind,
        family=kind.family,
        enabled=row.enabled,
        runs=unit is not None,
        moves=kind.moves,
        device=str(getattr(settings, "device", "")) if kind.device else "",
        needs=tuple(dict.fromkeys((*row.needs, *(unit.needs if unit is not None else ())))),
        inputs=_types(kind.inputs),
        setpoints=_types(kind.setpoints),
        outputs=_types(kind.outputs),
        optional=tuple(kind.optional),
        settings=_plain(settings),
    )


def _types(ports: Mapping[str, type[msgspec.Struct]]) -> dict[str, str]:
    return {port: message.__name__ for port, message in ports.items()}


def _plain(settings: msgspec.Struct) -> dict[str, object]:
    found = msgspec.to_builtins(settings)
    return found if isinstance(found, dict) else {}
