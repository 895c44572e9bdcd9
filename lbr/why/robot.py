"""The hindrances of the whole robot, as links: its executive, machine and rows, and the emergency stop."""

from collections.abc import Iterator

from lbr.messages.codes import ReasonCode
from lbr.messages.why import Link, LinkState
from lbr.why.snapshot import Snapshot


def executive(now: Snapshot) -> Link:
    """Return whether it runs and answers."""
    robot, status = now.facts.robot, now.status
    profile = now.facts.profile
    run = f"lbr run {profile}" if profile else "lbr run PROFILE; lbr robots lists what there is"
    if now.executive == "down":
        return _down(now, robot, run)
    if now.executive == "silent":
        text = f"the robot '{robot}' runs and does not answer: its executive hangs, is stopped, or is starved"
        evidence = f"it holds the robot's lock, and did not answer within {now.waited_s:.1f} s"
        do = "lbr stop, then lbr run; a debugger or SIGSTOP may hold its process"
        return Link("executive", "executive", "held", text, "unreachable", evidence=evidence, do=do)
    up_s = status.uptime_s if status is not None else None
    return Link("executive", "executive", "ok", "the robot runs", since_s=up_s, evidence="@status")


def _down(now: Snapshot, robot: str, run: str) -> Link:
    """Return since when it does not run, and whether it was shut down, or its process ended otherwise."""
    facts = now.facts
    in_order = facts.last_shutdown >= facts.last_start
    text = f"the robot '{robot}' does not run on this machine"
    if not facts.last_start:
        text += ": it was never started"
    elif in_order:
        text += ": it was shut down"
    else:
        text += ", and was not shut down: its process was killed, or the machine lost its power"
    code: ReasonCode = "shutting_down" if facts.last_start and in_order else "unreachable"
    since_s = now.ago_iso_s(facts.last_shutdown) if in_order else None
    evidence = "no process holds the robot's lock; last_start and last_shutdown of its row"
    return Link("executive", "executive", "held", text, code, since_s=since_s, evidence=evidence, do=run)


def machine(now: Snapshot) -> Iterator[Link]:
    """Yield that the machine is too busy, while it is: late parts are then not broken."""
    for event in reversed(now.events):
        if event.kind == "busy_over":
            return
        if event.kind == "too_busy":
            evidence, do = "event too_busy", "end what else computes there; lbr status shows who has the processor"
            since_s = now.ago_s(event)
            yield Link("machine", "machine", "doubt", event.text, "busy", since_s=since_s, evidence=evidence, do=do)
            return


def rows(now: Snapshot) -> Iterator[Link]:
    """Yield the faults of its rows."""
    status = now.status
    codes = status.problem_codes if status is not None else ()
    problems = status.problems if status is not None else now.facts.problems
    fault, evidence = ("an edit of the rows is not in force", "@status") if status else ("the rows are bad", "the rows")
    state: LinkState = "doubt" if now.executive == "up" else "held"
    since_s, do = now.since_s("rows", ("rows_refused",)), "correct that row; lbr db check lists all problems"
    for index, problem in enumerate(problems):
        code = codes[index] if index < len(codes) else "bad_value"
        yield Link("rows", "rows", state, f"{fault}: {problem}", code, since_s=since_s, evidence=evidence, do=do)


def estop(now: Snapshot) -> Link:
    """Return whether the emergency stop is latched."""
    status = now.status
    if status is None and now.facts.latched:
        why = now.facts.latched_reason or "no reason given"
        text = f"the emergency stop is latched, by the rows, and stays so after a start: {why}"
        evidence = f"row robot.{now.facts.robot}"
        do = "start the robot, then reset, once nothing is in danger"
        return Link("estop", "estop", "held", text, "estop", evidence=evidence, do=do)
    if status is None:
        return Link("estop", "estop", "unknown", "whether the emergency stop is latched is not known")
    latch = status.estop
    if not latch.engaged:
        return Link("estop", "estop", "ok", "the emergency stop is released", evidence="@status")
    by = f" by {latch.source}" if latch.source else ""
    text = f"the emergency stop is latched{by}: {latch.reason or 'no reason given'}"
    do = "reset, once nothing is in danger"
    if latch.overdue:
        text, do = latch.text, "use the hardware switch"
    since_s = now.since_s("estop", ("estop",)) or now.since_s("executive", ("estop",))
    return Link("estop", "estop", "held", text, "estop", since_s=since_s, evidence="@status: estop", do=do)
