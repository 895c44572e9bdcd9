"""Asks a simulated UXA-90 whatever its OpenAPI document allows, and more, and looks at answers and at the wire."""

import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import httpx
import hypothesis
from hypothesis import HealthCheck, Phase, given

from tests.fuzzing.rest_schema import Case, cases, misfit
from tests.support.robot import Robot, only, prepare, running
from tests.support.uxa90_wire import chunks, packets
from tests.support.waiting import until

ANSWER_S = 5.0
MOVES = ("/motor", "/multimotor", "/motion/{key}")
MOVING = 5
"""How many times more of these than of others."""
PICTURES = ("/stream.mjpg", "/snapshot.jpg")
"""Its cameras are off here: a stream has no end, and there is no picture."""
RUNS = ("servos", "joints", "motions", "web", "world")
EDITS = (
    only("uxa90", *RUNS),
    """UPDATE device SET settings = json_set(settings, '$.trace', json('true'), '$.settle_ms', 5)
        WHERE robot = 'uxa90' AND name = 'main_board'""",
    "UPDATE capability SET settings = json_set(settings, '$.settle_s', 0.05) WHERE robot = 'uxa90' AND name = 'servos'",
    "UPDATE capability SET settings = json_set(settings, '$.requests_per_s', 1000) WHERE robot = 'uxa90' AND name = 'web'",
)


class Tally:
    """What came of all cases."""

    def __init__(self) -> None:
        self.statuses: Counter[int] = Counter()
        self.operations: Counter[str] = Counter()
        self.wrong: list[str] = []
        self.slowest_s = 0.0


@contextmanager
def served(home: Path, *edits: str) -> Iterator[tuple[Robot, httpx.Client, Path]]:
    """Run a simulated UXA-90, and give a client of its API, and the trace of its main board."""
    prepare(home, edits=(*EDITS, *edits))
    with running(home, profile="uxa90-sim") as robot:
        base = until(lambda: _url(robot), what="the server's address")
        with httpx.Client(base_url=base, timeout=ANSWER_S, trust_env=False) as client:
            until(lambda: _armed(client), what="joints that may move")
            yield robot, client, home / "run" / "uxa90-devices" / "main_board.trace"


def ask_all(client: httpx.Client, number: int, seed: int | None = None) -> Tally:
    """Ask this many cases, one after the other: of each operation some, of those that move most."""
    document = client.get("/openapi.json").json()
    tally = Tally()
    kinds = {kind: some for kind, some in cases(document).items() if kind[0] not in PICTURES}
    weights = {kind: MOVING if kind[0] in MOVES else 1 for kind in kinds}
    for kind, some in kinds.items():
        _ask_some(client, document, some, max(1, number * weights[kind] // sum(weights.values())), seed, tally)
    while (left := number - sum(tally.statuses.values())) > 0 and not tally.wrong:
        _ask_some(client, document, kinds[MOVES[0], "GET"], left, seed, tally)
    return tally


def _ask_some(
    client: httpx.Client, document: dict[str, Any], some: Any, number: int, seed: int | None, tally: Tally
) -> None:
    @hypothesis.settings(
        max_examples=number,
        database=None,
        deadline=None,
        phases=(Phase.generate,),
        suppress_health_check=list(HealthCheck),
    )
    @given(some)
    def one(case: Case) -> None:
        _ask(client, document, case, tally)

    (hypothesis.seed(seed)(one) if seed is not None else one)()


def on_the_wire(trace: Path) -> tuple[Counter[str], list[str]]:
    """Return how many packets of which kind there were, and what was illegal."""
    found, wrong = packets(b"".join(chunk.data for chunk in chunks(trace)))
    return Counter(packet.kind for packet in found), wrong


def _ask(client: httpx.Client, document: dict[str, Any], case: Case, tally: Tally) -> None:
    began = time.monotonic()
    headers = {"Content-Type": case.media} if case.media else {}
    try:
        answer = client.request(case.method, case.url, content=case.body or None, headers=headers)
    except httpx.HTTPError as err:
        tally.wrong.append(f"{case}: {type(err).__name__}: {err}")
        return
    tally.slowest_s = max(tally.slowest_s, time.monotonic() - began)
    tally.statuses[answer.status_code] += 1
    tally.operations[f"{case.method} {case.route}"] += 1
    why = misfit(document, case, answer.status_code, answer.headers.get("content-type", ""), answer.content)
    if answer.status_code >= 500:
        why = f"{answer.status_code} {answer.text[:200]}"
    if why:
        tally.wrong.append(f"{case}: {why}")
    _go_on(client, case, answer.status_code)


def _go_on(client: httpx.Client, case: Case, status: int) -> None:
    """Have the next case find a robot that can move."""
    if status != 200:
        return
    if case.route == "/estop":
        until(lambda: client.post("/estop/reset").status_code == 200, what="a reset")
    elif case.route == "/motion/{key}":
        client.post("/stop")


def _url(robot: Robot) -> str:
    answer = robot.ask("web/address", {})
    return str(answer["url"]).rstrip("/") if answer and answer["accepted"] else ""


def _armed(client: httpx.Client) -> bool:
    joints = client.get("/state").json()["joints"]
    return joints is not None and joints["joints"]["neck_yaw"]["position_rad"] is not None
