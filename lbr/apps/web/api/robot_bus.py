"""The bus for the API: a session beside the process's own, so that the streams of pages delay no heartbeat."""

from collections.abc import Callable, Mapping

from lbr.bus.stamp import Origin
from lbr.bus.wire import PendingQuery, PolledSubscription
from lbr.capability import way_in
from lbr.capability.config import ProcessConfig
from lbr.leases.client import Transport
from lbr.leases.over_session import OverSession


class RobotBus:
    """A session to the robot's own router."""

    def __init__(self, config: ProcessConfig) -> None:
        self._session = way_in.enter_alone(config)

    def hear(self, key: str, *, depth: int = 1) -> PolledSubscription:
        """Subscribe to the newest `depth` messages of a key, which the bus library keeps until they are taken."""
        return PolledSubscription(self._session, key, depth=depth)

    def ask(
        self,
        key: str,
        payload: bytes,
        *,
        source: str,
        timeout_s: float,
        waited_s: float = 0.0,
        sent_s: float | None = None,
        wake: Callable[[], None] = lambda: None,
    ) -> PendingQuery:
        """Query the robot; raise BusError if that cannot be sent.

        `waited_s` is the time that the request has waited here, `sent_s` its date if that is not now.
        """
        return PendingQuery(
            self._session, key, payload, timeout_s=timeout_s, source=source, waited_s=waited_s, sent_s=sent_s, wake=wake
        )

    def transport(
        self, source: str, keys: Mapping[str, str], wake: Callable[[], None], origin: Origin | None = None
    ) -> Transport:
        """Return a transport that leases motion; `keys` by request, `origin` is the client's wish and its date."""
        return OverSession(self._session, source, keys, wake=wake, origin=origin)

    def close(self) -> None:
        """Leave the bus."""
        self._session.close()


def opened(ctx: object) -> RobotBus | None:
    """Return a session for the API; None on another machine than the robot's, which has no rights for it."""
    config = getattr(ctx, "config", None)
    return RobotBus(config) if isinstance(config, ProcessConfig) and not config.host else None
