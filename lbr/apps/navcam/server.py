"""navcam: the web server with one face, the cameras, at its own port and with its own token."""

import asyncio
import hashlib
import socket
import sys
from collections.abc import Coroutine, Iterable
from contextlib import ExitStack
from pathlib import Path
from types import FrameType

from starlette.responses import RedirectResponse, Response
from starlette.types import ASGIApp

from lbr import home
from lbr.apps.http import listening, names, serving
from lbr.apps.http.pages import Pages
from lbr.apps.http.rates import Rates
from lbr.apps.navcam.access import NAME, TokenAccess, token
from lbr.apps.navcam.source import Door
from lbr.apps.program import Robot
from lbr.apps.web.application import Gate, application
from lbr.apps.web.cameras.routes import CamerasFace
from lbr.apps.web.face import Route, declared
from lbr.apps.web.guards import Counts
from lbr.apps.web.login import Login
from lbr.apps.web.sessions import Sessions
from lbr.bus import certificates
from lbr.errors import InputError

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
        home.write_private(url_file, f"{page}\n".encode())
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
