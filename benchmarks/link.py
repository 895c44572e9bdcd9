"""The page over a bad link: how soon the motors follow a thumb, how often they stop, and what the page shows.

`python -m benchmarks link --moves 40 --seconds 20`. A finger holds the stick of the page in headless Chromium. A
program between browser and robot delays the bytes, loses some with the effect of TCP, or blocks them for half a second.
"""

import argparse
import random
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from statistics import median

from benchmarks import Measured, listed
from benchmarks.instruments import browsers as launched
from benchmarks.instruments import slow_link
from benchmarks.instruments.browsers import OpenPage
from benchmarks.page import Stage, page_robot
from tests.support import programs
from tests.support.bench import Bench
from tests.support.figures import Promise, Results

SMOKE = "--moves 2 --seconds 1 --links direct"
LINKS = {
    "direct": (0.0, 0.0, 0.0),
    "50ms": (0.025, 0.0, 0.0),
    "150ms": (0.075, 0.0, 0.0),
    "400ms": (0.2, 0.0, 0.0),
    "loss": (0.025, 0.02, 0.0),
    "gaps": (0.025, 0.0, 0.5),
}
"""The delay of one direction in seconds, the share of pieces that is lost once, and the gap every 5 s."""
WHAT = {
    "direct": "nothing between",
    "50ms": "50 ms there and back",
    "150ms": "150 ms there and back",
    "400ms": "400 ms there and back",
    "loss": "50 ms and 2 % loss",
    "gaps": "50 ms and gaps of 0.5 s",
}
LOOKS = 300
"""The page is read when the motors stop, or after so many looks at them."""
PROMISES = {
    f"LK{number} {link}": Promise(what=f"{what}: {how}", unit=unit)
    for link, how in WHAT.items()
    for number, what, unit in (
        (1, "stick moved, to the motors' bytes", "ms"),
        (2, "stick held: time in which the motors turn", "%"),
        (3, "thumb lifted, to motor zero", "ms"),
        (4, "stick held: power of the motors", "%"),
    )
}


def options(parser: argparse.ArgumentParser) -> None:
    """Add the duration, and the links."""
    parser.add_argument("--moves", type=int, default=40, help="moves of the stick over each link (default %(default)s)")
    parser.add_argument("--seconds", type=float, default=20.0, help="how long it is held (default %(default)s)")
    parser.add_argument("--links", type=listed, default=list(LINKS), help="such as 50ms,gaps")


def measure(given: argparse.Namespace) -> Measured:
    """Drive over each link."""
    results, text = Results(PROMISES), []
    if why := launched.why_not():
        print(f"nothing is measured: {why}", file=sys.stderr)
        return Measured()
    with tempfile.TemporaryDirectory(prefix="lbr-") as folder:
        place = Path(folder)
        with page_robot(place / "near") as (robot, _), launched.browsers(place) as found:
            for link in given.links:
                with slowed(robot.web, link) as port:
                    found.close()
                    found.options = [f"--host-resolver-rules=MAP localhost 127.0.0.1:{port}"]  # the page's origin stays
                    stage = Drive(
                        robot,
                        found,
                        results,
                        random.Random(1),
                        url=f"{robot.web}/#drive".replace("127.0.0.1", "localhost"),
                    )
                    text.append(f"{WHAT[link]}: {stage.drive(link, given.moves, given.seconds)}")
    return Measured(results=results.ordered(), text="\n".join(text), repeated=results.repeated)


@contextmanager
def slowed(url: str, link: str) -> Iterator[int]:
    """Put a link between browser and robot; yield its port."""
    port = url.rpartition(":")[2]
    argv = [sys.executable, "-m", slow_link.__name__, port, *map(str, LINKS[link])]
    with programs.start(argv, stdout=subprocess.PIPE, text=True) as popen:
        assert popen.stdout is not None
        try:
            yield int(popen.stdout.readline())
        finally:
            popen.kill()


class Drive(Stage):
    """A page that drives over a link, which may reduce its speed."""

    moving = 0.05

    def drive(self, link: str, moves: int, seconds: float) -> str:
        """Move the stick, hold it, release it; return the page's texts meanwhile."""
        page = self._opened()
        self._grip(page)
        self._follow(page, link, moves)
        shown = self._hold(page, link, seconds)
        page.release()
        page.page.context.close()
        return shown

    def _follow(self, page: OpenPage, link: str, moves: int) -> None:
        for number in range(moves):
            self._steady()
            before = self._last()
            asked = page.push(0.9 if number % 2 else 0.5)
            if (followed := self._changed(asked, before)) is None:
                self.results.repeated.append(f"{link}: the motors did not follow")
                self._again(page)
                continue
            self.results.sample(f"LK1 {link}", (followed - page.moved_ns()) * 1e-6)
            if number % 4 == 3:
                at = time.monotonic_ns()
                page.release()
                if (zero := self.trace.first_zero(at, 3.0)) is not None:
                    self.results.sample(f"LK3 {link}", (zero.at_ns - at) * 1e-6)
                self._again(page)

    def _hold(self, page: OpenPage, link: str, seconds: float) -> str:
        turned, looks, stops, turning, shown, powers = 0, 0, 0, True, "", [0.0]
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            turns = not (told := self.trace.now()).zero
            powers.append(told.most)
            stops += turning and not turns
            turned, looks, turning = turned + turns, looks + 1, turns
            if (not turns or looks == LOOKS) and not shown:
                shown = " / ".join(page.page.locator("[role=status], [role=alert]").all_inner_texts())
            Bench.pass_time(0.01)
        self.results.sample(f"LK2 {link}", 100.0 * turned / looks)
        self.results.sample(f"LK4 {link}", 100.0 * median(powers))
        return f"{stops} stops in {seconds:g} s; {' '.join(shown.split()) or 'nothing'}"
