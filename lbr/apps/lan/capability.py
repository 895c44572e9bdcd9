"""The door as a process: opens its router, checks that it routes, and reports its clients."""

import secrets
import time
from collections import deque
from pathlib import Path

import msgspec

from lbr.apps.lan import rights
from lbr.apps.lan.doorman import Doorman
from lbr.apps.lan.kind import LanSettings
from lbr.apps.lan.passage import Passage, Standstill
from lbr.apps.lan.relay import Relay
from lbr.bus import certificates, keys, session, tokens, wire
from lbr.bus.access import Credentials
from lbr.bus.door import LanConfig, LanUser
from lbr.bus.library_log import ACCEPTED, LibraryLog
from lbr.bus.links import Coming, Links
from lbr.bus.session import Router, Session, Tls
from lbr.capability.base import Capability
from lbr.capability.config import NOTHING
from lbr.capability.runtime import ProcessContext
from lbr.errors import BusError, DeviceError

ROUTES_WITHIN_S = 1.0
ASK_AGAIN_S = 0.02
STUCK_ROUNDS = 30
"""The rounds of the main loop, ten a second, without one of another thread. A busy machine delays both alike."""
ASKED_S = 1.0


class Lan(Capability[LanSettings]):
    """The door.

    Raises DeviceError if it cannot listen; any other trouble ends the process, and the next one starts afresh.
    """

    rate_hz = 10.0
    ctx: ProcessContext  # only the process's own context has the door's configuration

    def __init__(self, ctx: ProcessContext) -> None:
        super().__init__(ctx)
        if ctx.config.private == NOTHING:
            raise ValueError("the executive gave no door to open")
        self._lan = msgspec.json.decode(ctx.config.private, type=LanConfig)
        self._users = _proven(self._lan)
        self._sessions: list[Session] = []
        self._question: wire.PendingQuery | None = None
        self._relay: Relay | None = None
        self._too_much: deque[str] = deque(maxlen=64)
        self._doorman = Doorman(LibraryLog(ACCEPTED), ctx.clock)

    def open(self) -> None:
        """Listen, and start the relay."""
        password = secrets.token_hex(16)
        router = self._open_router(password)
        self._doorman.watch(frozenset(int(endpoint.rpartition(":")[2]) for endpoint in self._lan.listen))
        inside = self._opened(
            session.open_client([self._lan.inside], Credentials(user=rights.RELAY, password=password))
        )
        self._wait_until_it_routes(inside)
        robot_side = self._opened(session.open_client(self.ctx.config.endpoints, self.ctx.config.credentials))
        self._inside = inside
        self._inner = wire.Subscription(inside, keys.status(self.ctx.robot))
        self._outer = wire.Subscription(robot_side, keys.status(self.ctx.robot))
        self._passage, self._question = Passage(), None
        self._still = Standstill()
        self._router, self._clients = router, set[str]()
        self._streams: list[wire.PolledSubscription] = []
        self._links = Links(router, ("tls", "tcp"))
        self._relay = Relay(
            inside,
            robot_side,
            self.ctx.robot,
            tuple(self._lan.commands),
            via=self.ctx.name,
            secrets={name: user.secret.encode() for name, user in self._users.items()},
            refused=self._too_much.append,
        )
        self._says = f"at {', '.join(self._lan.listen)}{self._certified()}, tokens: {len(self._users)}"
        self.ctx.event("listening", self._says)
        self._report_unproven()

    def step(self) -> None:
        """Report events; end the process if messages do not pass."""
        refused = self._doorman.refused
        self.ctx.ready(self._says + (f", wrong tokens: {refused}" if refused else ""))
        for refusal in self._doorman.take():
            self.ctx.event("login_refused", refusal.text, level="warning", data={"address": refusal.host})
        for one in self._links.take():
            self._report_link(one)
        self._subscribe_streams()
        while self._too_much:
            self.ctx.event("refused", self._too_much.popleft(), level="warning")
        self._check()

    def close(self) -> None:
        """Close the door."""
        self._doorman.close()
        if self._relay is not None:
            self._relay.close()
            self._relay = None
        while self._sessions:
            self._sessions.pop().close()

    def _open_router(self, password: str) -> Session:
        lan, robot = self._lan, self.ctx.robot
        secure = any(endpoint.startswith("tls/") for endpoint in lan.listen)
        users = {name: user.secret for name, user in self._users.items()}
        users |= {guest.credentials.user: guest.credentials.password for guest in lan.guests}
        try:
            router = session.open_router(
                Router(
                    listen=(*lan.listen, lan.inside),
                    robot=robot,
                    users={**users, rights.RELAY: password},
                    rights={
                        **{name: rights.of_token(robot, lan, name, user.role) for name, user in self._users.items()},
                        **{guest.credentials.user: guest.rights for guest in lan.guests},
                        rights.RELAY: rights.of_relay(robot, lan),
                    },
                    links={lan.upstream: rights.of_upstream(lan)},
                    connect=self.ctx.config.endpoints,
                    credentials=lan.link,
                    tls=Tls(private_key=lan.private_key, certificate=lan.certificate) if secure else None,
                    limits=rights.limits(robot, lan),
                    never_waiting=(keys.console(robot, "view"),),
                )
            )
        except BusError as err:
            raise DeviceError(str(err)) from err
        return self._opened(router)

    def _opened(self, opened: Session) -> Session:
        self._sessions.append(opened)
        return opened

    def _wait_until_it_routes(self, inside: Session) -> None:
        """Wait for a new router, which needs a tenth of a second to route; raise BusError for one that never does."""
        end = time.monotonic() + ROUTES_WITHIN_S
        status = keys.status(self.ctx.robot)
        while not wire.ask(inside, status, None, source=self.ctx.name, timeout_s=0.3):
            if not time.monotonic() < end:
                raise BusError("the door is open, but nothing passes through it to the robot")
            time.sleep(ASK_AGAIN_S)

    def _subscribe_streams(self) -> None:
        """Subscribe to each stream of the robot's rows while clients are connected.

        A client's other subscriptions, such as wildcards, reach only the door, so they cannot burden the robot's own
        router.
        """
        if self._clients and not self._streams:
            self._streams = [wire.PolledSubscription(self._router, key) for key in self._lan.subscribed]
        while self._streams and not self._clients:
            self._streams.pop().close()

    def _check(self) -> None:
        """Check that the robot's statuses come on both sides of the door, and that all threads run."""
        self._passage.count_statuses(outside=bool(self._outer.take()), inside=bool(self._inner.take()))
        if self._question is not None and (self._question.replies or self._question.done):
            self._passage.asked(answered=bool(self._question.replies))
            self._question = None
        if self._passage.broken:
            raise BusError("nothing passes from the robot through the door any more")
        if self._passage.doubtful and self._question is None:
            self._question = wire.PendingQuery(
                self._inside, keys.status(self.ctx.robot), b"", timeout_s=ASKED_S, source=self.ctx.name
            )
        for name, turns in (("relay", self._relay.turns if self._relay else 0), ("doorman", self._doorman.rounds)):
            if self._still.see(name, turns) > STUCK_ROUNDS:
                raise BusError(f"the {name} stands still")

    def _certified(self) -> str:
        if not any(endpoint.startswith("tls/") for endpoint in self._lan.listen):
            return ""
        return f" with certificate {tokens.fingerprint(certificates.first_der(Path(self._lan.certificate)))}"

    def _report_unproven(self) -> None:
        for user in self._lan.users:
            if user.name not in self._users:
                text = f"the token '{user.name}' is not let in: its row does not fit this home's key; make a new one"
                self.ctx.event("login_refused", text, level="warning")

    def _report_link(self, one: Coming) -> None:
        kind, did = ("login", "came in") if one.connected else ("logout", "went")
        (self._clients.add if one.connected else self._clients.discard)(one.session_id)
        self.ctx.event(kind, f"a client at {one.address} {did} (session {one.session_id[:8]})")


def _proven(lan: LanConfig) -> dict[str, LanUser]:
    """Return the users whose secret fits their row's hash."""
    return {user.name: user for user in lan.users if tokens.fits(user.secret, user.hash)}
