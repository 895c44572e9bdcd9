"""Four clients of the UXA-90's API at 20 requests a second each, and viewers of its states, for as long as wanted.

`python -m benchmarks rest_load --seconds 600 [--json FILE]`. They move head and neck, read motors, and move several at
once. Meanwhile a fifth client moves one arm at intervals: the trace of the emulated main board shows how long after a
request its first byte is on the wire. At the end one request moves 23 motors. Exit code 1 if an answer was an error, if
the slowest hundredth took 50 ms or more, if fewer than 20 states came a second, if a request needed 15 ms or more to
the wire, or if anything illegal was there.
"""

import argparse
import contextlib
import http.client
import json
import os
import tempfile
import threading
import time
from collections import Counter
from pathlib import Path
from typing import Any

from websockets.sync.client import connect

from benchmarks import Measured
from lbr.executive.processes import scheduling
from tests.fuzzing.rest_cases import served
from tests.support.figures import percentile
from tests.support.uxa90_wire import chunks, packets

SMOKE = "--seconds 1"

CLIENTS, RATE_HZ = 4, 20.0
VIEWERS = 2
PROBE_MOTOR, PROBE_EVERY_S, PROBE_AT = 17, 0.5, (110, 144)
SLOW_MS, WIRE_MS, LEAST_HZ = 50.0, 15.0, 20.0
SETTLE_S = 3.0
NEAR = {
    4: (60, 70),
    5: (190, 200),
    12: (90, 100),
    13: (170, 180),
    14: (140, 150),
    15: (110, 118),
    18: (190, 200),
    19: (50, 60),
}
"""The range that both the API and the joints permit, for motors that do not rest in the middle."""


def options(parser: argparse.ArgumentParser) -> None:
    """Add the duration."""
    parser.add_argument("--seconds", type=float, default=600.0, help="how long (default %(default)s)")


def measure(given: argparse.Namespace) -> Measured:
    """Run the load."""
    outrank()
    found = loaded(given.seconds)
    return Measured(figures=found, broken=failures(found))


class Tally:
    """The counts of one client."""

    def __init__(self) -> None:
        self.ms: list[float] = []
        self.statuses: Counter[int] = Counter()
        self.wrong: list[str] = []


class Client:
    """Asks over one open connection, as apps do."""

    def __init__(self, port: int, tally: Tally) -> None:
        self._connection = http.client.HTTPConnection("127.0.0.1", port, timeout=5)
        self.tally = tally

    def ask(self, method: str, path: str, body: Any = None) -> float:
        """Send a request; return its time."""
        asked = time.monotonic()
        try:
            given = json.dumps(body).encode() if body is not None else None
            self._connection.request(method, path, given, {"Content-Type": "application/json"} if given else {})
            answer = self._connection.getresponse()
            said = answer.read()
        except (OSError, http.client.HTTPException) as err:
            self._connection.close()
            self.tally.wrong.append(f"{method} {path}: {type(err).__name__} {err}")
            return asked
        self.tally.ms.append((time.monotonic() - asked) * 1e3)
        self.tally.statuses[answer.status] += 1
        if answer.status != 200:
            self.tally.wrong.append(f"{method} {path}: {answer.status} {said[:200].decode(errors='replace')}")
        return asked


def swing(at: float, low: int, high: int, period_s: float) -> int:
    """Return the position of an oscillation at a time."""
    part = at / period_s % 2.0
    return round(low + (high - low) * (part if part < 1.0 else 2.0 - part))


def drive(client: Client, number: int, end: float) -> None:
    """Ask 20 times a second until the end, whatever the duration of answers."""
    count, due = 0, time.monotonic() + number / CLIENTS / RATE_HZ
    while (now := time.monotonic()) < end:
        if now < due:
            time.sleep(due - now)
            continue
        due += 1 / RATE_HZ
        count += 1
        neck, head = swing(now, 90, 160, 3.0), swing(now, 105, 155, 4.0)
        if count % 4 == 0:
            client.ask("GET", f"/motor?id={23 if number % 2 else 24}")
        elif count % 4 == 1:
            client.ask("GET", "/multimotor", {"motors": [{"id": 23, "pos": neck, "torq": 0}, {"id": 24, "pos": head}]})
        else:
            client.ask("GET", f"/motor?id=23&pos={neck}" if count % 4 == 2 else f"/motor?id=24&pos={head}&torq=1")


def probe(client: Client, end: float, asked: list[float]) -> None:
    """Move an arm that nobody else moves, once it rests."""
    count = 0
    while time.monotonic() < end:
        asked.append(client.ask("GET", f"/motor?id={PROBE_MOTOR}&pos={PROBE_AT[count % 2]}"))
        count += 1
        time.sleep(PROBE_EVERY_S)


def look(port: int, end: float, gaps_s: list[float], wrong: list[str]) -> None:
    """Watch the states, and note the time between new states of the joints."""
    try:
        with connect(f"ws://127.0.0.1:{port}/ws?rate_hz=40", max_size=1 << 20) as states:
            last, at = None, time.monotonic()
            while time.monotonic() < end:
                joints = json.loads(states.recv(timeout=5))["joints"]
                if joints and joints["sequence"] != last:
                    now, last = time.monotonic(), joints["sequence"]
                    gaps_s.append(now - at)
                    at = now
    except Exception as err:  # noqa: BLE001 - a figure, whatever it was
        wrong.append(f"states: {type(err).__name__} {err}")


def wire_delays_ms(trace: Path, asked: list[float]) -> list[float]:
    """Return the delay from each request to its first packet for the probe's motor on the wire."""
    sent = [
        chunk.at
        for chunk in chunks(trace)
        if any(packet.kind == "move" and packet.servo == PROBE_MOTOR for packet in packets(chunk.data)[0])
    ]
    found = []
    for at in asked:
        first = next((one for one in sent if one >= at), None)
        if first is not None and first - at < PROBE_EVERY_S:
            found.append((first - at) * 1e3)
    return found


def together(port: int, trace: Path) -> dict[str, Any]:
    """Move all motors by one request; return the most packets in one piece, and the number of pieces."""
    client = Client(port, Tally())
    ids = [*range(20), 22, 23, 24]
    most, began = 0, time.monotonic()
    for step in range(4):
        motors = [{"id": one, "pos": NEAR.get(one, (122, 132))[step % 2]} for one in ids]
        client.ask("POST", "/multimotor", {"motors": motors})
        time.sleep(SETTLE_S / 2)
    pieces = [chunk for chunk in chunks(trace) if chunk.at >= began]
    moves = [sum(one.kind == "move" for one in packets(chunk.data)[0]) for chunk in pieces]
    most = max(moves, default=0)
    return {"asked_for": len(ids), "most_in_one_piece": most, "wrong": client.tally.wrong}


def loaded(seconds: float) -> dict[str, Any]:
    """Run the load, and return the figures."""
    with tempfile.TemporaryDirectory() as folder, served(Path(folder) / "home") as (robot, _client, trace):
        port = int(robot.web.rpartition(":")[2])
        end = time.monotonic() + seconds
        tallies = [Tally() for _ in range(CLIENTS + 1)]
        gaps: list[list[float]] = [[] for _ in range(VIEWERS)]
        asked: list[float] = []
        wrong: list[str] = []
        work = [
            *(threading.Thread(target=drive, args=(Client(port, tallies[n]), n, end)) for n in range(CLIENTS)),
            threading.Thread(target=probe, args=(Client(port, tallies[CLIENTS]), end, asked)),
            *(threading.Thread(target=look, args=(port, end, gaps[n], wrong)) for n in range(VIEWERS)),
        ]
        for thread in work:
            thread.start()
        for thread in work:
            thread.join()
        time.sleep(SETTLE_S)
        delays = wire_delays_ms(trace, asked)
        all_moved = together(port, trace)
        illegal = packets(b"".join(chunk.data for chunk in chunks(trace)))[1]
        unit = robot.capability("web")
    ms = sorted(one for tally in tallies[:CLIENTS] for one in tally.ms)
    wrong += [text for tally in tallies for text in tally.wrong]
    states_hz = min((len(each) / seconds for each in gaps), default=0.0)
    return {
        "seconds": seconds,
        "requests": sum(sum(tally.statuses.values()) for tally in tallies),
        "requests_hz": len(ms) / seconds,
        "statuses": dict(sum((tally.statuses for tally in tallies), Counter())),
        "errors": len(wrong),
        "first_errors": wrong[:10],
        "answer_ms": _spread(ms),
        "to_wire_ms": _spread(sorted(delays)),
        "states_hz": states_hz,
        "state_gap_ms": _spread(sorted(one * 1e3 for each in gaps for one in each[1:])),
        "together": all_moved,
        "illegal": illegal[:10],
        "web_memory_mb": unit.get("memory_mb"),
        "web_cpu_percent": unit.get("cpu_percent"),
    }


def _spread(ordered: list[float]) -> dict[str, float]:
    if not ordered:
        return {}
    return {
        "count": len(ordered),
        "p50": round(percentile(ordered, "p50"), 2),
        "p99": round(percentile(ordered, "p99"), 2),
        "max": round(ordered[-1], 2),
    }


def failures(found: dict[str, Any]) -> list[str]:
    """Return the failures."""
    wrong = []
    if found["errors"]:
        wrong.append(f"{found['errors']} errors")
    if not found["answer_ms"].get("p99", SLOW_MS) < SLOW_MS:
        wrong.append(f"answers took {found['answer_ms']}")
    if not found["to_wire_ms"].get("p99", WIRE_MS) < WIRE_MS:
        wrong.append(f"to the wire it took {found['to_wire_ms']}")
    if not found["states_hz"] >= LEAST_HZ:
        wrong.append(f"{found['states_hz']:.1f} states a second")
    if found["together"]["wrong"] or found["together"]["most_in_one_piece"] < found["together"]["asked_for"]:
        wrong.append(f"all motors at once: {found['together']}")
    if found["illegal"]:
        wrong.append(f"illegal on the wire: {found['illegal'][:3]}")
    return wrong


def outrank() -> None:
    """Rank like clients on other machines, however busy this one is."""
    with contextlib.suppress(OSError):
        os.setsid()
    scheduling.rank(os.getpid(), scheduling.MOTION)
