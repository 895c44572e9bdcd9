"""The other end of a UXA-90's line, a program of its own: `good PATH` is its main board, `bad PATH SEED` a bad line."""

import heapq
import os
import pty
import select
import sys
import time
import tty
from itertools import count
from pathlib import Path

from lbr.capability.context import Device
from lbr.robots.uxa90.twin.twin import Uxa90Twin
from lbr.simulation.twins.base import Surroundings
from tests.fuzzing.uxa90_answers import KINDS, Fuzzer

FUZZ_SHARE = 0.02
FUZZ_KINDS = KINDS + ("blob",) * 5


def good(path: str) -> None:
    """Act as the emulated main board, until the parent is gone."""
    device = Device("board", "uxa90", path, {"trace": True})
    twin = Uxa90Twin(device, Surroundings(seed=1, now=time.monotonic()))
    while os.getppid() != 1:
        due, fd = twin.next_due(), twin.watched()
        wait_s = 0.05 if due is None else max(0.0, min(0.05, due - time.monotonic()))
        select.select([] if fd is None else [fd], [], [], wait_s)
        twin.service(time.monotonic())


def bad(path: str, seed: int) -> None:
    """Act as servos at the end of a bad line, until the parent is gone."""
    fuzzer = Fuzzer(seed=seed, share=FUZZ_SHARE, kinds=FUZZ_KINDS, blob_bytes=3000)
    master, slave = pty.openpty()
    tty.setraw(slave)
    Path(path).symlink_to(os.ttyname(slave))
    place, over = Path(path).with_name("spoilt"), Path(path).with_name("good")
    due: list[tuple[float, int, bytes]] = []
    order, told = count(), 0
    while os.getppid() != 1:
        wait_s = max(0.0, min(0.05, due[0][0] - time.monotonic())) if due else 0.05
        if select.select([master], [], [], wait_s)[0]:
            for delay_s, piece in fuzzer.feed(os.read(master, 4096)):
                heapq.heappush(due, (time.monotonic() + delay_s, next(order), piece))
        while due and due[0][0] <= time.monotonic():
            os.write(master, heapq.heappop(due)[2])
        if fuzzer.spoilt_bytes != told:
            told = fuzzer.spoilt_bytes
            place.write_text(str(told))
            fuzzer.share = 0.0 if over.exists() else fuzzer.share


if __name__ == "__main__":
    good(sys.argv[2]) if sys.argv[1] == "good" else bad(sys.argv[2], int(sys.argv[3]))
