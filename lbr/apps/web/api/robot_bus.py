"""The bus as the API uses it: a session beside the process's own, so that what pages look at delays no heartbeat."""

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
        """Hear the newest `depth` messages of a key, kept by the bus library until they are taken."""
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
        """Ask by a query what has waited here for so long, and was said at `sent_s`; BusError if that cannot be sent."""
        return PendingQuery(
            self._session,
            key,
            payload,
            timeout_s=timeout_s,
            source=source,
            waited_s=waited_s,
            sent_s=sent_s,
            wake=wake,
        )

    def transport(
        self, source: str, keys: Mapping[str, str], wake: Callable[[], None], origin: Origin | None = None
    ) -> Transport:
        """Return by what motion is borrowed that somebody wants since then: `keys` by request."""
        return OverSession(self._session, source, keys, wake=wake, origin=origin)

    def close(self) -> None:
        """Leave the bus."""
        self._session.close()


def opened(ctx: object) -> RobotBus | None:
    """Return a session for the API; None where the process runs on another machine, which has no rights for it."""
    config = getattr(ctx, "config", None)
    return RobotBus(config) if isinstance(config, ProcessConfig) and not config.host else None
