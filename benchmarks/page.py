"""The page in a real browser: how soon the motors follow a thumb, and stand when the page is lost; its size and cost.

`python -m benchmarks page --n 25 --moves 300`. A finger pushes the stick of the page in headless Chromium, on a phone's
screen; the times are those of the motors' bytes. PG4 needs root, for two network namespaces and a cable between them.
`--only PG1,PG3` measures these alone. Ten pages only look, as bare sockets: so many browsers would need a machine of
their own. Exit code 1 if a hard value is broken.
"""

import argparse
import random
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from statistics import median
from typing import Any

import psutil

from benchmarks import Measured, listed, one_by_one
from benchmarks.instruments import browsers as launched
from benchmarks.instruments.browsers import Browsers, OpenPage, viewers, wait_for
from tests.support import netns
from tests.support.bench import Bench
from tests.support.door import add_token
from tests.support.figures import Promise, Results
from tests.support.robot import Robot, prepare, running
from tests.support.trace import Line, Trace
from tests.support.waiting import until

SMOKE = "--n 1 --moves 4 --seconds 1"

PROMISES: dict[str, Promise] = {
    "PG1": Promise(
        what="stick of the page moved in a browser, to the motors' bytes", target=50, statistic="p99", hard=250
    ),
    "PG2": Promise(what="tab closed while it drives, to motor zero", target=350, hard=400),
    "PG3": Promise(what="browser killed (-9) while it drives, to motor zero", target=350, hard=400),
    "PG4": Promise(what="cable between browser and robot pulled while it drives, to motor zero", target=350, hard=400),
    "PG5": Promise(what="browser frozen while it drives, as a phone is locked, to motor zero", target=350, hard=400),
    "PG6": Promise(what="page opened for the first time, until it can be driven", target=1500, hard=10_000),
    "PG7": Promise(
        what="first load of the page, compressed, without what is drawn in three dimensions", unit="kB", hard=350
    ),
    "PG8": Promise(what="code of `pair` opened, to the first motion", unit="s", hard=20),
    "PG9": Promise(what="server of ten pages at 30 Hz, CPU", unit="% of a core", target=60, hard=95),
    "PG10": Promise(
        what="longest 1% of the drive's periods while ten pages look, to those while none does",
        unit="x",
        target=1.1,
        hard=2,
    ),
}
EDITS = (
    "UPDATE capability SET settings = json_set(settings, '$.requests_per_s', 2000) WHERE kind = 'web' AND robot = 'lbr'",
)
ROLES = {"phone": "operate", "left": "view", "right": "view"}
MOVING = 0.3
STANDS_S = 2.0
PULLED_MS = 50.0
"""The time between two moments in which a program pulls the cable; it counts from the first."""
LATER_S = 0.4
PAGES, RATE_HZ = 10, 30.0
TRIES = 12
"""A busy machine starves a browser, whose lease then expires; the thumb pushes again."""


def options(parser: argparse.ArgumentParser) -> None:
    """Add the number, and the figures."""
    parser.add_argument("--n", type=int, default=25, help="losses of each kind (default %(default)s)")
    parser.add_argument("--moves", type=int, default=300, help="moves of the stick (default %(default)s)")
    parser.add_argument(
        "--seconds", type=float, default=10.0, help="how long ten pages look, each time (default %(default)s)"
    )
    parser.add_argument("--only", type=listed, default=[], metavar="FIGURES", help="these alone, such as PG1,PG3")


def measure(given: argparse.Namespace) -> Measured:
    """Drive by the page, lose it, load it, and look at it with ten others."""
    results, dice = Results(PROMISES), random.Random(1)
    if why := launched.why_not():
        print(f"nothing is measured: {why}", file=sys.stderr)
        return Measured()

    def wanted(*figures: str) -> bool:
        return not given.only or bool(set(figures) & set(given.only))

    with tempfile.TemporaryDirectory(prefix="lbr-") as folder:
        place = Path(folder)
        with page_robot(place / "near") as (robot, tokens), launched.browsers(place) as found:
            stage = Stage(robot, found, results, dice, tokens)
            runs: list[tuple[str, str, Callable[[], None]]] = [
                ("loads", "PG6", partial(stage.load, max(1, given.n // 3))),
                ("moves", "PG1", partial(stage.move, given.moves)),
                ("closed", "PG2", partial(stage.close, given.n)),
                ("frozen", "PG5", partial(stage.freeze, given.n)),
                ("killed", "PG3", partial(stage.kill, given.n)),
                ("paired", "PG8", partial(stage.pair, max(1, given.n // 8))),
                ("ten pages", "PG9", partial(stage.look, given.seconds, 1 if given.n == 1 else 3)),
            ]
            also = {"PG6": "PG7", "PG9": "PG10"}
            one_by_one(results, [run for run in runs if wanted(run[1], also.get(run[1], run[1]))])
        if wanted("PG4"):
            one_by_one(results, [("cut", "PG4", partial(far, results, dice, place / "far", given.n))])
    return Measured(results=results.ordered(), repeated=results.repeated, disturbed=results.disturbed)


class Stage:
    """A robot, browsers that drive it, and the measurements."""

    moving = MOVING
    """The power from which a motor counts as turning after a push."""

    def __init__(
        self,
        robot: Robot,
        found: Browsers,
        results: Results,
        dice: random.Random,
        tokens: dict[str, str] | None = None,
        url: str = "",
    ) -> None:
        self.robot = robot
        self.browsers = found
        self.results = results
        self.dice = dice
        self.tokens = tokens or {}
        self.trace = Trace(robot.trace)
        self.url = url or f"{robot.web}/#drive"

    def load(self, n: int) -> None:
        """PG6 and PG7: open it in a browser with an empty cache."""
        self._opened().page.context.close()  # a browser's own first page costs more than any other
        for _ in range(n):
            one = self.browsers.open()
            told = one.page.context.new_cdp_session(one.page)
            sizes: list[float] = []
            told.send("Network.enable")
            told.on("Network.loadingFinished", lambda event, sizes=sizes: sizes.append(event["encodedDataLength"]))
            self.results.sample("PG6", one.look(self.url))
            one.page.wait_for_timeout(300)
            self.results.sample("PG7", sum(sizes) / 1000)
            one.page.context.close()

    def move(self, n: int) -> None:
        """PG1: move the stick, and find the first changed bytes."""
        one, way, done = self._driving(), 1.0, 0
        while done < n:
            way = self.dice.choice([0.95, 0.85, 0.75, 0.65] if way <= 0.6 else [0.6, 0.5, 0.42])
            self._steady()
            before = self._last()
            asked = one.push(way)
            heard = self._changed(asked, before)
            if heard is None:
                self.results.repeated.append("a move: the motors did not follow")
                self._again(one)
                continue
            self.results.sample("PG1", (heard - one.moved_ns()) * 1e-6)
            done += 1
            Bench.pass_time(self.dice.uniform(0.0, 0.05))
        self._end(one)

    def close(self, n: int) -> None:
        """PG2: close the tab."""
        for _ in range(n):
            one = self._driving()
            at = self._fault()
            one.page.close()
            self._stood("PG2", at)
            one.page.context.close()

    def freeze(self, n: int) -> None:
        """PG5: freeze the browser, and continue it later: nothing moves by itself then."""
        one = self._driving()
        for turn in range(n):
            if turn:
                self._again(one)
            processes = self.browsers.processes()
            at = self._fault()
            with self.browsers.frozen(processes):
                self._stood("PG5", at)
                Bench.pass_time(self.dice.uniform(0.1, 3 * LATER_S))
                woken = time.monotonic_ns()
            self._rests("PG5", woken)
        self._end(one)

    def kill(self, n: int) -> None:
        """PG3: kill the browser."""
        for _ in range(n):
            self._driving()
            processes = self.browsers.processes()
            at = self._fault()
            self.browsers.kill(processes)
            self._stood("PG3", at)
            self.browsers.forget()

    def cut(self, net: netns.Network, n: int) -> None:
        """PG4: pull the cable, and plug it in later: nothing moves by itself then."""
        one = self._driving()
        for turn in range(n):
            if turn:
                self._again(one)
            at = self._fault()
            net.cut()
            took_ms = (time.monotonic_ns() - at) * 1e-6
            try:
                if took_ms < PULLED_MS:
                    self._stood("PG4", at)
                else:
                    self.results.disturbed.append("PG4: the program that pulls the cable was held up")
                Bench.pass_time(self.dice.uniform(0.1, 5 * LATER_S))
            finally:
                healed = time.monotonic_ns()
                net.heal()
            self._rests("PG4", healed)
        self._end(one)

    def pair(self, n: int) -> None:
        """PG8: open the address of the code of `pair`, like a phone's camera, and push."""
        for _ in range(n):
            url = self.robot.line("pair")["data"]["url"]
            began = time.monotonic()
            one = self.browsers.open()
            one.look(url)
            self._grip(one)
            self.results.sample("PG8", time.monotonic() - began)
            self._end(one)

    def look(self, seconds: float, rounds: int) -> None:
        """PG9 and PG10: a page drives, in turns with nine that look and without them."""
        web = psutil.Process(self.robot.capability("web")["pid"])
        alone: list[float] = []
        among: list[float] = []
        one = self._driving()
        for _ in range(rounds):
            self._measure_drive(one, alone, seconds)
            with viewers(self.robot.web, [self.tokens["left"], self.tokens["right"]], PAGES - 1, RATE_HZ) as frames:
                before, began = sum(web.cpu_times()[:2]), time.monotonic()
                self._measure_drive(one, among, seconds)
                cpu = (sum(web.cpu_times()[:2]) - before) / (time.monotonic() - began) * 100
            self.results.sample("PG9", cpu)
            print(f"{PAGES} pages: {cpu:.0f} % of a core, {frames[0]:.1f} frames a second each", file=sys.stderr)
        print(f"p99 of the drive's periods, ms: alone {alone}, among pages {among}", file=sys.stderr)
        self.results.sample("PG10", median(among) / median(alone))
        self._end(one)

    def _measure_drive(self, one: OpenPage, found: list[float], seconds: float) -> None:
        """Note the drive's figure of its last seconds, once it has been driven so long."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            one.page.wait_for_timeout(100)
        loop = (self.robot.ask("drive/state") or {}).get("loop") or {}
        found.append(float(loop["period_p99_ms"]))

    # a finger on the stick

    def _opened(self) -> OpenPage:
        one = self.browsers.open()
        one.look(self.url)
        return one

    def _driving(self) -> OpenPage:
        """Let a page drive the robot in circles."""
        one = self._opened()
        self._grip(one)
        return one

    def _grip(self, one: OpenPage) -> None:
        for _ in range(TRIES):
            one.grip()
            if wait_for(lambda: self.trace.now().least >= self.moving, 2.0):
                return
            one.release()
            self.results.repeated.append("a push of the stick: the motors did not follow")
        raise AssertionError("the page does not drive the robot")

    def _again(self, one: OpenPage) -> None:
        one.release()
        one.ready()
        self._grip(one)

    def _end(self, one: OpenPage) -> None:
        one.release()
        one.page.context.close()
        assert wait_for(lambda: self.trace.now().zero, STANDS_S)

    # what the motors did

    def _fault(self) -> int:
        """Wait for a random part of the page's period; return the time."""
        Bench.pass_time(self.dice.uniform(0.0, 0.25))
        return time.monotonic_ns()

    def _stood(self, figure: str, at: int) -> None:
        zero = self.trace.first_zero(at, STANDS_S)
        if not self.trace.at(at).least >= MOVING:
            self.results.disturbed.append(f"{figure}: the motors did not turn before")
        elif zero is None:
            self.results.check(figure, [f"the motors turned {STANDS_S:g} s later"])
        else:
            self.results.sample(figure, (zero.at_ns - at) * 1e-6)

    def _rests(self, figure: str, since: int) -> None:
        """Check that nothing moves by itself."""
        Bench.pass_time(LATER_S)
        self.trace.read()
        moved = [line.text for line in self.trace.lines(since) if line.moves]
        self.results.check(figure, [f"it moved by itself afterwards: {moved[0]}"] if moved else [])

    def _steady(self) -> None:
        """Wait until the motors' power stays the same for a while."""
        end = time.monotonic() + 2.0
        while time.monotonic() < end:
            self.trace.read()
            lately = {
                line.text for line in self.trace.lines(time.monotonic_ns() - 120_000_000) if line.text.startswith("!M")
            }
            if len(lately) == 1:
                return
            Bench.pass_time(0.02)

    def _last(self) -> str:
        return next(
            (one.text for one in reversed(self.trace.entries) if isinstance(one, Line) and one.text.startswith("!M")),
            "",
        )

    def _changed(self, since: int, before: str) -> int | None:
        found: list[int] = []

        def look() -> bool:
            self.trace.read()
            found.extend(
                one.at_ns for one in self.trace.lines(since) if one.text.startswith("!M") and one.text != before
            )
            return bool(found)

        return found[0] if wait_for(look, 1.0) else None


def far(results: Results, dice: random.Random, home: Path, n: int) -> None:
    """PG4: drive from another machine, and pull the cable; messages that are delivered later move nothing."""
    if why := netns.why_not():
        print(f"PG4 is left out: {why}", file=sys.stderr)
        return
    with netns.network() as net:
        row = f"UPDATE capability SET settings = json_set(settings, '$.host', '{net.address}') WHERE kind = 'web'"
        with page_robot(home, row, prefix=net.robot) as (robot, tokens), launched.browsers(home, net.client) as found:
            port = robot.web.rpartition(":")[2]
            url = f"https://{net.address}:{port}/#token={tokens['phone']}"
            Stage(robot, found, results, dice, url=url).cut(net, n)


@contextmanager
def page_robot(home: Path, *edits: str, **options: Any) -> Iterator[tuple[Robot, dict[str, str]]]:
    """Run a robot that serves its page, with tokens for driving and for looking."""
    prepare(home, "web", edits=(*EDITS, *edits))
    tokens = {name: str(add_token(home, name, role, good_for="web")) for name, role in ROLES.items()}
    with running(home, **options) as robot:
        until(lambda: robot.capability("web")["phase"] == "ready", what="its server is ready")
        yield robot, tokens
