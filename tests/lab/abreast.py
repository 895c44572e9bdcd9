"""Keeps two machines' clocks abreast: each says what time it has, and whichever is ahead of the other waits.

An emulated processor is slower the more it has to do, and its clock counts its instructions. In the machine
`python -m tests.lab.abreast` says its time since its start on its second serial line, before all else; outside a thread
listens, and has QEMU stop the one that is ahead, which the machine does not notice.
"""

import json
import selectors
import socket
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

LINE = "/dev/ttyS1"
EACH_S = 0.01
MOST_AHEAD_S = 0.02
ANSWERS_S = 120.0
"""On a host that has much else to do."""
UNIT = f"""[Unit]
DefaultDependencies=no
[Service]
WorkingDirectory=/opt/lab
ExecStart=/opt/lbr/bin/python -m tests.lab.abreast {LINE}
CPUSchedulingPolicy=fifo
CPUSchedulingPriority=90
Restart=always
[Install]
WantedBy=multi-user.target
"""


class Clock:
    """A machine's clock as it is told, and the brake of the machine."""

    def __init__(self, told: Path, control: Path) -> None:
        self.at = 0.0
        self.held = False
        self.link = _connected(told)
        self._heard = b""
        self._control = _connected(control)
        self._answers = self._control.makefile("rb")
        self._answers.readline()  # what it is
        self._say("qmp_capabilities")

    def listen(self) -> None:
        """Take in what the machine says of its time."""
        data = self.link.recv(4096)
        if not data:
            raise ConnectionError("the machine is off")
        *lines, self._heard = (self._heard + data).split(b"\n")
        for line in lines:
            with suppress(ValueError):  # the first one may have begun before
                self.at = float(line)

    def hold(self, *, held: bool) -> None:
        """Have the machine stand still, or go on."""
        if held != self.held:
            self._say("stop" if held else "cont")
            self.held = held

    def close(self) -> None:
        """Let it go on by itself."""
        with suppress(OSError):
            self.hold(held=False)
        for one in (self._answers, self._control, self.link):
            one.close()

    def _say(self, what: str) -> None:
        self._control.sendall(json.dumps({"execute": what}).encode())
        while "return" not in (said := json.loads(self._answers.readline() or b'{"return": null, "over": true}')):
            if "error" in said:
                raise ConnectionError(f"'{what}' is answered with {said['error']}")
        if "over" in said:
            raise ConnectionError("the machine is off")


class Abreast:
    """Two machines whose clocks go abreast, from when both tell their time; `most_s` is how far one ever was ahead."""

    def __init__(self, first: tuple[Path, Path], second: tuple[Path, Path]) -> None:
        self.most_s = 0.0
        self._paths = (first, second)
        self._over = threading.Event()
        self._begun = threading.Event()
        self._thread: threading.Thread | None = None
        self._failed = ""

    def start(self) -> None:
        """Keep them so, however far apart they are now; return when both tell their time."""
        clocks = [Clock(*one) for one in self._paths]
        self._over.clear()
        self._begun.clear()
        self._thread = threading.Thread(target=self._keep, args=clocks, name="abreast")
        self._thread.start()
        if not self._begun.wait(ANSWERS_S):
            self.stop()
            raise RuntimeError(f"not both machines tell their time within {ANSWERS_S:g} s")

    def stop(self) -> None:
        """Let each go as it does."""
        self._over.set()
        if self._thread is not None:
            self._thread.join()
        self._thread = None

    @contextmanager
    def alone(self) -> Iterator[None]:
        """Let each go as it does for a while; how far apart they are then, they stay."""
        self.stop()
        try:
            yield
        finally:
            self.start()

    def seen(self) -> float:
        """Return how far one ever was ahead of the other."""
        if self._failed:
            raise RuntimeError(f"their clocks were not kept abreast: {self._failed}")
        return self.most_s

    def _keep(self, first: Clock, second: Clock) -> None:
        apart_s: float | None = None
        with selectors.DefaultSelector() as ready:
            for one in (first, second):
                ready.register(one.link, selectors.EVENT_READ, one)
            try:
                while not self._over.is_set():
                    for key, _ in ready.select(0.1):
                        key.data.listen()
                    if not (first.at and second.at):
                        continue
                    if apart_s is None:
                        apart_s = first.at - second.at
                        self._begun.set()
                    ahead_s = first.at - second.at - apart_s
                    self.most_s = max(self.most_s, abs(ahead_s))
                    first.hold(held=waits(ahead_s, first.held))
                    second.hold(held=waits(-ahead_s, second.held))
            except OSError as err:
                self._failed = str(err) or type(err).__name__
            finally:
                first.close()
                second.close()


def waits(ahead_s: float, held: bool) -> bool:
    """Say whether a machine is to wait that is so far ahead: until the other has come up to it."""
    return ahead_s > (0.0 if held else MOST_AHEAD_S)


def _connected(path: Path) -> socket.socket:
    link = socket.socket(socket.AF_UNIX)
    link.settimeout(ANSWERS_S)
    link.connect(str(path))
    return link


def main() -> None:
    """Say on a line what time it is, again and again."""
    with Path(sys.argv[1]).open("w", encoding="ascii", buffering=1) as line:
        while True:
            now = time.monotonic()
            line.write(f"{now:.4f}\n")
            time.sleep(EACH_S - now % EACH_S)


if __name__ == "__main__":
    main()
