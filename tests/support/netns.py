"""Two machines on one: network namespaces joined by a cable that can be pulled. Needs root."""

import ctypes
import fcntl
import os
import shutil
import socket
import struct
import subprocess
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from itertools import count
from pathlib import Path

from tests.support import programs, sweep

CLONE_NEWNET = 0x40000000
SIOCGIFFLAGS, SIOCSIFFLAGS, IFF_UP = 0x8913, 0x8914, 1
OTHER_BOOT = "0badb007"
_numbers = count()


class Network:
    """A namespace for the robot, at `address`, and one for whoever connects; `robot` and `client` run programs there."""

    def __init__(self, mark: str, net: str) -> None:
        self.address, self.client_address = f"{net}.1", f"{net}.2"
        self._robot, self._client = f"lbr{mark}r", f"lbr{mark}c"
        self.cable, self._other = f"lbr{mark}a", f"lbr{mark}b"
        self.robot = ("ip", "netns", "exec", self._robot)
        self.client = ("ip", "netns", "exec", self._client)
        self._hand: socket.socket | None = None
        """It was made in the robot's namespace, and stays there: the cable is pulled at once, by no program."""

    def open(self) -> None:
        """Make it."""
        self.close()
        sweep.note_namespace(self._robot)
        sweep.note_namespace(self._client)
        for arguments in (
            ("netns", "add", self._robot),
            ("netns", "add", self._client),
            ("-n", self._robot, "link", "add", self.cable, "type", "veth", "peer", "name", self._other),
            ("-n", self._robot, "link", "set", self._other, "netns", self._client),
            ("-n", self._robot, "addr", "add", f"{self.address}/30", "dev", self.cable),
            ("-n", self._client, "addr", "add", f"{self.client_address}/30", "dev", self._other),
            *(("-n", space, "link", "set", "lo", "up") for space in (self._robot, self._client)),
            ("-n", self._client, "link", "set", self._other, "up"),
        ):
            done = _ip(*arguments)
            assert done.returncode == 0, f"ip {' '.join(arguments)}: {done.stderr}"
        with ThreadPoolExecutor(1) as thread:  # which enters the namespace alone
            self._hand = thread.submit(_socket_in, self._robot).result()
        self.heal()

    def cut(self) -> None:
        """Pull the cable."""
        self._plug(plugged=False)

    def heal(self) -> None:
        """Plug it in."""
        self._plug(plugged=True)

    def close(self) -> None:
        """Take it away, as far as it is there."""
        if self._hand is not None:
            self._hand.close()
        for space in (self._robot, self._client):
            _ip("netns", "delete", space)

    def _plug(self, *, plugged: bool) -> None:
        assert self._hand is not None
        asked = struct.pack("16sh14x", self.cable.encode(), 0)
        (flags,) = struct.unpack("16xh14x", fcntl.ioctl(self._hand, SIOCGIFFLAGS, asked))
        flags = flags | IFF_UP if plugged else flags & ~IFF_UP
        fcntl.ioctl(self._hand, SIOCSIFFLAGS, struct.pack("16sh14x", self.cable.encode(), flags))


def _socket_in(space: str) -> socket.socket:
    """Return a socket of a namespace, which this thread enters for it."""
    with Path("/run/netns", space).open() as entered:
        assert ctypes.CDLL(None, use_errno=True).setns(entered.fileno(), CLONE_NEWNET) == 0, ctypes.get_errno()
    return socket.socket(socket.AF_INET, socket.SOCK_DGRAM)


def why_not() -> str:
    """Return why there can be no second machine here, or nothing."""
    if os.geteuid() != 0 or shutil.which("ip") is None:
        return "needs root and the program ip"
    name = f"lbrt{os.getpid()}"
    sweep.note_namespace(name)
    made = _ip("netns", "add", name)
    _ip("netns", "delete", name)
    return f"no network namespaces here: {made.stderr.strip()}" if made.returncode else ""


@contextmanager
def network() -> Iterator[Network]:
    """Have two machines for the time of a `with`; those of other tests are not in the way."""
    number = next(_numbers)
    pid = os.getpid()
    net = Network(f"{pid % 100_000:x}{number % 16:x}", f"10.{190 + pid // 250 % 60}.{(pid + number) % 250}")
    try:
        net.open()
        yield net
    finally:
        net.close()


def another_clock(place: Path, ahead_s: int = 5000) -> tuple[str, ...]:
    """Return what runs a program as on a machine that started at another time; nothing, where the kernel cannot."""
    boot = place / "boot_id"
    boot.write_text(f"{OTHER_BOOT}-0000-4000-8000-000000000000")
    mount = f'mount --bind {boot} /proc/sys/kernel/random/boot_id && exec "$@"'
    prefix = ("unshare", "--time", "--monotonic", str(ahead_s), "--mount", "sh", "-c", mount, "sh")
    tried = programs.run([*prefix, "cat", "/proc/sys/kernel/random/boot_id"], capture_output=True, check=False)
    return prefix if tried.stdout == boot.read_bytes() else ()


def _ip(*arguments: str) -> "subprocess.CompletedProcess[str]":
    return programs.run(["ip", *arguments], capture_output=True, text=True, check=False)
