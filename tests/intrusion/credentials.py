"""A3 on this machine: what the credentials of one process are worth, once somebody else has them."""

import json
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, suppress
from itertools import product
from typing import NamedTuple

import zenoh

from lbr.bus import keys, probe, session, stamp, wire
from lbr.bus.access import TOOLS, Credentials
from lbr.capability.config import ProcessConfig
from lbr.errors import BusError
from tests.fuzzing import intruder
from tests.support.bench import Bench, bench
from tests.support.figures import Results
from tests.support.robot import Robot

SETTLE_S = 0.3
ANNEXED = "late"
MARK, LIE = "intruder", "a lie"
STREAMS = ("drive/state", "drive/result", "motors/state", "ranges/readings", "world/pose", "motors/setpoint")
COMMANDS = ("drive/command", "drive/stop", "motors/enable", "world/fault", "world/picture")
SYSTEM = ("@status", "@estop/reset", "@estop/release/motors", "@estop/release/drive", "@estop/ack/motors", "@estop/ack/drive",
          "@console", "@console/view", "@console/operate", "@console/admin", "@edit", "@pair",
          "@console/page/view", "@console/page/admin", "@schema/drive/command")  # fmt: skip
HEARD = ("**", "@status", "@console/**", "@estop/**", "@schema/**")
OWN = ("{name}/found", "{name}/poke")


def credentials(results: Results) -> None:
    """Try everything as a process that is wired to next to nothing: one from the start, one that came by an edit."""
    with bench(results, "spy", edits=intruder.spy_rows()) as under_test:
        under_test.all_ready()
        for row in intruder.spy_rows(ANNEXED):
            under_test.robot.edit(row)
        late = under_test.robot.home / f"{ANNEXED}.json"
        under_test.until(late.exists, 8.0, "the late one's credentials", every_s=0.05)
        under_test.all_ready()
        for name in ("spy", ANNEXED):
            _assault(under_test, intruder.stolen(under_test.robot.home, name), results)
        _doors(under_test.robot, intruder.stolen(under_test.robot.home), results)
        under_test.trace.read()
        moved = [entry for entry in under_test.trace.outputs() if not entry.zero]
        results.check("A3", [f"the outputs were {moved[0]}"] if moved else [])


class Scene(NamedTuple):
    """A robot, its owner's session, and that of somebody who came in as the process of this name."""

    robot: Robot
    owner: session.Session
    intruding: session.Session
    name: str


def _assault(under_test: Bench, config: ProcessConfig, results: Results) -> None:
    """Make every attempt; each tells what went through, or nothing for what did not."""
    robot = under_test.robot
    with ExitStack() as stack:
        owner = stack.enter_context(_as_owner(robot))
        intruding = stack.enter_context(intruder.come_in_as(config))
        scene = Scene(robot, owner, intruding, config.name)
        for attempt in (_writes, _questions, _answers, _liveliness, _reads):
            for text in attempt(scene):
                results.check("A3", [f"{config.name}: {text}"] if text else [])


def _writes(at: Scene) -> Iterator[str]:
    """Put and delete on everybody else's keys; the owner of the robot, who hears all, must hear nothing of it."""
    robot, owner, intruding, name = at.robot, at.owner, at.intruding, at.name
    targets = [f"{robot.name}/{key}" for key in (*STREAMS, *COMMANDS, *SYSTEM)]
    heard: list[str] = []

    def note(sample: zenoh.Sample) -> None:
        attachment = sample.attachment
        if sample.kind == zenoh.SampleKind.DELETE or MARK.encode() in (attachment.to_bytes() if attachment else b""):
            heard.append(str(sample.key_expr))

    listening = [owner.declare_subscriber(key, wire.direct(note)) for key in (*targets, f"{robot.name}/{name}/found")]
    time.sleep(SETTLE_S)
    for key in targets:
        _throw(intruding, key)
    _throw(intruding, f"{robot.name}/{name}/found")
    time.sleep(SETTLE_S)
    for one in listening:
        one.undeclare()
    yield from (f"a put on {key} went through" if key in heard else "" for key in targets)
    if f"{robot.name}/{name}/found" not in heard:
        yield "its own output does not go through, so nothing was tried"


def _throw(bus: session.Session, key: str) -> None:
    for body in ({"power": 0.4, "angle_deg": 90}, {"left": 0.4, "right": 0.4}, {"engaged": False}):
        payload = wire.encode(body)
        bus.put(
            key,
            payload,
            attachment=stamp.make(MARK, 1, payload, b"x" * 32),
            congestion_control=zenoh.CongestionControl.BLOCK,
        )
    bus.delete(key)


def _questions(at: Scene) -> Iterator[str]:
    """Ask whatever answers the owner; also with wildcards, and where Zenoh tells of itself."""
    robot, intruding, name = at.robot, at.intruding, at.name
    asked = (*COMMANDS, *SYSTEM, "drive/state", "*/*", "**")
    for key in (*(f"{robot.name}/{one}" for one in asked), "@/**", "**", "*/@status"):
        allowed = {f"{robot.name}/drive/state", *(f"{robot.name}/{one.format(name=name)}" for one in OWN)}
        own = f"@/{intruding.zid()}/"  # a session tells itself of itself
        found = {raw.key for raw in _ask(intruding, key) if not raw.key.startswith(own)} - allowed
        yield f"the question {key} was answered on {', '.join(sorted(found))}" if found else ""


def _ask(bus: session.Session, key: str) -> list[wire.RawMessage]:
    with suppress(BusError):
        return wire.ask(bus, key, {}, source=MARK, timeout_s=0.4)
    return []


def _all(bus: session.Session, key: str) -> list[wire.RawMessage]:
    return probe.survey(bus, key, source=MARK, timeout_s=0.4)


def _answers(at: Scene) -> Iterator[str]:
    """Offer to answer in others' names; who asks must not be told lies."""
    robot, owner, intruding, name = at.robot, at.owner, at.intruding, at.name
    lie = json.dumps({"accepted": True, "reason": LIE}).encode()

    def answer(query: zenoh.Query) -> None:
        with query:
            query.reply(query.key_expr, lie)

    taken = [f"{robot.name}/{key}" for key in (*STREAMS, *COMMANDS, *SYSTEM, "nobody/here")]
    offers = [
        intruding.declare_queryable(key, wire.direct(answer))
        for key in (*taken, f"{robot.name}/{name}/poke", f"{robot.name}/**")
    ]
    time.sleep(SETTLE_S)
    own = f"{robot.name}/{name}/poke"
    if not any(LIE.encode() in raw.payload for raw in _all(owner, own)):
        yield "it cannot answer in its own name, so nothing was tried"
    for asking in (owner, robot.bus):
        for key in taken:
            lied = any(LIE.encode() in raw.payload for raw in (*_ask(asking, key), *_all(asking, key)))
            yield f"it answers in the name of {key}" if lied else ""
    for offer in offers:
        offer.undeclare()


def _liveliness(at: Scene) -> Iterator[str]:
    """Pretend that somebody is there who is not."""
    robot, owner, intruding = at.robot, at.owner, at.intruding
    forged = [keys.alive(robot.name, one) for one in ("motors", "drive", "ghost")]
    tokens = [intruding.liveliness().declare_token(key) for key in forged]
    time.sleep(SETTLE_S)
    there = [str(reply.ok.key_expr) for reply in owner.liveliness().get(f"{robot.name}/@alive/*") if reply.ok]
    for token in tokens:
        token.undeclare()
    yield "a forged presence is believed" if f"{robot.name}/@alive/ghost" in there else ""


def _reads(at: Scene) -> Iterator[str]:
    """Listen to everything; only what is wired to it may be heard, and presses of the emergency stop."""
    robot, intruding, name = at.robot, at.intruding, at.name
    heard: set[str] = set()

    def note(sample: zenoh.Sample) -> None:
        heard.add(str(sample.key_expr))

    listening = [intruding.declare_subscriber(f"{robot.name}/{key}", wire.direct(note)) for key in HEARD]
    listening += [intruding.declare_subscriber(f"{robot.name}/{key}", wire.direct(note)) for key in STREAMS]
    time.sleep(2 * SETTLE_S)
    for one in listening:
        one.undeclare()
    wired = f"{robot.name}/drive/state"
    yield from (
        f"it hears {key}" for key in sorted(heard - {wired, keys.estop(robot.name), f"{robot.name}/{name}/poke"})
    )
    if wired not in heard:
        yield "it does not hear what is wired to it, so nothing was tried"


def _doors(robot: Robot, config: ProcessConfig, results: Results) -> None:
    """Knock with no password, a wrong one, another's name, and a name that has gone."""
    assert config.credentials is not None
    own = config.credentials
    tries: dict[str, Callable[[], Credentials | None]] = {
        "no password": lambda: None,
        "a wrong password": lambda: Credentials(user=own.user, password=own.password[::-1]),
        "no password at all": lambda: Credentials(user=own.user, password=""),
        "another's name": lambda: Credentials(user="drive", password=own.password),
        "the tools' name": lambda: Credentials(user=TOOLS, password=own.password),
        "the executive's name": lambda: Credentials(user="@executive", password=own.password),
        "nobody's name": lambda: Credentials(user="ghost", password=own.password),
    }

    def knock(endpoint: str, what: str) -> str:
        with suppress(BusError), session.open_client([endpoint], tries[what](), timeout_s=0.5) as bus:
            if _ask(bus, f"{robot.name}/@status") or _ask(bus, f"{robot.name}/drive/state"):
                return f"{what} comes in at {endpoint} and is answered"
        return ""

    with ThreadPoolExecutor(len(tries)) as pool:  # who is refused waits in vain
        for text in pool.map(knock, *zip(*product(_inner(robot), tries), strict=True)):
            results.check("A3", [text] if text else [])


def _inner(robot: Robot) -> list[str]:
    """Return the endpoints that ask for a password: core and annexes."""
    run = robot.home / "run"
    found = sorted(path for path in run.glob(f"{robot.name}.*.sock") if path.is_socket())
    assert len(found) >= 2, "core and annex"
    return [f"unixsock-stream/{path}" for path in found]


def _as_owner(robot: Robot) -> session.Session:
    record = json.loads((robot.home / "run" / f"{robot.name}.json").read_text())
    return session.open_client([record["core"]], Credentials(user=TOOLS, password=record["password"]))
