"""The connection of a capability to the bus: a session of its own, or one that its process shares."""

from collections import defaultdict
from functools import partial

from lbr.bus import session
from lbr.bus.transport import SharedSession, ZenohTransport
from lbr.capability.config import ProcessConfig

_shared: defaultdict[tuple[str, ...], SharedSession] = defaultdict(SharedSession)
"""By the endpoints at which these capabilities connect: to a router, they are one user."""


def join(config: ProcessConfig, *, alone: bool) -> ZenohTransport:
    """Connect as a capability; `alone` opens a session of its own. Raise BusError if the robot's router refuses it."""
    if config.process and not alone:
        return _shared[config.endpoints].enter(partial(enter_alone, config))
    opened = enter_alone(config)
    return ZenohTransport(opened, opened.close)


def enter_alone(config: ProcessConfig) -> session.Session:
    """Open a session that nobody shares; raise BusError if the robot's router refuses it."""
    return session.open_client(config.endpoints, config.credentials, certificate=config.certificate)
