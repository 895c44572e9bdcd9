"""Which robot a command means, and how to reach it."""

import os
import socket
from collections.abc import Iterator
from contextlib import contextmanager

from msgspec import Struct

from lbr import home
from lbr.bus import probe, session, wire
from lbr.bus.access import TOOLS, Credentials
from lbr.bus.codec import Decoder
from lbr.bus.session import Session
from lbr.console.printable import listed, shown
from lbr.errors import BusError, InputError, MalformedError
from lbr.messages.system import Role, Status


class Target(Struct, frozen=True, kw_only=True):
    """A robot to talk to, and how to get in; `running` is its record if it runs on this machine.

    `role` is the one whose console lines it takes from us.
    """

    robot: str
    endpoints: tuple[str, ...]
    credentials: Credentials | None = None
    role: Role = "operate"
    running: home.Running | None = None


def source(what: str) -> str:
    """Return who this process is to a robot: `console@host:pid`."""
    return f"{what}@{socket.gethostname()[:40]}:{os.getpid()}"


def find(robot: str | None, connect: str | None) -> Target:
    """Return the robot that is meant: the named one, the one behind `connect`, or the only one that runs here."""
    here = home.running()
    if connect:
        return _behind(connect, robot, here)
    wanted = [one for one in here if robot in {None, one.robot}]
    if len(wanted) == 1:
        one = wanted[0]
        return _here(one)
    names = listed([one.robot for one in here], "and")
    if robot:
        there = f"{names} run here" if here else "none runs here"
        raise BusError(f"robot '{shown(robot)}' does not run here ({there}); 'lbr run' starts one")
    if not here:
        raise BusError("no robot runs here; 'lbr run' starts one, and --connect ENDPOINT reaches one elsewhere")
    raise InputError(f"several robots run here: {names}; say which with --robot NAME")


@contextmanager
def connected(target: Target) -> Iterator[Session]:
    """Open a session to a robot for the time of a `with`."""
    bus = session.open_client(target.endpoints, target.credentials)
    try:
        yield bus
    finally:
        bus.close()


def _behind(connect: str, robot: str | None, here: list[home.Running]) -> Target:
    local = [one for one in here if connect in one.endpoints]
    if local and robot in {None, local[0].robot}:
        return _here(local[0])
    if robot:
        return Target(robot=robot, endpoints=(connect,))
    with session.open_client([connect]) as bus:
        answers = probe.survey(bus, "*/@status", source=source("lbr"))
    names = sorted({name for name in map(_robot_of, answers) if name})
    if len(names) == 1:
        return Target(robot=names[0], endpoints=(connect,))
    if not names:
        raise BusError(f"something listens at {shown(connect)}, but no robot answers there")
    raise InputError(f"several robots are behind {shown(connect)}: {listed(names, 'and')}; say which with --robot NAME")


def _here(running: home.Running) -> Target:
    """Return a robot of this home; whoever can read its record has all rights."""
    credentials = Credentials(user=TOOLS, password=running.password)
    return Target(
        robot=running.robot, endpoints=(running.core,), credentials=credentials, role="admin", running=running
    )


def _robot_of(answer: wire.Raw) -> str:
    try:
        return Decoder(Status).decode(answer.payload).robot
    except MalformedError:
        return ""
