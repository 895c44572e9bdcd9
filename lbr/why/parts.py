"""The hindrances of a part itself, as links: its row, its process, and its device's line."""

from collections.abc import Iterator

from lbr.messages.system import CapabilityStatus
from lbr.messages.why import Link
from lbr.why import said
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
    if not part.enabled:
        return Link(
            "row",
            part.name,
            "held",
            f"'{part.name}' is switched off by its row: enabled is 0",
            "off",
            since_s=now.since_s(part.name, ("stopped",)),
            evidence=f"row capability.{part.name}",
            do=update("capability", f"name = '{part.name}'", now.facts.robot),
        )
    if not part.runs:
        simulated = part.family == "simulation"
        text = f"'{part.name}' is left out by the launch profile"
        return Link(
            "row",
            part.name,
            "ok" if simulated else "held",
            f"{text}, which simulates nothing" if simulated else text,
            "" if simulated else "off",
            evidence=f"profile {now.facts.profile}".strip(),
            do=""
            if simulated
            else "take it out of `without`, or into `only`, of the launch profile, and start the robot again",
        )
    return Link("row", part.name, "ok", f"enabled, of kind {part.kind}", evidence=f"row capability.{part.name}")


def process(now: Snapshot, part: Part) -> Link:
    """Return the state of its process, and its recent ends."""
    unit = now.unit(part.name)
    if unit is None:
        nothing = "the state of its process is unknown" if now.executive != "up" else "it has no process"
        held = now.executive == "up"
        return Link(
            "process",
            part.name,
            "held" if held else "unknown",
            f"'{part.name}': {nothing}",
            "unreachable" if held else "",
            evidence="@status" if held else "",
            do=f"/restart/{part.name}" if held else "",
        )
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
    text = f"its process is {unit.phase}, pid {unit.pid}"
    often = sum(one.kind in UNASKED and (now.ago_s(one) or 0.0) <= RECENT_S for one in now.newest(part.name))
    if lately and often >= OFTEN:
        return Link(
            "process",
            part.name,
            "doubt",
            f"'{part.name}' ends again and again, {often} times within a minute: {unit.last_end}",
            unit.end_code or "failed",
            since_s=unit.uptime_s,
            evidence=f"@status: {unit.restarts} restarts; events {' or '.join(UNASKED)}",
            do=f"read {_log(now, unit)}, and see what ends it",
        )
    lately = lately and not _commanded(now, part, up_s)
    if lately:
        text = f"'{part.name}' was started again, what it did is over: {unit.last_end}"
    return Link(
        "process",
        part.name,
        "past" if lately else "ok",
        text,
        unit.end_code or "failed" if lately else "",
        since_s=unit.uptime_s,
        evidence=f"@status: {unit.restarts} restarts",
        do="say again what it shall do" if lately else "",
    )


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
    log = _log(now, unit)
    return Link(
        "process",
        part.name,
        "held",
        text,
        code,
        since_s=now.since_s(part.name, kinds),
        evidence=f"@status: phase {unit.phase}, {unit.restarts} restarts",
        do=f"wait; if it lasts, read {log}" if again else f"read {log}, mend it, then /restart/{part.name}",
    )


def line(now: Snapshot, part: Part) -> Link | None:
    """Return whether a driver has its device: its own report while it is degraded, and the device's own faults."""
    unit = now.unit(part.name)
    if not part.device or unit is None:
        return None
    address = now.facts.devices.get(part.device, "")
    evidence = f"@status: {part.name} is {unit.phase}; row device.{part.device} = {address}"
    if unit.phase != "degraded":
        return Link("line", part.device, "ok", f"connected at {address}", since_s=unit.uptime_s, evidence=evidence)
    own = unit.code not in {"unreachable", *REFUSED, ""}
    works = said.works(now, part)
    return Link(
        "fault" if own else "port" if unit.code in REFUSED else "line",
        part.device,
        "doubt" if works else "held",
        f"'{part.name}' {'works in part' if works else 'has no device'}: {unit.reason}"
        if not own
        else f"'{part.name}': {unit.reason}",
        unit.code or "unreachable",
        since_s=now.since_s(part.name, ("degraded",)),
        evidence=evidence,
        do="follow that sentence; lbr doctor checks this machine",
    )


def silence(now: Snapshot, part: Part) -> Iterator[Link]:
    """Yield that a running part does not answer: it has just been frozen, or the machine is too busy."""
    topics = [f"{part.name}/{port}" for port, name in part.outputs.items() if name in said.understood()]
    unit = now.unit(part.name)
    if not topics or unit is None or unit.phase != "ready" or any(topic in now.messages for topic in topics):
        return
    yield Link(
        "process",
        part.name,
        "doubt",
        f"'{part.name}' runs and does not answer: it hangs, is starved, or has sent nothing yet",
        "timeout",
        evidence=f"no answer on {topics[0]}",
        do="ask again in a second: what hangs is ended and started again",
    )


def update(table: str, where: str, robot: str, column: str = "enabled = 1") -> str:
    """Return the command that changes a row; by default, one that enables it."""
    statement = f"UPDATE {table} SET {column} WHERE robot = '{robot}' AND {where}"  # noqa: S608 - told to people
    return f'sqlite3 ~/.lbr/robot.db "{statement}"'
