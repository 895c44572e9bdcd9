"""What a recorder has to know of a robot: what is published, and the rows by which that is understood. Pure."""

from typing import Any

import msgspec

from lbr.executive.planning.facts import facts
from lbr.executive.planning.plan import Plan
from lbr.messages.camera import JpegFrame

SECRET = frozenset({"user_token"})
"""Tables that leave no robot."""


def streams(plan: Plan) -> dict[str, Any]:
    """Return the streams of a plan, setpoints too, with their schemas, as a `RecordedStreams` is told."""
    found = {}
    for unit in plan.units.values():
        kind = plan.kinds[unit.name]
        for output, wires in unit.config.outputs.items():
            message = kind.outputs.get(output)
            for each in wires:
                found[each.key] = {
                    "key": each.key,
                    "source": unit.name,
                    "message": message.__name__ if message is not None else "",
                    "picture": message is JpegFrame,
                    "schema": kind.schema(output, message) if message is not None else {},
                }
    return {
        "revision": plan.rows.revision,
        "streams": list(found.values()),
        "programs": [row.name for row in plan.rows.external_commands],
    }


def rows(plan: Plan, profile: str) -> dict[str, Any]:
    """Return the rows of a plan and what they mean, as a `RecordedRows` is told."""
    tables = {name: own for name, own in plan.rows.tables.own.items() if name not in SECRET}
    return {
        "revision": plan.rows.revision,
        "facts": msgspec.to_builtins(facts(plan, profile)),
        "tables": tables,
    }
