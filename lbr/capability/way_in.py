"""The way of a capability onto the bus: by a session of its own, or by one that it shares with those of its process."""

from collections import defaultdict
from functools import partial

from lbr.bus import session
from lbr.bus.transport import SharedSession, ZenohTransport
from lbr.capability.config import ProcessConfig

_shared: defaultdict[tuple[str, ...], SharedSession] = defaultdict(SharedSession)
"""By the endpoints at which those of this process come in: a router knows what they may do as one."""


def join(config: ProcessConfig, *, alone: bool) -> ZenohTransport:
    """Enter as a capability, `alone` with a session that is shared with nobody; raise BusError if the robot's router
    does not let it in."""
    if config.process and not alone:
        return _shared[config.endpoints].enter(partial(enter_alone, config))
    opened = enter_alone(config)
    return ZenohTransport(opened, opened.close)


def enter_alone(config: ProcessConfig) -> session.Session:
    """Open a session that is shared with nobody; raise BusError if the robot's router does not let it in."""
    return session.open_client(config.endpoints, config.credentials, certificate=config.certificate)
