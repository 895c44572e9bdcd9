"""The server of a row: where it listens, the loop's side of its thread, and what it reports."""

from collections.abc import Awaitable, Callable, Iterable

from starlette.routing import BaseRoute
from starlette.types import ASGIApp

from lbr.apps.http import listening
from lbr.apps.http.pages import Pages
from lbr.apps.http.rates import Rates
from lbr.apps.web.advertised_address import AdvertisedAddress
from lbr.apps.web.application import Gate, application
from lbr.apps.web.bridge import Bridge
from lbr.apps.web.face import Route
from lbr.apps.web.guards import Counts
from lbr.apps.web.server_settings import ServerSettings
from lbr.apps.web.serving import Serving
from lbr.capability.context import Context
from lbr.errors import BusError, DeviceError, InputError

CLEAR_TEXT = (
    "other machines reach the robot in clear text: a machine in between reads tokens, and changes what is asked"
)


class Front:
    """The server of a row, in its thread; `bridge` runs coroutines of that thread in the capability's loop.

    `service` names it in its report, `service_url` makes its URLs from those for a browser.
    """

    def __init__(self, ctx: Context[ServerSettings], service: str, service_url: Callable[[str], str] = str) -> None:
        self.counts = Counts()
        self.bridge = Bridge(ctx.wake, self._failed)
        self.place = AdvertisedAddress(ctx.settings, ctx.settings.port, own_addresses=tuple)
        self.is_loopback = True
        """True if the server is reachable from this machine only."""
        self._ctx = ctx
        self._service = service
        self._service_url = service_url
        self._serving: Serving | None = None

    @property
    def listens(self) -> bool:
        """Return whether the server runs."""
        return self._serving is not None

    @property
    def connections(self) -> int:
        """Return the number of open connections."""
        return self._serving.connections if self._serving is not None else 0

    @property
    def urls(self) -> tuple[str, ...]:
        """Return the URLs for the clients of this service."""
        return tuple(self._service_url(url) for url in self.place.urls)

    def open(
        self,
        app: Callable[[], ASGIApp],
        *,
        plain_here: bool = False,
        beside: Callable[[], Awaitable[None]] | None = None,
    ) -> None:
        """Listen, and serve the app, which is made once the address is known; raise DeviceError if that fails."""
        settings = self._ctx.settings
        try:
            sockets = listening.listen(settings.host, settings.port)
        except InputError as err:
            name = self._ctx.name
            raise DeviceError(f"{err}: try 'lbr set {name}.port NUMBER', or {name}.host") from err
        self.place = AdvertisedAddress(settings, sockets[0].getsockname()[1])
        self.is_loopback = listening.is_loopback(sockets[0])
        self.bridge.open()
        try:
            self._serving = Serving(app(), sockets, tls=self.place.tls, plain_here=plain_here, beside=beside)
        except (InputError, BusError) as err:
            for one in sockets:
                one.close()
            raise DeviceError(str(err)) from err
        self._serving.start()
        self._ctx.event("listening", f"{self._service} at {', '.join(self.urls) or settings.host}")
        if self.place.open and not self.place.tls:
            self._ctx.event("exposed", CLEAR_TEXT, level="warning")

    def application(
        self, routes: Iterable[Route], *doors: BaseRoute, gate: Gate, pages: Pages, requests_per_s: float
    ) -> ASGIApp:
        """Return the application of this server."""
        return application(
            routes,
            *doors,
            gate=gate,
            pages=pages,
            rates=Rates(requests_per_s),
            own_names=frozenset(name.lower() for name in (*self._ctx.settings.names, *self.place.names)),
            counts=self.counts,
            in_loop=self.bridge.call,
        )

    def publish_news(self) -> None:
        """Publish the events of the server's thread."""
        while self.counts.news:
            kind, text, level = self.counts.news.popleft()
            self._ctx.event(kind, text, level=level)

    def close(self, why: str) -> None:
        """End the server, and refuse the requests that are still under way."""
        if self._serving is not None:
            self._serving.stop()
            self._serving = None
        self.bridge.close(why)

    def _failed(self, err: Exception) -> None:
        self.counts.tell("web_fault", f"{type(err).__name__}: {err}", "error")
