"""A robot whose profile places some of it on another machine, and the agent there, for tests."""

import os
import signal
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from lbr.bus.tokens import Token
from tests.support import programs
from tests.support.door import add_token
from tests.support.robot import LBR, Robot, free_port, prepare, running
from tests.support.trace import Trace
from tests.support.waiting import until

FAR = '''
"""Moves nothing, but would have to stop if it did."""

from lbr.capability.base import Capability
from lbr.capability.kind import Kind


class FarMover(Capability):
    def open(self):
        pass

    def step(self):
        self.ctx.estop.acknowledge(stopped=self.ctx.estop.engaged)


KIND = Kind(name="far_mover", summary="for tests", family="operation", entry=FarMover, moves=True)
'''
PROFILE = """
robot = "lbr"
simulate = true

[hosts]
operator = ["attitude", "dance", "far_mover"]
bench = ["telemetry"]
"""
ROLES = {"operator": "host", "bench": "operate", "kitchen": "host"}


class Two:
    """The robot's machine and the operator's, which has a home of its own."""

    def __init__(
        self, robot: Robot, endpoint: str, held: dict[str, Token], away: Path, elsewhere: tuple[str, ...]
    ) -> None:
        self.robot = robot
        self.endpoint = endpoint
        self.tokens = held
        self.away = away
        self.elsewhere = elsewhere
        self.trace = Trace(robot.trace)
        self.said = away / "agent.txt"

    def start(self, host: str, token: str) -> "subprocess.Popen[bytes]":
        """Start an agent on the other machine."""
        environment = os.environ | {"LBR_HOME": str(self.away), "LBR_TOKEN": token, "PYTHONUNBUFFERED": "1"}
        if not token:
            del environment["LBR_TOKEN"]
        with self.said.open("ab") as said:
            return programs.start(
                [*self.elsewhere, *LBR, "agent", host, "--connect", self.endpoint],
                env=environment,
                stdin=subprocess.DEVNULL,
                stdout=said,
                stderr=subprocess.PIPE,
            )

    @contextmanager
    def agent(self) -> Iterator["subprocess.Popen[bytes]"]:
        """Have the operator's agent, with its share ready."""
        popen = self.start("operator", str(self.tokens["operator"]))
        try:
            self.ready()
            yield popen
        finally:
            end(popen)

    def ready(self) -> None:
        try:
            until(lambda: self.phases() == {"ready"})
        except AssertionError:
            said, logs = self.said.read_text()[-1000:], sorted((self.away / "logs").glob("*.log"))
            written = {log.name: log.read_text()[-500:] for log in logs}
            raise AssertionError(f"the share is not ready: {self.units()}; the agent: {said}; {written}") from None

    def units(self) -> dict[str, dict]:
        return {one["name"]: one for one in self.robot.status()["capabilities"] if one["host"] == "operator"}

    def phases(self) -> set[str]:
        return {one["phase"] for one in self.units().values()}

    def pids(self) -> dict[str, int]:
        return {name: one["pid"] for name, one in self.units().items()}

    def losses(self) -> list[str]:
        return [f"{one['wall_ns']} {one['text']}" for one in self.robot.events() if one["kind"] == "host_lost"]

    def moving(self) -> bool:
        return not self.trace.now().zero

    def dancing(self) -> None:
        """Have it dance; on a busy machine an app may lose its link or its lease, and is asked again."""
        until(self._dances, what="it dances")

    def _dances(self) -> bool:
        return self.moving() or (self.robot.line("/d/metronome")["code"] == 0 and self.moving())

    def stops_within(self, seconds: float) -> None:
        since_ns = time.monotonic_ns()
        assert self.trace.first_zero(since_ns, seconds) is not None

    def stands_for(self, seconds: float) -> None:
        since_ns = time.monotonic_ns()
        until(lambda: time.monotonic_ns() - since_ns > seconds * 1e9, limit_s=seconds + 2.0, what="time passes")
        assert all(output.zero for output in self.trace.outputs(since_ns))


def end(popen: "subprocess.Popen[bytes]") -> int:
    if popen.poll() is None:
        popen.send_signal(signal.SIGTERM)
    try:
        return popen.wait(6.0)
    finally:
        popen.kill()
        popen.wait()
        assert popen.stderr is not None
        popen.stderr.close()


@contextmanager
def placed(home: Path, address: str, prefix: tuple[str, ...], elsewhere: tuple[str, ...]) -> Iterator[Two]:
    """Run such a robot."""
    insert = "INSERT INTO capability (robot, name, kind, help) VALUES ('lbr', 'far_mover', 'far_mover', '')"
    prepare(home, "imu", "attitude", "dance", "telemetry", edits=(insert,))
    away = home.parent / "away"
    for place in (home, away):
        (place / "capabilities").mkdir(mode=0o700, parents=True)
        (place / "capabilities" / "far_mover.py").write_text(FAR)
    profile = home.parent / "two.toml"
    profile.write_text(PROFILE)
    held = {name: add_token(home, name, role) for name, role in ROLES.items()}
    endpoint = f"tls/{address}:{free_port()}"
    with running(home, "--listen", endpoint, profile=str(profile), prefix=prefix) as robot:
        until(lambda: robot.capability("lan")["phase"] == "ready", what="the door is open")
        yield Two(robot, endpoint, held, away, elsewhere)
