"""Serve the robot's cameras to browsers, behind a token.

Without --host, which belongs into its row, only this machine reaches it. From other machines it is reached by TLS alone,
with the robot's own certificate, whose SHA-256 fingerprint is printed for comparison with what the browser shows.
"""

import argparse
import asyncio
import hashlib
import os
import socket
import ssl
import sys
from contextlib import ExitStack, suppress
from pathlib import Path

from lbr import home
from lbr.apps import program
from lbr.capability.confine import confine
from lbr.errors import InputError

PORT = 9146


def main() -> int:
    """Serve until told to end."""
    try:
        from lbr.apps.http.listening import certificate, is_loopback  # noqa: PLC0415
        from lbr.apps.navcam import guard, server, sessions, web  # noqa: PLC0415 - they need an extra
        from lbr.apps.navcam.cameras import Cameras  # noqa: PLC0415
        from lbr.apps.navcam.hub import Hub  # noqa: PLC0415
    except ImportError as err:
        raise InputError(f"navcam needs the extra 'web' ({err.name} is missing): pip install 'lbr[web]'") from err

    arguments = _parser().parse_args()
    confine((str(home.home()),))
    with program.connected("navcam") as robot, ExitStack() as stack:
        listening = [stack.enter_context(one) for one in server.listen(arguments.host, arguments.port)]
        tls, port = not is_loopback(listening[0]), listening[0].getsockname()[1]
        secret = guard.token()
        hub = Hub(robot.bus, robot.name)
        kept = sessions.Sessions(home.directory("credentials") / sessions.FILE, secret)
        lock = guard.Lock(secret, kept, port=port, tls=tls)
        serving = server.server(
            web.NavCam(hub, Cameras(robot.bus, robot.name, robot.source), lock).app(arguments.name), hub, tls=tls
        )
        page = f"{_origin(arguments.host, port, tls=tls)}/index.html#token={secret}"
        told = home.directory("run") / f"{robot.name}-navcam.url"
        home.write_private(told, f"{page}\n".encode())
        _say(f"navcam is at {page}", f"this address is in {told} too")
        if tls:
            _say(f"the certificate's SHA-256 fingerprint is {_fingerprint(Path(certificate()[1]))}")
        try:
            asyncio.run(_serve(serving, listening))
        finally:
            told.unlink(missing_ok=True)
    return 0


async def _serve(serving: "object", listening: list[socket.socket]) -> None:
    from lbr.apps.navcam.server import Server  # noqa: PLC0415

    assert isinstance(serving, Server)
    serving.loop = asyncio.get_running_loop()
    await serving.serve(sockets=listening)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m lbr.apps.navcam", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--host", default="127.0.0.1", help="address to listen at, 0.0.0.0 for all (default %(default)s)"
    )
    parser.add_argument(
        "--port", type=int, default=PORT, help="port to listen at (default %(default)s; 0: any free one)"
    )
    parser.add_argument(
        "--name",
        action="append",
        default=[],
        help="another name of this machine, such as robot.example.org; repeatable",
    )
    return parser


def _origin(host: str, port: int, *, tls: bool) -> str:
    """Return by what a browser gets here: the machine's name stands for all of its addresses."""
    name = socket.gethostname() if host in {"0.0.0.0", "::"} else host  # noqa: S104 - compared, not bound
    return f"{'https' if tls else 'http'}://{f'[{name}]' if ':' in name else name}:{port}"


def _fingerprint(certificate: Path) -> str:
    digest = hashlib.sha256(ssl.PEM_cert_to_DER_cert(certificate.read_text())).hexdigest().upper()
    return ":".join(digest[at : at + 2] for at in range(0, len(digest), 2))


def _say(*lines: str) -> None:
    for line in lines:
        sys.stdout.write(f"{line}\n")
    sys.stdout.flush()


if __name__ == "__main__":
    code = program.run(main)
    with suppress(OSError):
        sys.stdout.flush()
    os._exit(code)  # a thread that still waits for an answer of the bus holds up nobody
