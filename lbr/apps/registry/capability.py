"""Registering as a capability: reports the robot and its addresses to the service every few seconds."""

import threading
import time
from collections.abc import Callable
from contextlib import suppress
from urllib.parse import urlsplit

import msgspec
from msgspec.structs import replace

from lbr import home, plugins
from lbr.apps.http import names
from lbr.apps.registry import asking
from lbr.apps.registry.book import Entry
from lbr.apps.registry.kind import RegistrarSettings
from lbr.apps.registry.messages import RegistrarState
from lbr.apps.retry import wait_s
from lbr.bus import tokens
from lbr.bus.tokens import Token
from lbr.capability.base import Capability
from lbr.capability.border import border
from lbr.capability.context import Context
from lbr.errors import DeviceError, InputError, LbrError, told
from lbr.messages.codes import Reason
from lbr.messages.web import WebState

PUBLISH_S = 1.0
GOODBYE_S = 0.3
MOST_URLS = 8
NO_SERVICE = (
    "no registry is named: write its address into the setting 'url' of this row; `lbr registry serve` starts one"
)


class Herald:
    """Reports `entry` repeatedly, in a thread of its own; `trouble` is why the last report failed, or empty."""

    def __init__(self, url: str, token: Token, entry: Entry, changed: Callable[[], None]) -> None:
        self.entry = entry
        self.trouble = "it was not reached yet"
        self.times = 0
        self._url = url
        self._token = token
        self._changed = changed
        self._began = time.monotonic()
        self._now = threading.Event()
        self._ends = False
        self._thread = threading.Thread(target=self._run, name="registrar", daemon=True)

    def start(self) -> None:
        """Start the thread."""
        self._thread.start()

    def register(self, entry: Entry) -> None:
        """Report another entry, at once."""
        if entry != self.entry:
            self.entry = entry
            self._now.set()

    def close(self) -> None:
        """Report that the robot leaves, if the service answers soon."""
        self._ends = True
        self._now.set()
        self._thread.join(GOODBYE_S)

    def _run(self) -> None:
        tries = 0
        while not self._ends:
            self._now.clear()
            up_s = time.monotonic() - self._began
            faults: list[Exception] = []
            with border(faults.append):
                asking.ask(self._url, self._token, "POST", msgspec.json.encode(replace(self.entry, up_s=up_s)))
            self.trouble = "".join(str(err) if isinstance(err, LbrError) else told(err) for err in faults)
            tries = tries + 1 if faults else 0
            self.times += not faults
            self._changed()
            self._now.wait(wait_s(tries) if tries else self.entry.every_s)
        if not self.trouble:
            with suppress(LbrError, OSError, ValueError):  # without it the service notices the silence
                asking.ask(self._url, self._token, "DELETE", within_s=GOODBYE_S)


class Registrar(Capability[RegistrarSettings]):
    """Registers the robot with the service."""

    rate_hz = 2.0
    woken_by_streams = False

    def __init__(self, ctx: Context[RegistrarSettings]) -> None:
        super().__init__(ctx)
        self._herald: Herald | None = None
        self._name = ""
        self._web: dict[str, WebState] = {}
        self._published: RegistrarState | None = None
        self._published_at = 0.0

    def open(self) -> None:
        """Begin to register."""
        settings = self.ctx.settings
        if not settings.url:
            return
        try:
            token = _token(settings.credential)
        except InputError as err:
            raise DeviceError(str(err), "token") from err
        self._name = token.name
        self._herald = Herald(settings.url, token, self._entry(), self.ctx.wake)
        self._herald.start()

    def step(self) -> None:
        """Follow the robot's addresses, and publish the state."""
        for received in self.ctx.take("web"):
            self._web[received.source] = received.message
        herald = self._herald
        if herald is not None:
            herald.register(self._entry())
        health = Reason("off", NO_SERVICE) if herald is None else Reason("unreachable", herald.trouble)
        if health.text:
            self.ctx.warn(health)
        else:
            self.ctx.ready()
        self._publish_state(herald, health)

    def close(self) -> None:
        """Report that the robot leaves."""
        herald, self._herald = self._herald, None
        if herald is not None:
            herald.close()

    def _entry(self) -> Entry:
        settings = self.ctx.settings
        urls = [
            url for _, state in sorted(self._web.items()) if state.listening for url in state.urls if _is_reached(url)
        ]
        return Entry(
            robot=self.ctx.robot,
            version=plugins.version(),
            urls=tuple(urls[:MOST_URLS]),
            endpoints=settings.endpoints,
            every_s=settings.every_s,
        )

    def _publish_state(self, herald: Herald | None, health: Reason) -> None:
        now, entry = self.ctx.clock(), self._entry()
        state = RegistrarState(
            registered=herald is not None and not herald.trouble,
            url=self.ctx.settings.url,
            name=self._name,
            urls=entry.urls,
            endpoints=entry.endpoints,
            reason=health.text,
            code=health.code if health.text else "",
            times=herald.times if herald is not None else 0,
        )
        if state != self._published or now - self._published_at >= PUBLISH_S:
            self._published, self._published_at = state, now
            self.ctx.publish("state", state)


def _is_reached(url: str) -> bool:
    """Return whether other machines may reach a URL."""
    host = urlsplit(url).hostname or ""
    return bool(host) and host != "localhost" and not names.is_loopback(host)


def _token(name: str) -> Token:
    """Return the token in a file of `credentials/`; raise InputError with its fault."""
    files = home.given_credentials(name)
    if not files:
        where = home.directory("credentials") / name
        raise InputError(f"{where} is not there: put what `lbr registry add NAME` printed into it")
    try:
        return tokens.parse(files[0].read_text(encoding="ascii", errors="replace"))
    except InputError as err:
        raise InputError(f"{files[0]}: {err}") from err
    except OSError as err:
        raise InputError(f"{files[0]} cannot be read ({err.strerror})") from err
