"""The walk from the command to the motor: the links of each part, in the order in which they hold."""

from collections.abc import Iterable, Iterator

from msgspec.structs import replace

from lbr.messages.system import RANKS
from lbr.messages.why import Link, LinkState
from lbr.why import leases, parts, robot, states
from lbr.why.snapshot import Channel, Part, Snapshot

FRESH_S = 3.0
"""A driver's readings come at least ten times a second, a supply's once: an older one has ceased."""


class Walk:
    """Walks once through the hindrances of a part, and of the parts that it needs, each of them once."""

    def __init__(self, snapshot: Snapshot) -> None:
        self.now = snapshot
        self.facts = snapshot.facts
        self._seen: set[str] = set()
        self._moves = False

    def of(self, name: str, *, asked: bool = True) -> Iterator[Link]:
        """Yield the links of a capability; `asked`: the question is about it, not about one that needs it."""
        if name in self._seen:
            return
        self._seen.add(name)
        part = self.facts.parts.get(name)
        if part is None:
            yield _no_row(name)
            return
        yield parts.row(self.now, part)
        if not (part.enabled and part.runs):
            return
        ran = parts.process(self.now, part)
        yield ran
        if part.moves and not self._moves:
            self._moves = True
            yield robot.estop(self.now)
            yield from self._supply()
        if ran.state == "held" or self.now.executive != "up":
            return
        yield from self._needs(part)
        yield from self._inputs(part)
        if (line := parts.line(self.now, part)) is not None:
            yield line
            if line.state == "held":
                return
        for port in part.setpoints:
            yield from self._sender(part, port)
        yield from parts.silence(self.now, part)
        yield from states.links(self.now, part)
        if part.moves:
            yield from leases.refusal(self.now, part)
        yield from self._targets(part, asked=asked)

    def executive(self) -> Iterator[Link]:
        """Yield whether the robot runs, its hindrances, and whether the asker may move it."""
        yield robot.executive(self.now)
        if self.now.executive != "up":
            yield from robot.rows(self.now)
            return
        yield from robot.machine(self.now)
        yield from robot.rows(self.now)

    def edited(self) -> Iterator[Link]:
        """Yield the last edit of the rows that touched a part on the way, or a word that asks it."""
        for event in reversed(self.now.events):
            touched = event.data.get("touched")
            if event.kind == "rows_changed" and isinstance(touched, list) and self._seen.intersection(touched):
                yield Link(
                    "rows",
                    "rows",
                    "ok",
                    f"the rows were changed: {event.text}",
                    since_s=self.now.ago_s(event),
                    evidence="event rows_changed",
                    do="lbr db history shows the change; lbr db undo takes it back",
                )
                return

    def asker(self, part: Part) -> Iterator[Link]:
        """Yield whether the asker may move this part."""
        if part.moves and RANKS[self.now.role] < RANKS["operate"]:
            needed = f"to move '{part.name}' takes 'operate'"
            text = f"who asks has the role '{self.now.role}', which may look and stop; {needed}"
            do = "come in with another token: lbr token add NAME --role operate, at the robot"
            yield Link("asker", self.now.asker, "held", text, "role", do=do)

    def _supply(self) -> Iterator[Link]:
        """Yield what cuts the power of everything that moves: a relay, or a shutdown under way."""
        if self.now.executive != "up":
            return
        for part in self.facts.parts.values():
            if part.runs and {"UpsState", "PowerState"} & set(part.outputs.values()):
                yield from (one for one in states.links(self.now, part) if one.name == "power" and one.state == "held")

    def _needs(self, part: Part) -> Iterator[Link]:
        targets = self._fed(part)
        for need in part.needs:
            if need not in targets:
                yield from self._needed(part, need)

    def _needed(self, part: Part, need: str) -> Iterator[Link]:
        """Yield the links of a needed part; of several cameras, those that are only switched may be off."""
        links = list(self.of(need, asked=False))
        switches = "CamerasState" in part.outputs.values()
        yield from doubted(links) if switches else links

    def _inputs(self, part: Part) -> Iterator[Link]:
        """Yield the sources of a part, and whether they publish: an optional one holds only some motions."""
        for port in part.inputs:
            wires = [one for one in self.facts.channels if one.target == f"{part.name}.{port}"]
            live = [one for one in wires if one.enabled]
            if not live and wires:
                yield self._cut(wires[0], part.name, needed=wires[0].source_part in part.needs)
            for wire in live:
                yield from self._thinned(part, port, wire)
                source = self.facts.parts.get(wire.source_part)
                if source is None or wire.source_part in self._fed(part):
                    continue
                needed = wire.source_part in part.needs
                links = [*self.of(source.name, asked=False), *self._coming(part, wire.source, source)]
                yield from links if needed else doubted(links)

    def _thinned(self, part: Part, port: str, wire: Channel) -> Iterator[Link]:
        """Yield that a channel lets fewer messages through than the part needs."""
        oldest_s = states.oldest_s(part, part.inputs[port])
        if oldest_s is None or wire.rate_hz is None or 1.0 / wire.rate_hz < oldest_s:
            return
        text = (
            f"the channel from {wire.source} to {wire.target} lets {wire.rate_hz:g} messages a second through by its"
            f" row, and '{part.name}' goes by none that is older than {oldest_s:g} s"
        )
        do = self._edited_channel(wire, "rate_hz = NULL")
        row = f"row channel {wire.source} -> {wire.target}: rate_hz"
        yield Link("wire", part.name, "doubt", text, "wiring", evidence=row, do=do)

    def _coming(self, part: Part, end: str, source: Part) -> Iterator[Link]:
        """Yield whether a driver's stream still comes."""
        unit = self.now.unit(source.name)
        if part.family != "operation" or source.family != "driver" or unit is None or unit.phase != "ready":
            return
        topic = end.replace(".", "/")
        newest = self.now.messages.get(topic)
        if newest is None:
            text = f"nothing arrives on {topic}, which '{part.name}' needs"
            yield Link("input", source.name, "doubt", text, "stale_sensor", evidence=topic, do=f"lbr topic hz {topic}")
        elif newest.age_s is not None and newest.age_s > FRESH_S:
            age_s, text = newest.age_s, f"{topic}, which '{part.name}' goes by, is {newest.age_s:.1f} s old"
            link = Link(
                "input", source.name, "held", text, "stale_sensor", evidence=topic, do=f"/restart/{source.name}"
            )
            yield replace(link, since_s=age_s, age_s=age_s)
        else:
            yield Link("input", source.name, "ok", f"{topic} comes", age_s=newest.age_s, evidence=topic)

    def _cut(self, wire: Channel, about: str, *, needed: bool = True) -> Link:
        text = f"the channel from {wire.source} to {wire.target} is switched off by its row: enabled is 0"
        state: LinkState = "held" if needed else "doubt"
        since_s, row = self.now.since_s(wire.target_part, ("stopped",)), f"row channel {wire.source} -> {wire.target}"
        do = self._edited_channel(wire, "enabled = 1")
        return Link("wire", about, state, text, "wiring", since_s=since_s, evidence=row, do=do)

    def _edited_channel(self, wire: Channel, change: str) -> str:
        where = f"source = '{wire.source}' AND target = '{wire.target}'"
        return parts.update("channel", where, self.facts.robot, change)

    def _fed(self, part: Part) -> tuple[str, ...]:
        """Return the capabilities that finally receive a part's setpoint: the last ones of its chain."""
        ends = {
            one.target: one.target_part for one in self.facts.channels if one.source_part == part.name and one.enabled
        }
        there = self.facts.parts
        fed = (name for end, name in ends.items() if name in there and end.partition(".")[2] in there[name].setpoints)
        return tuple(dict.fromkeys(fed))

    def _targets(self, part: Part, *, asked: bool) -> Iterator[Link]:
        """Yield the receivers of a part's setpoint."""
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
            return self._cut(off[0], part.name)
        text = f"no channel takes the setpoint of '{part.name}' to a driver"
        do = f"add a row to channel: source '{part.name}.setpoint', target the driver's setpoint; lbr graph shows all"
        return Link("wire", part.name, "held", text, "wiring", evidence="rows of channel", do=do)

    def _published(self, part: Part) -> Link:
        unit = self.now.unit(part.name)
        rate = unit.rates_hz.get("setpoint", 0.0) if unit is not None else 0.0
        young = unit is not None and (unit.uptime_s or 0.0) < FRESH_S
        if rate > 0.0 or young:
            text = f"its setpoint is sent {rate:.0f} times a second"
            return Link("setpoint", part.name, "ok", text, evidence="@status: rates_hz")
        text, do = f"'{part.name}' sends no setpoint", f"/restart/{part.name}"
        return Link("setpoint", part.name, "held", text, "failed", evidence="@status: rates_hz", do=do)

    def _sender(self, part: Part, port: str) -> Iterator[Link]:
        """Yield the senders of a driver's setpoint, unless the walk came from there."""
        wires = [one for one in self.facts.channels if one.target == f"{part.name}.{port}"]
        live = [one for one in wires if one.enabled]
        if not live and wires:
            yield self._cut(wires[0], part.name)
        elif not live:
            text, do = f"no channel feeds the setpoint of '{part.name}'", "add a row to channel; lbr graph shows all"
            yield Link("wire", part.name, "held", text, "wiring", evidence="rows of channel", do=do)
        for wire in live:
            yield from self.of(wire.source_part, asked=False)


def doubted(links: Iterable[Link]) -> Iterator[Link]:
    """Yield links with `held` weakened to `doubt`: they hold only some of the possible motions."""
    return (replace(one, state="doubt") if one.state == "held" else one for one in links)


def _no_row(name: str) -> Link:
    text = f"there is no row of capability '{name}', and it is needed"
    return Link("row", name, "held", text, "unknown_name", evidence="rows of capability", do="lbr db check")
