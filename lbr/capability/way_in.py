"""The way of a capability onto the bus: by a session of its own, or by one that it shares with those of its process."""

import threading
from collections import defaultdict

from lbr.bus import session
from lbr.bus.shared_session import SharedSession
from lbr.capability.config import ProcessConfig


class Place:
    """Where those of one process come in: routers know what they may do as one. Opening it holds up nobody."""

    def __init__(self) -> None:
        self.lock = threading.Lock()
        self.session: SharedSession | None = None

    def leave(self) -> None:
        """Open it anew for the next one."""
        self.session = None


_places: defaultdict[tuple[str, ...], Place] = defaultdict(Place)


def enter(config: ProcessConfig) -> session.Session:
    """Enter as a capability; raise BusError if the robot's router does not let it in."""
    if not config.process:
        return enter_alone(config)
    place = _places[config.endpoints]
    with place.lock:
        if place.session is None:
            place.session = SharedSession(enter_alone(config), place.leave, place.lock)
        return place.session.enter()


def enter_alone(config: ProcessConfig) -> session.Session:
    """Open a session that is shared with nobody; raise BusError if the robot's router does not let it in."""
    return session.open_client(config.endpoints, config.credentials, certificate=config.certificate)
