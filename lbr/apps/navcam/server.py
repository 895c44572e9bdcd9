"""Where navcam listens, and how it ends: at once, whoever watches."""

import asyncio
import socket
import ssl
from types import FrameType

import uvicorn
from starlette.types import ASGIApp

from lbr.apps.http import listening
from lbr.apps.http.listening import MOST_CONNECTIONS, Connection
from lbr.apps.navcam.hub import Hub
from lbr.errors import InputError

GRACE_S = 1


class Server(uvicorn.Server):
    """Ends the open streams when it is told to end."""

    hub: Hub
    loop: asyncio.AbstractEventLoop

    def handle_exit(self, sig: int, frame: FrameType | None) -> None:
        """Take SIGTERM or SIGINT."""
        super().handle_exit(sig, frame)
        self.loop.call_soon_threadsafe(self.hub.close)


def listen(host: str, port: int) -> socket.socket:
    """Return a listening socket whose connections hold little; InputError says what is wrong with the address."""
    try:
        return listening.listen(host, port)
    except InputError as err:
        raise InputError(f"{err}; choose another by --host or --port") from err


def server(app: ASGIApp, hub: Hub, *, tls: bool) -> Server:
    """Return a server for an app; with `tls` it speaks nothing else."""
    key, public = listening.certificate() if tls else (None, None)
    config = uvicorn.Config(
        app,
        http=Connection,
        ws="none",
        lifespan="off",
        loop="asyncio",
        interface="asgi3",
        access_log=False,
        log_config=None,
        server_header=False,
        proxy_headers=False,
        limit_concurrency=MOST_CONNECTIONS,
        timeout_graceful_shutdown=GRACE_S,
        ssl_keyfile=key,
        ssl_certfile=public,
    )
    config.load()
    if tls and not isinstance(config.ssl, ssl.SSLContext):
        raise InputError("TLS could not be set up, and without it navcam serves this machine only")
    made = Server(config)
    made.hub = hub
    return made
