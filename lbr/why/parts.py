"""The hindrances of a part itself, as links: its row, its process, and its device's line."""

from collections.abc import Iterator

from lbr.messages.system import CapabilityStatus
from lbr.messages.why import Link, LinkName, LinkState
from lbr.why import states
from lbr.why.snapshot import Part, Snapshot

RECENT_S = 60.0
"""After a minute of health, the executive forgets how a process ended."""
ENDS = ("crashed", "hung", "taken_along", "ended", "failed", "stopped")
UNASKED = ("crashed", "hung", "ended")
OFTEN = 3
"""A process that ends so often within `RECENT_S` will again: more than one mishap, but it is not given up yet."""
REFUSED = ("rights", "busy")
"""Codes of a device that exists, but is not accessible on this machine."""


def row(now: Snapshot, part: Part) -> Link:
    """Return whether its row and the launch profile let it run."""
    evidence = f"row capability.{part.name}"
    if not part.enabled:
        text, since_s = f"'{part.name}' is switched off by its row: enabled is 0", now.since_s(part.name, ("stopped",))
        do = update("capability", f"name = '{part.name}'", now.facts.robot)
        return Link("row", part.name, "held", text, "off", since_s=since_s, evidence=evidence, do=do)
    if not part.runs:
        text, evidence = f"'{part.name}' is left out by the launch profile", f"profile {now.facts.profile}".strip()
        if part.family == "simulation":
            return Link("row", part.name, "ok", f"{text}, which simulates nothing", evidence=evidence)
        do = "take it out of `without`, or into `only`, of the launch profile, and start the robot again"
        return Link("row", part.name, "held", text, "off", evidence=evidence, do=do)
    return Link("row", part.name, "ok", f"enabled, of kind {part.kind}", evidence=evidence)


def process(now: Snapshot, part: Part) -> Link:
    """Return the state of its process, and its recent ends."""
    unit = now.unit(part.name)
    if unit is None and now.executive != "up":
        return Link("process", part.name, "unknown", f"'{part.name}': the state of its process is unknown")
    if unit is None:
        text, do = f"'{part.name}': it has no process", f"/restart/{part.name}"
        return Link("process", part.name, "held", text, "unreachable", evidence="@status", do=do)
    if unit.phase == "degraded" and not part.device:
        return _link(now, part, unit, f"'{part.name}' does not work as it should: {unit.reason}", "degraded")
    if unit.phase in {"ready", "degraded"}:
        return _ready(now, part, unit)
    texts = {
        "waiting": f"'{part.name}' waits to be started",
        "starting": f"'{part.name}' is starting",
        "stopping": f"'{part.name}' is stopping",
        "stopped": f"'{part.name}' is stopped",
        "failed": f"'{part.name}' has failed for good",
    }
    why = unit.reason or unit.last_end
    return _link(now, part, unit, texts[unit.phase] + (f": {why}" if why else ""), *ENDS)


def _ready(now: Snapshot, part: Part, unit: CapabilityStatus) -> Link:
    up_s = unit.uptime_s or 0.0
    lately = unit.last_end and up_s < RECENT_S
    evidence, code = f"@status: {unit.restarts} restarts", unit.end_code or "failed"
    often = sum(one.kind in UNASKED and (now.ago_s(one) or 0.0) <= RECENT_S for one in now.newest(part.name))
    if lately and often >= OFTEN:
        text = f"'{part.name}' ends again and again, {often} times within a minute: {unit.last_end}"
        evidence, do = f"{evidence}; events {' or '.join(UNASKED)}", f"read {_log(now, unit)}, and see what ends it"
        return Link("process", part.name, "doubt", text, code, since_s=unit.uptime_s, evidence=evidence, do=do)
    if lately and not _commanded(now, part, up_s):
        text, do = (
            f"'{part.name}' was started again, what it did is over: {unit.last_end}",
            "say again what it shall do",
        )
        return Link("process", part.name, "past", text, code, since_s=unit.uptime_s, evidence=evidence, do=do)
    text = f"its process is {unit.phase}, pid {unit.pid}"
    return Link("process", part.name, "ok", text, since_s=unit.uptime_s, evidence=evidence)


def _commanded(now: Snapshot, part: Part, within_s: float) -> bool:
    """Return whether a part, or one that needs it, accepted a command lately: then it needs no repetition."""
    over = {part.name}
    while more := {one.name for one in now.facts.parts.values() if over.intersection(one.needs)} - over:
        over |= more
    took = (one for one in now.events if one.kind == "holder" and "took" in one.data and one.subject in over)
    return any((ago_s := now.ago_s(one)) is not None and ago_s < within_s for one in took)


def _log(now: Snapshot, unit: CapabilityStatus) -> str:
    return f"logs/{now.facts.robot}-{unit.process or unit.name}.log"


def _link(now: Snapshot, part: Part, unit: CapabilityStatus, text: str, *kinds: str) -> Link:
    """Return that a process holds a part, since the newest event of some kinds."""
    again = unit.phase in {"waiting", "starting", "stopping"}
    code = unit.code or (unit.end_code if unit.last_end else "") or ("not_ready" if again else "failed")
    log, since_s = _log(now, unit), now.since_s(part.name, kinds)
    evidence = f"@status: phase {unit.phase}, {unit.restarts} restarts"
    do = f"wait; if it lasts, read {log}" if again else f"read {log}, mend it, then /restart/{part.name}"
    return Link("process", part.name, "held", text, code, since_s=since_s, evidence=evidence, do=do)


def line(now: Snapshot, part: Part) -> Link | None:
    """Return whether a driver has its device: its own report while it is degraded, and the device's own faults."""
    unit = now.unit(part.name)
    if not part.device or unit is None:
        return None
    address = now.facts.devices.get(part.device, "")
    evidence = f"@status: {part.name} is {unit.phase}; row device.{part.device} = {address}"
    if unit.phase != "degraded":
        return Link("line", part.device, "ok", f"connected at {address}", since_s=unit.uptime_s, evidence=evidence)
    own, since_s = unit.code not in {"unreachable", *REFUSED, ""}, now.since_s(part.name, ("degraded",))
    name: LinkName = "fault" if own else "port" if unit.code in REFUSED else "line"
    state: LinkState = "doubt" if states.works(now, part) else "held"
    how = "" if own else " works in part" if state == "doubt" else " has no device"
    text, do = f"'{part.name}'{how}: {unit.reason}", "follow that sentence; lbr doctor checks this machine"
    code = unit.code or "unreachable"
    return Link(name, part.device, state, text, code, since_s=since_s, evidence=evidence, do=do)


def silence(now: Snapshot, part: Part) -> Iterator[Link]:
    """Yield that a running part does not answer: it has just been frozen, or the machine is too busy."""
    topics = [f"{part.name}/{port}" for port, name in part.outputs.items() if name in states.understood()]
    unit = now.unit(part.name)
    if not topics or unit is None or unit.phase != "ready" or any(topic in now.messages for topic in topics):
        return
    text = f"'{part.name}' runs and does not answer: it hangs, is starved, or has sent nothing yet"
    evidence, do = f"no answer on {topics[0]}", "ask again in a second: what hangs is ended and started again"
    yield Link("process", part.name, "doubt", text, "timeout", evidence=evidence, do=do)


def update(table: str, where: str, robot: str, column: str = "enabled = 1") -> str:
    """Return the command that changes a row; by default, one that enables it."""
    statement = f"UPDATE {table} SET {column} WHERE robot = '{robot}' AND {where}"  # noqa: S608 - told to people
    return f'sqlite3 ~/.lbr/robot.db "{statement}"'
