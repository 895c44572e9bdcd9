"""The robot that a command means, and the connection to it."""

import os
import socket
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from msgspec import Struct

from lbr import home
from lbr.bus import keys, probe, session, wire
from lbr.bus.access import TOOLS, Credentials
from lbr.bus.codec import Decoder
from lbr.bus.session import Session
from lbr.console import remote
from lbr.console.printable import listed
from lbr.errors import BusError, InputError, MalformedError
from lbr.messages.rows import short
from lbr.messages.system import Role, Status, role_missing


class Target(Struct, frozen=True, kw_only=True):
    """A robot and the way to reach it; `running` is its record if it runs on this machine.

    `role` is our highest role there; `certificate` is set for a robot on another machine.
    """

    robot: str
    endpoints: tuple[str, ...]
    credentials: Credentials | None = None
    certificate: str = ""
    role: Role = "operate"
    running: home.Running | None = None

    @property
    def proof(self) -> Credentials | None:
        """Return the token that proves our identity to a robot elsewhere."""
        return self.credentials if self.certificate else None


def source(what: str) -> str:
    """Return the name of this process for a robot: `console@host:pid`."""
    return f"{what}@{socket.gethostname()[:40]}:{os.getpid()}"


def find(robot: str | None, connect: str | None, token_file: Path | None = None) -> Target:
    """Return the robot that is meant: the named one, the one behind `connect`, or the only one that runs here."""
    running = home.running()
    if connect and connect.startswith(remote.PROTOCOL):
        return _remote_target(connect, robot, remote.enter(connect, token_file))
    if connect:
        return _behind(connect, robot, running)
    wanted = [run for run in running if robot in {None, run.robot}]
    if len(wanted) == 1:
        run = wanted[0]
        return _local_target(run)
    names = listed([run.robot for run in running], "and")
    if robot is not None:
        there = f"{names} {'runs' if len(running) == 1 else 'run'} here" if running else "none runs here"
        raise BusError(f"robot '{short(robot)}' does not run here ({there}); 'lbr run' starts one")
    if not running:
        raise BusError("no robot runs here; 'lbr run' starts one, and --connect ENDPOINT reaches one elsewhere")
    raise InputError(f"several robots run here: {names}; say which with --robot NAME")


def find_to_stop(robot: str | None, connect: str | None, token_file: Path | None = None) -> list[Target]:
    """Return the robots that a stop means: the named one, or all that run here."""
    here = home.running() if robot is None and not connect else []
    return [_local_target(one) for one in here] if len(here) > 1 else [find(robot, connect, token_file)]


def need(target: Target, role: Role) -> None:
    """Raise BusError if a robot would silently drop messages that need this role."""
    if target.certificate and (missing := role_missing(role, target.role)) is not None:
        raise BusError(missing.text)


@contextmanager
def connected(target: Target) -> Iterator[Session]:
    """Open a session to a robot for the time of a `with`."""
    bus = session.open_client(target.endpoints, target.credentials, certificate=target.certificate)
    try:
        yield bus
    finally:
        bus.close()


def _behind(connect: str, robot: str | None, here: list[home.Running]) -> Target:
    local = [one for one in here if connect in one.endpoints]
    if local and robot in {None, local[0].robot}:
        return _local_target(local[0])
    if robot:
        return Target(robot=robot, endpoints=(connect,))
    with session.open_client([connect]) as bus:
        return Target(robot=_only_robot(bus, connect), endpoints=(connect,))


def _remote_target(connect: str, robot: str | None, entry: remote.Entry) -> Target:
    with session.open_client([connect], entry.credentials, certificate=entry.certificate) as bus:
        name = _only_robot(bus, connect)
        if robot not in {None, name}:
            raise InputError(f"the robot at {short(connect)} is '{name}', not '{short(robot)}'")
        role = remote.role_at(bus, name, source("lbr"))
    return Target(
        robot=name, endpoints=(connect,), credentials=entry.credentials, certificate=entry.certificate, role=role
    )


def _only_robot(bus: Session, connect: str) -> str:
    answers = probe.survey(bus, keys.ANY_STATUS, source=source("lbr"))
    names = sorted({name for name in map(_robot_of, answers) if name})
    if len(names) == 1:
        return names[0]
    if not names:
        raise BusError(f"something listens at {short(connect)}, but no robot answers there")
    raise InputError(f"several robots are behind {short(connect)}: {listed(names, 'and')}; say which with --robot NAME")


def _local_target(running: home.Running) -> Target:
    """Return a robot of this home; a user who can read its record has all rights."""
    credentials = Credentials(user=TOOLS, password=running.password)
    return Target(
        robot=running.robot, endpoints=(running.core,), credentials=credentials, role="admin", running=running
    )


def _robot_of(answer: wire.RawMessage) -> str:
    try:
        return Decoder(Status).decode(answer.payload).robot
    except MalformedError:
        return ""
