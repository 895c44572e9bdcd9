"""How a capability comes onto the bus: by a session of its own, or by one that it shares with those of its process."""

import threading

from lbr.bus import session
from lbr.bus.shared_session import SharedSession
from lbr.capability.config import ProcessConfig

_shared: dict[tuple[str, ...], SharedSession] = {}
"""By where they come in: routers know what those of one process may do as one."""
_entering = threading.Lock()


def enter(config: ProcessConfig) -> session.Session:
    """Enter as a capability; raise BusError if the robot's router does not let it in."""
    if not config.process:
        return enter_alone(config)
    with _entering:
        place = config.endpoints
        if place not in _shared:
            _shared[place] = SharedSession(enter_alone(config), lambda: _shared.pop(place), _entering)
        return _shared[place].enter()


def enter_alone(config: ProcessConfig) -> session.Session:
    """Open a session that is shared with nobody; raise BusError if the robot's router does not let it in.

    On the robot's own computer the executive hears its heartbeats, so its link says less often that it is there.
    """
    lease_ms = session.LINK_LEASE_MS if config.host else session.WATCHED_MS
    return session.open_client(config.endpoints, config.credentials, certificate=config.certificate, lease_ms=lease_ms)
