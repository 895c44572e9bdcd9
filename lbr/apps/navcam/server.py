"""navcam: the web server with one face, the cameras, at its own port and with its own token."""

import asyncio
import hashlib
import secrets
import socket
import sys
import time
from collections.abc import Callable, Coroutine, Iterable, Mapping
from contextlib import ExitStack, suppress
from pathlib import Path
from types import FrameType
from typing import Any

from starlette.responses import RedirectResponse, Response
from starlette.types import ASGIApp

from lbr import disk, home
from lbr.apps.http import listening, names, serving
from lbr.apps.http.pages import Pages
from lbr.apps.http.rates import Rates
from lbr.apps.program import Robot
from lbr.apps.web.application import Gate, application
from lbr.apps.web.cameras.hub import Deal
from lbr.apps.web.cameras.routes import OLDEST_S, PREFIX, CamerasFace
from lbr.apps.web.face import Client, Refused, Route, declared
from lbr.apps.web.guards import Counts
from lbr.apps.web.login import Login
from lbr.apps.web.sessions import Sessions
from lbr.bus import certificates, pictures, probe, stamp, wire
from lbr.bus.codec import Decoder
from lbr.bus.session import Session
from lbr.errors import InputError, MalformedError
from lbr.messages.camera import CameraState

ANSWER_S = 0.5
DEPTH = 8
_states = Decoder(CameraState)


def name_in(key: str) -> str:
    """Return a camera's short name from one of its keys."""
    return key.split("/")[-2].removeprefix(PREFIX)


class Door:
    """Queries the cameras; all on the server's thread, and waits for the bus beside it."""

    def __init__(self, bus: Session, robot: str, source: str, sessions: Sessions) -> None:
        self._bus = bus
        self._robot = robot
        self._source = source
        self._sessions = sessions

    async def states(self) -> dict[str, CameraState]:
        """Return the state of each camera by its short name."""
        states = {}
        for raw in await asyncio.to_thread(self._asked, "state"):
            with suppress(MalformedError):
                states[name_in(raw.key)] = _states.decode(raw.payload)
        return dict(sorted(states.items()))

    async def snapshot(self, camera: str) -> bytes | None:
        """Return the newest picture of a camera, or of any; None without a fresh one."""
        snapshots = [
            (stamp.sent_s(stamp.read(raw.attachment), raw.arrived), raw.payload)
            for raw in await asyncio.to_thread(self._asked, "frame")
            if camera in {"", name_in(raw.key)} and pictures.is_whole(raw.payload)
        ]
        at, picture = max(snapshots, default=(0.0, None))
        return picture if time.monotonic() - at <= OLDEST_S else None

    def step(self) -> None:
        """Do nothing: pictures come by themselves."""

    def begin(self, deal: Deal) -> Callable[[], None]:
        """Subscribe to pictures; the bus library's thread only wakes ours."""
        loop = asyncio.get_running_loop()

        def wake() -> None:
            with suppress(RuntimeError):  # the loop is closed
                loop.call_soon_threadsafe(take)

        def take() -> None:
            for raw in feed.take():
                if pictures.is_whole(raw.payload):
                    deal(name_in(raw.key), raw.payload)

        feed = wire.Subscription(self._bus, f"{self._robot}/{PREFIX}$*/frame", depth=DEPTH, wake=wake)
        return feed.close

    def knows(self, mark: str) -> bool:
        """Return whether a client's session or token is still valid."""
        return self._sessions.knows(mark)

    def tell(self, text: str) -> None:
        """Write a dated line to the log; viewers may watch even if the log cannot be written."""
        with suppress(OSError):
            sys.stdout.write(f"{time.strftime('%Y-%m-%d %H:%M:%S')} {text}\n")
            sys.stdout.flush()

    def _asked(self, output: str) -> list[Any]:
        return probe.survey(self._bus, f"{self._robot}/{PREFIX}$*/{output}", source=self._source, timeout_s=ANSWER_S)


TOKEN_FILE = "navcam.token"  # noqa: S105 - a file's name
NAME = "navcam"
NO_TOKEN = (
    "show the token: 'Authorization: Bearer TOKEN', or open the address that navcam printed in a browser; "
    f"it is in credentials/{TOKEN_FILE} of the robot's home"
)


def token() -> str:
    """Return this home's token, made on first use; removing its file locks all users out."""
    (path,) = home.credentials(lambda: [secrets.token_urlsafe(32).encode()], TOKEN_FILE)
    return _read_private(path)


def _read_private(path: Path) -> str:
    text = path.read_text(errors="replace").strip()
    if len(text) < 32 or not text.isascii():
        raise InputError(f"{path} holds no token; remove it, and a new one is made")
    return text


class TokenAccess:
    """Checks the token, in constant time, and the cookies that stand for it."""

    def __init__(self, secret: str, login: Login) -> None:
        self._secret = secret.encode()
        self._login = login

    def client(
        self,
        address: str,
        headers: Mapping[str, str],
        token: str = "",
        *,
        port: int = 0,
        owner: bool = False,
        whose: str | None = None,
    ) -> Client:
        """Return the client; raise Refused (401) without the token or a cookie, from any address."""
        del port, owner
        if not token:
            scheme, _, token = headers.get("authorization", "").partition(" ")
            token = token.strip() if scheme.lower() == "bearer" else ""
        if secrets.compare_digest(token.encode(), self._secret):
            return Client(address, name=NAME, role="view")
        session = self._login.session(headers, whose)
        if not session:
            raise Refused(401, NO_TOKEN, {"WWW-Authenticate": 'Bearer realm="lbr navcam"'})
        return Client(address, role="view", session=session)


SESSIONS = "navcam.sessions"
REQUESTS_PER_S = 200.0


class Server(serving.Server):
    """Ends the open streams at a signal."""

    face: CamerasFace

    def handle_exit(self, sig: int, frame: FrameType | None) -> None:
        """Handle SIGTERM or SIGINT."""
        super().handle_exit(sig, frame)
        self.face.close()


def serve(robot: Robot, host: str, port: int, own_names: Iterable[str]) -> None:
    """Serve the cameras until a signal."""
    with ExitStack() as stack:
        sockets = [stack.enter_context(one) for one in _listen(host, port)]
        tls, port = not listening.is_loopback(sockets[0]), sockets[0].getsockname()[1]
        secret = token()
        sessions = Sessions(home.directory("credentials") / SESSIONS, {NAME: secret})
        face = CamerasFace(Door(robot.bus, robot.name, robot.source, sessions))
        login = Login(sessions, f"lbr_navcam_{port}", tls=tls)
        server = Server(_app(face, login, secret, own_names), tls=tls)
        server.face = face
        page = f"{names.origin(host, port, tls=tls)}/index.html#token={secret}"
        url_file = home.directory("run") / f"{robot.name}-navcam.url"
        disk.write(url_file, f"{page}\n".encode())
        _print(f"navcam is at {page}", f"this address is in {url_file} too")
        if tls:
            _print(f"the certificate's SHA-256 fingerprint is {_fingerprint(Path(listening.certificate()[1]))}")
        try:
            asyncio.run(server.serve(sockets=sockets))
        finally:
            url_file.unlink(missing_ok=True)


def _app(face: CamerasFace, login: Login, secret: str, own_names: Iterable[str]) -> ASGIApp:
    pages = Pages()
    root = Route(method="GET", path="/", handle=_to_index, role=None, page=True)
    return application(
        [root, *face.routes(), *declared(login)],
        gate=Gate(TokenAccess(secret, login), pages),
        pages=pages,
        rates=Rates(REQUESTS_PER_S),
        own_names=frozenset(name.lower() for name in own_names),
        counts=Counts(),
        in_loop=_awaited,
        names_are="by --name in the row of navcam",
    )


async def _awaited(work: Coroutine[object, object, Response], *, timeout_s: float) -> Response:
    """Run a handler on the server's thread, as there is no other loop."""
    return await asyncio.wait_for(work, timeout_s)


def _to_index() -> Response:
    return RedirectResponse("/index.html", 301)


def _listen(host: str, port: int) -> list[socket.socket]:
    try:
        return listening.listen(host, port)
    except InputError as err:
        raise InputError(f"{err}; choose another by --port, or by --host in its row") from err


def _fingerprint(certificate: Path) -> str:
    digest = hashlib.sha256(certificates.first_der(certificate)).hexdigest().upper()
    return ":".join(digest[at : at + 2] for at in range(0, len(digest), 2))


def _print(*lines: str) -> None:
    for line in lines:
        sys.stdout.write(f"{line}\n")
    sys.stdout.flush()
