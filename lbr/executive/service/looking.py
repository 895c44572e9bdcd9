"""One short look at a running robot: its rows, its status, the newest messages of its parts, and its recent events."""

import time

from lbr.bus import keys, latest
from lbr.bus.session import Session
from lbr.executive.planning.facts import facts
from lbr.executive.planning.plan import Plan
from lbr.executive.service.robot import Robot
from lbr.messages.system import Role
from lbr.why import states
from lbr.why.snapshot import LatestMessage, Snapshot

ANSWERS_WITHIN_S = 0.12
"""A running process answers within some milliseconds; one that takes longer is frozen, and reported."""


def look(robot: Robot, bus: Session, *, asker: str = "", role: Role = "admin") -> Snapshot:
    """Return the present state of a robot; from any thread, in a fifth of a second."""
    plan = robot.plan
    messages = latest.ask(bus, streams(plan), source="executive", timeout_s=ANSWERS_WITHIN_S)
    status = robot.status()
    return Snapshot(
        facts=facts(plan, status.profile),
        status=status,
        messages={topic: LatestMessage(message=one.message, age_s=one.age_s) for topic, one in messages.items()},
        events=tuple(robot.recent_events()),
        wall_ns=time.time_ns(),
        asker=asker,
        role=role,
    )


def streams(plan: Plan) -> list[str]:
    """Return the keys of the streams with known types, and of those that operations follow."""
    known = states.understood()
    wanted = {
        keys.port(plan.robot, name, port)
        for name, unit in plan.units.items()
        for port, message in plan.kinds[name].outputs.items()
        if message.__name__ in known and port in unit.config.outputs
    }
    operations = (unit for unit in plan.units.values() if unit.family == "operation")
    heard = {wire.key for unit in operations for wires in unit.config.wiring.values() for wire in wires}
    return sorted(wanted | heard)
