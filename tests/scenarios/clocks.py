"""F4: the robot's wall clock jumps by up to an hour, forwards and back, many times a second; nothing may care.

The clock of the machine is left alone: a library that `cc` makes stands between the robot's processes and theirs.
"""

import os
import random
import shutil
import tempfile
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tests.scenarios import clients, estop
from tests.scenarios.load import steadiness
from tests.support import programs
from tests.support.bench import Bench, bench
from tests.support.figures import Results

SHIFT = Path(__file__).parents[1] / "support" / "clients" / "shifted_clock.c"
HOUR_S = 3600
JUMP_EVERY_S = 0.03
DRIVE_S = 2.0


def can_shift() -> bool:
    """Say whether this machine has a compiler."""
    return shutil.which("cc") is not None


def wall_clock_jumps(results: Results, n: int) -> None:
    """F4: drive steadily, lose the client, press; `n` times on one robot."""
    if not can_shift():
        return
    loaded = results.under("clock")
    with _jumping_clock(), bench(loaded) as under_test:
        for _ in range(n):
            steadiness(under_test, "I", for_s=DRIVE_S)
            _no_stop(under_test)
            clients.plain_client_killed(under_test)
            estop.by_put(under_test)


def _no_stop(under_test: Bench) -> None:
    stops = under_test.results.of("B2 I").samples.pop()
    under_test.results.check("F4", [f"{stops:g} stops that nobody asked for"] if stops else [])


@contextmanager
def _jumping_clock() -> Iterator[None]:
    """Let programs that start in this block see a wall clock that jumps until its end."""
    with tempfile.TemporaryDirectory(prefix="lbr-") as place:
        library, offset = Path(place) / "clock.so", Path(place) / "offset"
        offset.write_bytes(bytes(8))
        programs.run(["cc", "-O1", "-shared", "-fPIC", "-o", library, SHIFT, "-ldl"], check=True)
        over = threading.Event()
        thread = threading.Thread(target=_jump, args=(offset, over), daemon=True)
        os.environ |= {"LD_PRELOAD": str(library), "SHIFTED_CLOCK": str(offset)}
        thread.start()
        try:
            yield
        finally:
            del os.environ["LD_PRELOAD"], os.environ["SHIFTED_CLOCK"]
            over.set()
            thread.join()


def _jump(offset: Path, over: threading.Event) -> None:
    with offset.open("r+b", buffering=0) as file:
        while not over.wait(JUMP_EVERY_S):
            file.seek(0)
            file.write(random.randint(-HOUR_S, HOUR_S).to_bytes(8, "little", signed=True))
