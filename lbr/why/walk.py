"""The walk from what was asked to what moves: the links that every part has, in the order in which they hold."""

from collections.abc import Iterable, Iterator

from msgspec.structs import replace

from lbr.messages.system import RANKS, CapabilityStatus
from lbr.messages.why import Link
from lbr.why import leases, said
from lbr.why.snapshot import Channel, Part, Snapshot

FRESH_S = 3.0
"""What a driver measures comes ten times a second and more, a supply's values once: older than this, it has ceased."""
RECENT_S = 60.0
"""After a minute of health the executive forgets how a process ended."""
ENDS = ("crashed", "hung", "taken_along", "ended", "failed", "stopped")
UNASKED = ("crashed", "hung", "ended")
OFTEN = 3
"""A process that ends so often within `RECENT_S` will again: more than one mishap, fewer than have it given up."""
REFUSED = ("rights", "busy")
"""Codes of a device that is there, and that this machine does not give."""


class Walk:
    """Walks once through what holds a part, and through what that part needs, each of these once."""

    def __init__(self, snapshot: Snapshot) -> None:
        self.now = snapshot
        self.facts = snapshot.facts
        self._seen: set[str] = set()
        self._moves = False

    def of(self, name: str, *, asked: bool = True) -> Iterator[Link]:
        """Yield the links of a capability; `asked`: it is the one that was asked for, not one that this one needs."""
        if name in self._seen:
            return
        self._seen.add(name)
        part = self.facts.parts.get(name)
        if part is None:
            yield _no_row(name)
            return
        yield self._row(part)
        if not (part.enabled and part.runs):
            return
        process = self._process(part)
        yield process
        if part.moves and not self._moves:
            self._moves = True
            yield self._estop()
            yield from self._supply()
        if process.state == "held" or self.now.executive != "up":
            return
        yield from self._needs(part)
        yield from self._inputs(part)
        if (line := self._line(part)) is not None:
            yield line
            if line.state == "held":
                return
        for port in part.setpoints:
            yield from self._sender(part, port)
        yield from self._silence(part)
        yield from said.links(self.now, part)
        if part.moves:
            yield from leases.refusal(self.now, part)
        yield from self._targets(part, asked=asked)

    def executive(self) -> Iterator[Link]:
        """Yield whether the robot runs at all, what hinders it, and whether who asks may move it."""
        yield self._executive()
        if self.now.executive != "up":
            yield from self._rows()
            return
        yield from self._machine()
        yield from self._rows()

    def edited(self) -> Iterator[Link]:
        """Yield the last edit of the rows that touched a part on the way, or only words, which are no process."""
        for event in reversed(self.now.events):
            touched = event.data.get("touched")
            if event.kind != "rows_changed" or not isinstance(touched, list):
                continue
            if not touched or self._seen.intersection(touched):
                yield Link(
                    name="rows",
                    about="rows",
                    state="ok",
                    text=f"the rows were changed: {event.text}",
                    since_s=self.now.ago_s(event),
                    evidence="event rows_changed",
                    do="lbr db history tells what was changed; lbr db undo takes it back",
                )
                return

    def asker(self, part: Part) -> Iterator[Link]:
        """Yield whether who asks may move this part."""
        if part.moves and RANKS[self.now.role] < RANKS["operate"]:
            text = f"who asks has the role '{self.now.role}', which may look and stop; to move '{part.name}' takes 'operate'"
            do = "come in with another token: lbr token add NAME --role operate, at the robot"
            yield Link(name="asker", about=self.now.asker, state="held", text=text, code="role", do=do)

    def _executive(self) -> Link:
        robot, status = self.facts.robot, self.now.status
        profile = self.facts.profile
        run = f"lbr run {profile}" if profile else "lbr run PROFILE; lbr robots lists what there is"
        if self.now.executive == "down":
            return self._down(robot, run)
        if self.now.executive == "silent":
            text = f"the robot '{robot}' runs and does not answer: its executive hangs, is stopped, or is starved"
            evidence = f"it holds the robot's lock, and did not answer within {self.now.waited_s:.1f} s"
            do = "lbr stop, then lbr run; a debugger or SIGSTOP may hold its process"
            return Link(
                name="executive",
                about="executive",
                state="held",
                text=text,
                code="unreachable",
                evidence=evidence,
                do=do,
            )
        up_s = status.uptime_s if status is not None else None
        return Link(
            name="executive", about="executive", state="ok", text="the robot runs", since_s=up_s, evidence="@status"
        )

    def _down(self, robot: str, run: str) -> Link:
        """Tell since when it does not run: it was shut down, or its process came to an end otherwise."""
        facts = self.facts
        in_order = facts.last_shutdown >= facts.last_start
        text = f"the robot '{robot}' does not run on this machine"
        if not facts.last_start:
            text += ": it was never started"
        elif in_order:
            text += ": it was shut down"
        else:
            text += ", and was not shut down: its process was killed, or the machine lost its power"
        return Link(
            name="executive",
            about="executive",
            state="held",
            text=text,
            code="shutting_down" if facts.last_start and in_order else "unreachable",
            since_s=self.now.ago_iso_s(facts.last_shutdown) if in_order else None,
            evidence="no process holds the robot's lock; last_start and last_shutdown of its row",
            do=run,
        )

    def _machine(self) -> Iterator[Link]:
        """Tell that the machine is too busy, while it is: what is late then is not broken."""
        for event in reversed(self.now.events):
            if event.kind == "busy_over":
                return
            if event.kind == "too_busy":
                yield Link(
                    name="machine",
                    about="machine",
                    state="doubt",
                    text=event.text,
                    code="busy",
                    since_s=self.now.ago_s(event),
                    evidence="event too_busy",
                    do="end what else computes there; lbr status shows who has the processor",
                )
                return

    def _rows(self) -> Iterator[Link]:
        status = self.now.status
        codes = status.problem_codes if status is not None else ()
        problems = status.problems if status is not None else self.facts.problems
        for index, problem in enumerate(problems):
            yield Link(
                name="rows",
                about="rows",
                state="doubt" if self.now.executive == "up" else "held",
                text=f"an edit of the rows is not in force: {problem}"
                if status is not None
                else f"the rows are bad: {problem}",
                code=codes[index] if index < len(codes) else "bad_value",
                since_s=self.now.since_s("rows", ("rows_refused",)),
                evidence="@status" if status is not None else "the rows",
                do="correct that row; lbr db check tells of all",
            )

    def _row(self, part: Part) -> Link:
        if not part.enabled:
            return Link(
                name="row",
                about=part.name,
                state="held",
                text=f"'{part.name}' is switched off by its row: enabled is 0",
                code="off",
                since_s=self.now.since_s(part.name, ("stopped",)),
                evidence=f"row capability.{part.name}",
                do=enable("capability", f"name = '{part.name}'", self.facts.robot),
            )
        if not part.runs:
            simulated = part.family == "simulation"
            text = f"'{part.name}' is left out by the launch profile"
            return Link(
                name="row",
                about=part.name,
                state="ok" if simulated else "held",
                text=f"{text}, which simulates nothing" if simulated else text,
                code="" if simulated else "off",
                evidence=f"profile {self.facts.profile}".strip(),
                do=""
                if simulated
                else "take it out of `without`, or into `only`, of the launch profile, and start the robot again",
            )
        return Link(
            name="row",
            about=part.name,
            state="ok",
            text=f"enabled, of kind {part.kind}",
            evidence=f"row capability.{part.name}",
        )

    def _process(self, part: Part) -> Link:
        unit = self.now.unit(part.name)
        if unit is None:
            nothing = "nothing says how its process is" if self.now.executive != "up" else "it has no process"
            held = self.now.executive == "up"
            return Link(
                name="process",
                about=part.name,
                state="held" if held else "unknown",
                text=f"'{part.name}': {nothing}",
                code="unreachable" if held else "",
                evidence="@status" if held else "",
                do=f"/restart/{part.name}" if held else "",
            )
        if unit.phase == "degraded" and not part.device:
            return self._link(part, unit, "degraded", f"'{part.name}' does not work as it should: {unit.reason}")
        if unit.phase in {"ready", "degraded"}:
            return self._ready(part, unit)
        texts = {
            "waiting": f"'{part.name}' waits to be started",
            "starting": f"'{part.name}' is starting",
            "stopping": f"'{part.name}' is stopping",
            "stopped": f"'{part.name}' is stopped",
            "failed": f"'{part.name}' has failed for good",
        }
        why = unit.reason or unit.last_end
        return self._link(part, unit, *ENDS, text=texts[unit.phase] + (f": {why}" if why else ""))

    def _ready(self, part: Part, unit: CapabilityStatus) -> Link:
        up_s = unit.uptime_s or 0.0
        lately = unit.last_end and up_s < RECENT_S
        text = f"its process is {unit.phase}, pid {unit.pid}"
        often = sum(
            one.kind in UNASKED and (self.now.ago_s(one) or 0.0) <= RECENT_S for one in self.now.newest(part.name)
        )
        if lately and often >= OFTEN:
            return Link(
                name="process",
                about=part.name,
                state="doubt",
                text=f"'{part.name}' ends again and again, {often} times within a minute: {unit.last_end}",
                code=unit.end_code or "failed",
                since_s=unit.uptime_s,
                evidence=f"@status: {unit.restarts} restarts; events {' or '.join(UNASKED)}",
                do=f"read {self._log(unit)}, and see what ends it",
            )
        lately = lately and not self._commanded(part, up_s)
        if lately:
            text = f"'{part.name}' was started again, what it did is over: {unit.last_end}"
        return Link(
            name="process",
            about=part.name,
            state="past" if lately else "ok",
            text=text,
            code=unit.end_code or "failed" if lately else "",
            since_s=unit.uptime_s,
            evidence=f"@status: {unit.restarts} restarts",
            do="say again what it shall do" if lately else "",
        )

    def _commanded(self, part: Part, within_s: float) -> bool:
        """Say whether a part, or one that needs it, took a command of late: then nothing is to be said again."""
        over = {part.name}
        while more := {one.name for one in self.facts.parts.values() if over.intersection(one.needs)} - over:
            over |= more
        took = (one for one in self.now.events if one.kind == "holder" and "took" in one.data and one.subject in over)
        return any((ago_s := self.now.ago_s(one)) is not None and ago_s < within_s for one in took)

    def _log(self, unit: CapabilityStatus) -> str:
        return f"logs/{self.facts.robot}-{unit.process or unit.name}.log"

    def _link(self, part: Part, unit: CapabilityStatus, *kinds: str, text: str = "") -> Link:
        kinds, text = (kinds, text) if text else (kinds[:-1], kinds[-1])
        again = unit.phase in {"waiting", "starting", "stopping"}
        code = unit.code or (unit.end_code if unit.last_end else "") or ("not_ready" if again else "failed")
        log = self._log(unit)
        return Link(
            name="process",
            about=part.name,
            state="held",
            text=text,
            code=code,
            since_s=self.now.since_s(part.name, kinds),
            evidence=f"@status: phase {unit.phase}, {unit.restarts} restarts",
            do=f"wait; if it lasts, read {log}" if again else f"read {log}, mend it, then /restart/{part.name}",
        )

    def _estop(self) -> Link:
        status = self.now.status
        if status is None and self.facts.latched:
            why = self.facts.latched_reason or "no reason given"
            text = f"the emergency stop is latched, by the rows, and stays so after a start: {why}"
            evidence = f"row robot.{self.facts.robot}"
            do = "start the robot, then reset, once nothing is in danger"
            return Link(name="estop", about="estop", state="held", text=text, code="estop", evidence=evidence, do=do)
        if status is None:
            return Link(
                name="estop", about="estop", state="unknown", text="whether the emergency stop is latched is not known"
            )
        latch = status.estop
        if not latch.engaged:
            return Link(
                name="estop", about="estop", state="ok", text="the emergency stop is released", evidence="@status"
            )
        by = f" by {latch.source}" if latch.source else ""
        return Link(
            name="estop",
            about="estop",
            state="held",
            text=f"the emergency stop is latched{by}: {latch.reason or 'no reason given'}",
            code="estop",
            since_s=self.now.since_s("estop", ("estop",)) or self.now.since_s("executive", ("estop",)),
            evidence="@status: estop",
            do="reset, once nothing is in danger",
        )

    def _supply(self) -> Iterator[Link]:
        """Yield what cuts the power of all that moves: a relay, or a shutdown that has begun."""
        if self.now.executive != "up":
            return
        for part in self.facts.parts.values():
            if part.runs and {"UpsState", "PowerState"} & set(part.outputs.values()):
                yield from (one for one in said.links(self.now, part) if one.name == "power" and one.state == "held")

    def _needs(self, part: Part) -> Iterator[Link]:
        targets = self._fed(part)
        for need in part.needs:
            if need not in targets:
                yield from self._needed(part, need)

    def _needed(self, part: Part, need: str) -> Iterator[Link]:
        """Yield the links of what a part needs; a camera among several that it only switches may be off."""
        links = list(self.of(need, asked=False))
        switches = "CamerasState" in part.outputs.values()
        yield from doubted(links) if switches else links

    def _inputs(self, part: Part) -> Iterator[Link]:
        """Yield who feeds a part, and whether that comes: what it does not need holds only some of what it does."""
        for port in part.inputs:
            wires = [one for one in self.facts.channels if one.target == f"{part.name}.{port}"]
            live = [one for one in wires if one.enabled]
            if not live and wires:
                yield self._cut(part, port, wires[0].source, wires[0].source_part in part.needs)
            for wire in live:
                yield from self._thinned(part, port, wire)
                source = self.facts.parts.get(wire.source_part)
                if source is None or wire.source_part in self._fed(part):
                    continue
                needed = wire.source_part in part.needs
                links = [*self.of(source.name, asked=False), *self._coming(part, wire.source, source)]
                yield from links if needed else doubted(links)

    def _thinned(self, part: Part, port: str, wire: Channel) -> Iterator[Link]:
        """Yield that a channel lets less through than the part may do without."""
        oldest_s = said.oldest_s(part, part.inputs[port])
        if oldest_s is None or wire.rate_hz is None or 1.0 / wire.rate_hz < oldest_s:
            return
        row = f"robot = '{self.facts.robot}' AND source = '{wire.source}' AND target = '{wire.target}'"
        yield Link(
            name="wire",
            about=part.name,
            state="doubt",
            text=f"the channel from {wire.source} to {wire.target} lets {wire.rate_hz:g} messages a second through by its"
            f" row, and '{part.name}' goes by none that is older than {oldest_s:g} s",
            code="wiring",
            evidence=f"row channel {wire.source} -> {wire.target}: rate_hz",
            do=f'sqlite3 ~/.lbr/robot.db "UPDATE channel SET rate_hz = NULL WHERE {row}"',  # noqa: S608 - told to people
        )

    def _coming(self, part: Part, end: str, source: Part) -> Iterator[Link]:
        """Yield whether a driver's stream still comes."""
        unit = self.now.unit(source.name)
        if part.family != "operation" or source.family != "driver" or unit is None or unit.phase != "ready":
            return
        topic = end.replace(".", "/")
        found = self.now.said.get(topic)
        if found is None:
            text = f"nothing is heard on {topic}, which '{part.name}' goes by"
            yield Link(
                name="input",
                about=source.name,
                state="doubt",
                text=text,
                code="stale_sensor",
                evidence=topic,
                do=f"lbr topic hz {topic}",
            )
        elif found.age_s is not None and found.age_s > FRESH_S:
            text = f"{topic}, which '{part.name}' goes by, is {found.age_s:.1f} s old"
            yield Link(
                name="input",
                about=source.name,
                state="held",
                text=text,
                code="stale_sensor",
                since_s=found.age_s,
                age_s=found.age_s,
                evidence=topic,
                do=f"/restart/{source.name}",
            )
        else:
            yield Link(
                name="input", about=source.name, state="ok", text=f"{topic} comes", age_s=found.age_s, evidence=topic
            )

    def _cut(self, part: Part, port: str, source: str, needed: bool) -> Link:
        text = f"the channel from {source} to {part.name}.{port} is switched off by its row: enabled is 0"
        where = f"source = '{source}' AND target = '{part.name}.{port}'"
        return Link(
            name="wire",
            about=part.name,
            state="held" if needed else "doubt",
            text=text,
            code="wiring",
            since_s=self.now.since_s(part.name, ("stopped",)),
            evidence=f"row channel {source} -> {part.name}.{port}",
            do=enable("channel", where, self.facts.robot),
        )

    def _fed(self, part: Part) -> tuple[str, ...]:
        """Return the capabilities whose setpoint a part feeds: the last ones of its chain."""
        ends = {
            one.target: one.target_part for one in self.facts.channels if one.source_part == part.name and one.enabled
        }
        parts = self.facts.parts
        fed = (name for end, name in ends.items() if name in parts and end.partition(".")[2] in parts[name].setpoints)
        return tuple(dict.fromkeys(fed))

    def _silence(self, part: Part) -> Iterator[Link]:
        """Yield that a part which runs does not answer: it has just been frozen, or the machine leaves it no time."""
        topics = [f"{part.name}/{port}" for port, name in part.outputs.items() if name in said.understood()]
        unit = self.now.unit(part.name)
        if not topics or unit is None or unit.phase != "ready" or any(topic in self.now.said for topic in topics):
            return
        yield Link(
            name="process",
            about=part.name,
            state="doubt",
            text=f"'{part.name}' runs and does not answer: it hangs, is starved, or has said nothing yet",
            code="timeout",
            evidence=f"no answer on {topics[0]}",
            do="ask again in a second: what hangs is ended and started again",
        )

    def _targets(self, part: Part, *, asked: bool) -> Iterator[Link]:
        """Yield where a part's setpoint goes."""
        targets = self._fed(part)
        if "setpoint" in part.outputs and not targets:
            yield self._unsent(part)
        for target in targets:
            if asked:
                yield self._published(part)
            yield from self.of(target, asked=False)

    def _unsent(self, part: Part) -> Link:
        off = [one for one in self.facts.channels if one.source == f"{part.name}.setpoint" and not one.enabled]
        if off:
            return replace(
                self._cut(
                    self.facts.parts.get(off[0].target_part, part), off[0].target.partition(".")[2], off[0].source, True
                ),
                about=part.name,
            )
        return Link(
            name="wire",
            about=part.name,
            state="held",
            text=f"no channel takes the setpoint of '{part.name}' to a driver",
            code="wiring",
            evidence="rows of channel",
            do=f"add a row to channel: source '{part.name}.setpoint', target the driver's setpoint; lbr graph shows all",
        )

    def _published(self, part: Part) -> Link:
        unit = self.now.unit(part.name)
        rate = unit.rates_hz.get("setpoint", 0.0) if unit is not None else 0.0
        young = unit is not None and (unit.uptime_s or 0.0) < FRESH_S
        if rate > 0.0 or young:
            return Link(
                name="setpoint",
                about=part.name,
                state="ok",
                text=f"its setpoint is sent {rate:.0f} times a second",
                evidence="@status: rates_hz",
            )
        text = f"'{part.name}' sends no setpoint"
        return Link(
            name="setpoint",
            about=part.name,
            state="held",
            text=text,
            code="failed",
            evidence="@status: rates_hz",
            do=f"/restart/{part.name}",
        )

    def _sender(self, part: Part, port: str) -> Iterator[Link]:
        """Yield who sends a driver's setpoint, where that is not how we came here."""
        wires = [one for one in self.facts.channels if one.target == f"{part.name}.{port}"]
        live = [one for one in wires if one.enabled]
        if not live:
            if wires:
                yield self._cut(part, port, wires[0].source, True)
            else:
                text = f"no channel feeds the setpoint of '{part.name}'"
                yield Link(
                    name="wire",
                    about=part.name,
                    state="held",
                    text=text,
                    code="wiring",
                    evidence="rows of channel",
                    do="add a row to channel; lbr graph shows all",
                )
        for wire in live:
            yield from self.of(wire.source_part, asked=False)

    def _line(self, part: Part) -> Link | None:
        """Tell whether a driver has its device: what it says while it is degraded, and the device's own faults."""
        unit = self.now.unit(part.name)
        if not part.device or unit is None:
            return None
        address = self.facts.devices.get(part.device, "")
        evidence = f"@status: {part.name} is {unit.phase}; row device.{part.device} = {address}"
        if unit.phase != "degraded":
            return Link(
                name="line",
                about=part.device,
                state="ok",
                text=f"connected at {address}",
                since_s=unit.uptime_s,
                evidence=evidence,
            )
        own = unit.code not in {"unreachable", *REFUSED, ""}
        works = said.works(self.now, part)
        return Link(
            name="fault" if own else "port" if unit.code in REFUSED else "line",
            about=part.device,
            state="doubt" if works else "held",
            text=f"'{part.name}' {'works in part' if works else 'has no device'}: {unit.reason}"
            if not own
            else f"'{part.name}': {unit.reason}",
            code=unit.code or "unreachable",
            since_s=self.now.since_s(part.name, ("degraded",)),
            evidence=evidence,
            do="what it says; lbr doctor looks at this machine's side of it",
        )


def doubted(links: Iterable[Link]) -> Iterator[Link]:
    """Yield links of what holds only some of what may be asked."""
    return (replace(one, state="doubt") if one.state == "held" else one for one in links)


def _no_row(name: str) -> Link:
    text = f"there is no row of capability '{name}', and it is needed"
    return Link(
        name="row",
        about=name,
        state="held",
        text=text,
        code="unknown_name",
        evidence="rows of capability",
        do="lbr db check",
    )


def enable(table: str, where: str, robot: str) -> str:
    """Return what to type to switch a row on."""
    return f"sqlite3 ~/.lbr/robot.db \"UPDATE {table} SET enabled = 1 WHERE robot = '{robot}' AND {where}\""  # noqa: S608 - told to people
