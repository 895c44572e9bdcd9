"""Reports the state of the robot to the service manager: ready, alive, stopping. Without a manager, it does nothing."""

import contextlib
import os
import socket
import time
from collections.abc import Callable, MutableMapping

from lbr.messages.plain import one_line

SOCKET_VARIABLE, PERIOD_VARIABLE, PID_VARIABLE = "NOTIFY_SOCKET", "WATCHDOG_USEC", "WATCHDOG_PID"
BEATS_PER_PERIOD = 4
MORE_TIME = "EXTEND_TIMEOUT_USEC=10000000"


class Notifier:
    """Sends the datagrams of systemd. A send never waits; `beat` repeats a refused one.

    Only the main loop may call `beat`, so that systemd notices when that loop hangs.
    """

    def __init__(self, address: str, beat_s: float, clock: Callable[[], float] = time.monotonic) -> None:
        self.beat_s = beat_s
        self._address = "\0" + address[1:] if address.startswith("@") else address
        self._clock = clock
        self._beat_at = 0.0
        self._starting = True
        self._status = ""
        self._waiting: dict[str, str] = {}
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) if address else None

    @classmethod
    def from_environment(cls, environment: MutableMapping[str, str] = os.environ) -> "Notifier":
        """Remove the service manager's variables from the environment, so that no child notifies systemd."""
        address = environment.pop(SOCKET_VARIABLE, "")
        period, pid = environment.pop(PERIOD_VARIABLE, ""), environment.pop(PID_VARIABLE, "")
        meant = pid in {"", str(os.getpid())} and period.isdecimal() and int(period) > 0
        beat_s = int(period) / 1e6 / BEATS_PER_PERIOD if address and meant else float("inf")
        return cls(address if address.startswith(("/", "@")) else "", beat_s)

    def ready(self) -> None:
        """Report that the robot is up."""
        self._starting = False
        self._say("ready", "READY=1")

    def stopping(self, why: str) -> None:
        """Report that the shutdown has begun."""
        self._starting = False
        self._say("stopping", "STOPPING=1")
        self.status(f"stopping: {why}")

    def status(self, text: str) -> None:
        """Report the state in one line, if it has changed."""
        if text != self._status:
            self._status = text
            self._say("status", f"STATUS={one_line(text)}")

    def beat(self) -> None:
        """Report that the main loop runs, and ask for more time to start; cheap enough for every turn."""
        now = self._clock()
        if now < self._beat_at:
            return
        self._beat_at = now + min(self.beat_s, 1.0)
        self._flush()
        if self._starting:
            self._send(MORE_TIME)
        if self.beat_s < float("inf"):
            self._send("WATCHDOG=1")

    def close(self) -> None:
        """Close the socket."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None

    def _say(self, about: str, text: str) -> None:
        self._waiting[about] = text
        self._flush()

    def _flush(self) -> None:
        self._waiting = {about: text for about, text in self._waiting.items() if not self._send(text)}

    def _send(self, text: str) -> bool:
        if self._socket is None:
            return True
        with contextlib.suppress(OSError):
            self._socket.sendto(text.encode(), socket.MSG_DONTWAIT, self._address)
            return True
        return False
