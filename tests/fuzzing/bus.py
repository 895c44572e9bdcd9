"""Z4: payloads, attachments and encodings by chance, on every key and through every door, and garbage at the sockets."""

import json
import random
import socket

import zenoh

from lbr.bus import probe, stamp
from lbr.bus.session import Session
from tests.fuzzing import intruder, sockets
from tests.fuzzing.mutation import NASTY, SPLINTERS, mutated, noise
from tests.support.bench import Bench, bench, processes_of
from tests.support.figures import Results

BLOCK = zenoh.CongestionControl.BLOCK
LINK_SHARE = 20
MEGABYTE = 1 << 20
LARGEST = 100_000
STEP = 200
ASK_S = 0.3
ENCODINGS = (
    zenoh.Encoding.APPLICATION_JSON, zenoh.Encoding.IMAGE_JPEG, zenoh.Encoding.ZENOH_BYTES, zenoh.Encoding.TEXT_PLAIN,
    zenoh.Encoding("application/json;charset=utf-16"), zenoh.Encoding("x" * 200), zenoh.Encoding("\u202e\x00"),
)  # fmt: skip
_STILL: dict[str, dict[str, float]] = {
    "command": {"power": 0.0, "angle_deg": 0},
    "twist": {"vx_mps": 0.0, "vy_mps": 0.0, "wz_rps": 0.0},
}
"""The only drive commands with sense: what is thrown may be taken, and must never be why a motor turns."""
_ASKING = ("power", "vx_mps", "vy_mps", "wz_rps")


def messages(results: Results, n: int, dice: random.Random) -> None:
    """Throw `n` messages, and `n / 20` connections; then the robot must be as it was, and drive."""
    port = _free_port()
    settings = json.dumps({"listen": [f"tls/127.0.0.1:{port}"]})
    listen = (
        f"INSERT OR REPLACE INTO capability (robot, name, kind, settings) VALUES ('lbr', 'lan', 'lan', '{settings}')"
    )
    with bench(results, "spy", edits=(*intruder.spy_rows(), listen)) as under_test:
        robot = under_test.robot
        under_test.all_ready()
        before = _processes(under_test)
        memory = _memory_mb(under_test)
        inside = intruder.come_in_as(intruder.stolen(robot.home))
        thrower = Thrower(robot.bus, inside, robot.name, dice)
        for done in range(0, n, STEP):
            thrower.throw(min(STEP, n - done))
            results.check("Z4", _troubles(under_test, before))
            results.of("Z4").checks += min(STEP, n - done) - 1
        inside.close()
        doors = sockets.doors(robot.home, robot.name, port)
        for door in doors:
            sockets.assault(
                door, max(1, n // LINK_SHARE // len(doors)), dice, lambda found: results.check("Z4 sockets", found)
            )
        results.check("Z4", _troubles(under_test, before))
        _still_works(under_test)
        growth = {name: mb - memory[name] for name, mb in _memory_mb(under_test).items() if name in memory}
        for mb in growth.values():
            results.sample("Z4 memory", max(0.0, mb))


class Thrower:
    """Throws at every key that the robot tells of, and at some that it does not."""

    def __init__(self, outside: Session, inside: Session, robot: str, dice: random.Random) -> None:
        self._doors = (outside, inside)
        self._dice = dice
        self._robot = robot
        self._schemas = {
            raw.key: json.loads(raw.payload) for raw in probe.survey(outside, f"{robot}/@schema/*/*", source="fuzz")
        }
        named = [key.replace("/@schema", "") for key in self._schemas]
        system = ("@console", "@console/view", "@console/admin", "@estop", "@estop/reset", "@estop/release/motors",
                  "@estop/ack/motors", "@status", "@event", "@alive/motors", "@schema/drive/command")  # fmt: skip
        strange = ("drive", "drive/nothing", "nobody/command", "drive/command/deeper", "@nothing", "motors/setpoint/x")
        self._keys = [*named * 2, *(f"{robot}/{name}" for name in (*system, *strange)), "other/drive/command"]

    def throw(self, n: int) -> None:
        """Put, ask, and delete."""
        for _ in range(n):
            key, bus = self._dice.choice(self._keys), self._dice.choice(self._doors)
            payload, attachment = self._payload(key), self._attachment()
            match self._dice.randrange(10):
                case 0:
                    bus.delete(key)
                case 1 | 2 | 3:
                    bus.get(key, zenoh.handlers.RingChannel(1), payload=payload, attachment=attachment, timeout=ASK_S)
                case _:
                    encoding = self._dice.choice(ENCODINGS)
                    bus.put(key, payload, encoding=encoding, attachment=attachment, congestion_control=BLOCK)

    def _payload(self, key: str) -> bytes:
        dice = self._dice
        if dice.random() < 0.25:
            return noise(dice) * dice.choice((1, 1, 1, 1, 1, 20, LARGEST // 64))
        if "@estop/reset" in key or "@console" in key:
            return mutated(dice, b"stop", SPLINTERS)
        schema = self._schemas.get(key.replace(self._robot, f"{self._robot}/@schema", 1), {})
        body = self._still(key) or self._message(schema)
        text = json.dumps(body).encode()
        return text if dice.random() < 0.3 and "/world/" not in key else self._spoiled(key, text)

    def _spoiled(self, key: str, text: bytes) -> bytes:
        worse = mutated(self._dice, text, SPLINTERS + NASTY + (b"{", b"[", b"[" * 2000, b'"', b":", b"1e999"), 3)
        return worse if not self._still(key) or not _drives(worse) else text

    def _still(self, key: str) -> dict[str, float]:
        """Return the message by which a key of the drive moves nothing; empty for all other keys."""
        return _STILL.get(key.removeprefix(f"{self._robot}/drive/"), {})

    def _message(self, schema: dict[str, object]) -> dict[str, object]:
        definitions = schema.get("$defs", {})
        assert isinstance(definitions, dict)
        body = next(iter(definitions.values())) if definitions else {}
        return {name: self._value(one) for name, one in body.get("properties", {}).items() if self._dice.random() < 0.8}

    def _value(self, schema: dict[str, object]) -> object:
        dice = self._dice
        if dice.random() < 0.2:
            return dice.choice((None, True, -1, 1e300, 2**70, "x" * 300, [], {}, [[[]]], "nan", 0.5))
        if choices := schema.get("enum"):
            return dice.choice(choices)  # type: ignore[arg-type]  # a list, in every schema
        kind = schema.get("type")
        if kind in ("number", "integer"):
            return dice.choice((0, 1, -1, 0.3, -0.3, schema.get("maximum", 7), schema.get("minimum", 3)))
        return {"boolean": True, "string": "text", "array": [], "object": {}}.get(str(kind))

    def _attachment(self) -> bytes | None:
        dice = self._dice
        if dice.random() < 0.2:
            return None
        genuine = stamp.make(
            dice.choice(("drive", "executive", "console", "fuzz")), dice.getrandbits(40), b"", noise(dice)
        )
        return genuine if dice.random() < 0.5 else mutated(dice, genuine, SPLINTERS + NASTY, 3)


def _free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as found:
        return int(found.getsockname()[1])


def _drives(payload: bytes) -> bool:
    """Say whether a drive command still asks for motion; whatever cannot be read asks for none."""
    try:
        command = json.loads(payload)
        return not isinstance(command, dict) or any(command.get(name, 0) != 0 for name in _ASKING)
    except (ValueError, RecursionError):
        return False


def _processes(under_test: Bench) -> dict[str, int]:
    return {name: under_test.pid(name) for name in ("motors", "drive", "ranges", "world", "spy", "lan")}


def _memory_mb(under_test: Bench) -> dict[str, float]:
    found = processes_of(under_test.robot.home)
    return {str(one.pid): one.memory_info().rss / MEGABYTE for one in found if one.is_running()}


def _troubles(under_test: Bench, before: dict[str, int]) -> list[str]:
    under_test.reached()  # a link that a busy machine keeps silent for 0.4 s is made again
    found = [] if _processes(under_test) == before else [f"a process was replaced: {under_test.state()}"]
    turned = [entry for entry in under_test.trace.read() if not getattr(entry, "zero", True)]
    if turned:
        found.append(f"the outputs were {turned[0]}, and nobody drove")
    if "Traceback" in (under_test.robot.home / "stderr.txt").read_text(errors="replace"):
        found.append("the executive told a traceback")
    return found


def _still_works(under_test: Bench) -> None:
    """Release and enable what chance has pressed; then it must drive and stop."""
    robot = under_test.robot
    for line in ("reset", "enable", "s"):
        under_test.until(lambda line=line: robot.line(line)["code"] == 0, 5.0, line, every_s=0.1)
    under_test.all_ready()
    robot.ask("drive/command", _STILL["command"])
    under_test.pass_time(0.6)
    moved = under_test.drive()
    moved.cease()
    under_test.until(lambda: under_test.trace.now().zero, 2.0, "rest")
