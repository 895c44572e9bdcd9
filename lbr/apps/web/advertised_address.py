"""The address of the server, as URLs and in words."""

from collections.abc import Callable
from contextlib import suppress

from lbr import home, qr
from lbr.apps.http import names
from lbr.apps.web import addresses
from lbr.apps.web.server_settings import ServerSettings
from lbr.bus import certificates
from lbr.errors import InputError


class AdvertisedAddress:
    """The addresses of a server at `port`, and the names in its certificate. From any thread.

    `look` reads the machine's addresses again.
    """

    def __init__(
        self, settings: ServerSettings, port: int, own_addresses: Callable[[], tuple[str, ...]] = addresses.of_machine
    ) -> None:
        self.port = port
        self.open = not names.is_local(settings.host)
        self.tls = settings.tls or (self.open and not settings.clear_text)
        self.names = (certificates.NAME,) if self.tls else ()
        self.urls: tuple[str, ...] = ()
        self.addresses: tuple[str, ...] = ()
        self._settings = settings
        self._certified = ""
        if self.tls and settings.names:
            with suppress(InputError):  # the server reports the error when it reads the files
                self._certified = settings.names[0] if home.given_credentials(*certificates.OWN_FILES) else ""
        self._own_addresses = own_addresses
        self.look()

    def look(self) -> tuple[str, ...]:
        """Read and return the present addresses."""
        self.addresses = addresses.reached_at(self._settings.host, self._own_addresses() if self.open else ())
        self.urls = tuple(addresses.url(one, self.port, tls=self.tls) for one in self.addresses)
        return self.addresses

    @property
    def url(self) -> str:
        """The most useful URL; empty without a network.

        With the owner's certificate it has the first name of the setting `names`, as that certificate is for names.
        """
        if self.urls and self._certified:
            return addresses.url(self._certified, self.port, tls=True)
        return self.urls[0] if self.urls else ""

    @property
    def local(self) -> str:
        """The URL with this machine's name in multicast DNS; it works while the server is announced."""
        return addresses.url(names.announced(), self.port, tls=self.tls)

    def words(self) -> str:
        """Return in a few lines who can reach the server, and how to change that."""
        if not self.open:
            return f"Only this machine reaches {self.url}. 'phone' lets a phone in your network reach it."
        if not self.urls:
            return f"The server listens at port {self.port}, but this machine is in no network now."
        others = f"\nAlso at {', '.join(self.urls[1:])}" if self.urls[1:] else ""
        return f"{self.url}{others}\n{self._clients()}"

    def text(self) -> str:
        """Return the URL with its QR code, for a terminal."""
        if not (self.open and self.urls):
            return self.words()
        return f"{qr.characters(self.url)}\n{self.words()}\nIf a camera does not read it, open {self.url}qr"

    def _clients(self) -> str:
        networks = [one for one in self._settings.trusted if not names.is_local(one.partition("/")[0])]
        if networks:
            return f"Clients in {' or '.join(networks)} need no token; all others do: 'phone' gives a phone one."
        return "Other machines need a token: 'phone' gives a phone one, 'lbr token add NAME --for web' a program."
