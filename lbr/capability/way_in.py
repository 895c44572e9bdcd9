"""How a capability's process comes onto the bus."""

from lbr.bus import session
from lbr.capability.config import ProcessConfig


def enter(config: ProcessConfig) -> session.Session:
    """Open a session as this process; raise BusError if the robot's router does not let it in.

    On the robot's own computer the executive hears its heartbeats, so its link says less often that it is there.
    """
    lease_ms = session.LINK_LEASE_MS if config.host else session.WATCHED_MS
    return session.open_client(config.endpoints, config.credentials, certificate=config.certificate, lease_ms=lease_ms)
