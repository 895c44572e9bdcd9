"""Serve the robot's cameras to browsers, behind a token.

Without --host in its row, only this machine reaches it. Other machines reach it by TLS alone, with the robot's own
certificate. Its SHA-256 fingerprint is printed, to be compared with the one that the browser shows.
"""

import argparse
import os
import sys
from contextlib import suppress

from lbr import home
from lbr.apps import program
from lbr.capability.confine import confine
from lbr.errors import InputError

PORT = 9146


def main() -> int:
    """Serve until a signal."""
    try:
        from lbr.apps.navcam.server import serve  # noqa: PLC0415 - it needs an extra
    except ImportError as err:
        raise InputError(f"navcam needs the extra 'web' ({err.name} is missing): pip install 'lbr[web]'") from err
    arguments = _parser().parse_args()
    confine((str(home.home()),))
    with program.connected("navcam") as robot:
        serve(robot, arguments.host, arguments.port, arguments.name)
    return 0


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


if __name__ == "__main__":
    code = program.run(main)
    with suppress(OSError):
        sys.stdout.flush()
    os._exit(code)  # without waiting for a thread that queries the bus
