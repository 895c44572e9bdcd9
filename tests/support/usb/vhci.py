"""Plugs the end of a socket into this machine's kernel as a USB device, by its virtual host controller `vhci-hcd`."""

import os
import socket
from pathlib import Path

from tests.support import programs

CONTROLLER = Path("/sys/devices/platform/vhci_hcd.0")
FULL_SPEED, HIGH_SPEED = 2, 3
_FREE = "004"


def why_not() -> str:
    """Return why no device can be played to this kernel; nothing if it can. Loads the module."""
    return why_no_module("vhci-hcd", there=CONTROLLER)


def why_no_module(name: str, *options: str, there: Path | None = None) -> str:
    """Return why this machine's kernel lacks a module; nothing if it has it, loaded by now."""
    if os.geteuid() != 0:
        return f"only root may load {name} and play devices to the kernel"
    if there is not None and there.exists():
        return ""
    try:
        done = programs.run(["modprobe", name, *options], capture_output=True, text=True, timeout=60, check=False)
    except FileNotFoundError:
        return f"no modprobe here, and so no {name}"
    if done.returncode:
        return f"this kernel has no {name}: {done.stderr.strip()}"
    return ""


def attach(speed: int) -> tuple[int, socket.socket]:
    """Plug a new device in; return its port, and the socket at which it is to be played."""
    kernels, ours = socket.socketpair(socket.AF_UNIX, socket.SOCK_STREAM)
    with kernels:
        for port in _free_ports():
            try:
                (CONTROLLER / "attach").write_text(f"{port} {kernels.fileno()} {0x10000 | port + 2} {speed}")
            except OSError:
                continue  # another has taken it since
            return port, ours
    ours.close()
    raise RuntimeError("no port of the virtual host controller is free")


def is_free(port: int) -> bool:
    """Say whether the kernel is through with what was at a port."""
    return port in _free_ports()


def _free_ports() -> list[int]:
    lines = (line.split() for line in (CONTROLLER / "status").read_text().splitlines()[1:])
    return [int(line[1]) for line in lines if line[0] == "hs" and line[2] == _FREE]
