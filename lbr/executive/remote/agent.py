"""The agent: runs a host's share of a robot that is on another machine, for as long as there is contact with it.

    find the robot ──► report, get the share ──► supervise it ──► contact lost, or the robot ends ──► end the share
          ▲                                                                                                 │
          └─────────────────────────────────────────────────────────────────────────────────────────────────┘

After a loss, nothing resumes by itself: the processes are new, and the old ones took their leases along.
"""

import os
import secrets
import signal
import socket
import threading
import time
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

from lbr.bus import session
from lbr.capability.confine import keep_private
from lbr.console import remote, target
from lbr.console.outlet import settle
from lbr.console.remote import RefusedError
from lbr.console.target import Target
from lbr.errors import BusError
from lbr.executive.processes import scheduling
from lbr.executive.processes.fork_server import ForkServer
from lbr.executive.processes.mainthread import MainThread
from lbr.executive.processes.reaper import Reaper
from lbr.executive.remote.agent_session import AgentSession

AGAIN_S = 0.5
CLOSE_S = 0.3
Say = Callable[[str], None]


class Agent:
    """Serves as one host of the robot at an endpoint, whenever that robot runs. `say` reports to people."""

    def __init__(self, host: str, endpoint: str, token_file: Path | None, robot: str | None, say: Say) -> None:
        self._host = host
        self._endpoint = endpoint
        self._token_file = token_file
        self._robot = robot
        self._say = say
        self._said = ""
        self._main = MainThread()
        self._stopping = False
        self._closing = threading.Thread()
        self._id = secrets.token_hex(8)

    def run(self) -> int:
        """Serve until asked to end, and return 0; raise RefusedError or InputError if the robot refuses this host."""
        scheduling.rank(os.getpid(), scheduling.MOTION)  # only a lost link may end the contact, not a busy moment
        keep_private()
        signal.set_wakeup_fd(self._main.wake_fd, warn_on_full_buffer=False)
        for number in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP):
            signal.signal(number, lambda _number, _frame: self._stop())
        with (
            closing(Reaper()) as self._reaper,
            closing(ForkServer(self._reaper, "agent")) as self._forks,
        ):
            self._serve()
        if self._closing.is_alive():
            settle()
            os._exit(0)  # its thread is in the bus library, and would delay the end
        return 0

    def _serve(self) -> None:
        while not self._stopping:
            try:
                why = self._stay(self._find_robot())
            except RefusedError:
                raise
            except BusError as err:
                why = str(err)
            if not self._stopping:
                self._tell(f"{why}; waiting for the robot")
                self._pause()

    def _find_robot(self) -> Target:
        """Return the robot. It must run and know this token, which must be one for this host."""
        if not self._endpoint.startswith(remote.PROTOCOL):
            raise RefusedError(
                f"a robot on another machine is reached by tls, as tls/192.168.1.7:7447: {self._endpoint}"
            )
        remote.certificate_at(self._endpoint)
        robot = target.find(self._robot, self._endpoint, self._token_file)
        user = robot.credentials.user if robot.credentials is not None else ""
        if user != self._host:
            text = f"the token is for '{user}'; host '{self._host}' comes in with one of its own name"
            raise RefusedError(f"{text}: 'lbr token add {self._host} --role host' at the robot")
        return robot

    def _stay(self, robot: Target) -> str:
        where = f"{socket.gethostname()[:40]}, pid {os.getpid()}"
        bus = session.open_client(robot.endpoints, robot.credentials, certificate=robot.certificate)
        try:
            stay = AgentSession(
                bus,
                robot,
                self._host,
                self._main,
                self._reaper,
                self._forks,
                agent=self._id,
                where=where,
                say=self._tell,
            )
            return stay.run(lambda: self._stopping)
        finally:
            self._close(bus)

    def _close(self, bus: session.Session) -> None:
        """Leave the bus; without a link the bus library waits until there is one, so this does not wait for it."""
        self._closing = threading.Thread(target=bus.close, daemon=True)
        self._closing.start()
        self._closing.join(CLOSE_S)

    def _pause(self) -> None:
        until = time.monotonic() + AGAIN_S
        while not self._stopping and time.monotonic() < until:
            self._main.wait(until - time.monotonic(), ())

    def _tell(self, text: str) -> None:
        if text != self._said:
            self._said = text
            self._say(text)

    def _stop(self) -> None:
        self._stopping = True
        self._main.wake()
