"""How navcam serves, and how it ends: at once, whoever watches."""

import asyncio
import socket
from types import FrameType

from starlette.types import ASGIApp

from lbr.apps.http import listening, serving
from lbr.apps.navcam.hub import Hub
from lbr.errors import InputError


class Server(serving.Server):
    """Ends the open streams when it is told to end."""

    hub: Hub
    loop: asyncio.AbstractEventLoop

    def handle_exit(self, sig: int, frame: FrameType | None) -> None:
        """Take SIGTERM or SIGINT."""
        super().handle_exit(sig, frame)
        self.loop.call_soon_threadsafe(self.hub.close)


def listen(host: str, port: int) -> list[socket.socket]:
    """Return listening sockets whose connections hold little; InputError says what is wrong with the address."""
    try:
        return listening.listen(host, port)
    except InputError as err:
        raise InputError(f"{err}; choose another by --port, or by --host in its row") from err


def server(app: ASGIApp, hub: Hub, *, tls: bool) -> Server:
    """Return a server for an app; with `tls` it speaks nothing else."""
    made = Server(serving.config(app, tls=tls))
    made.hub = hub
    return made
