"""The processors that QEMU can be: by Debian's names of them, and what differs between their machines.

A machine's time passes with the instructions of its processor, a nanosecond for each. Where `gips` is more, its clock is told to go
slower than it does, so that it counts so many instructions in a nanosecond of its own.
"""

import os
from pathlib import Path

from msgspec import Struct

from tests.support import programs

GLIBCS = (17, 28, 31, 34, 35)
"""Versions of the C library, 2.17 for one, whose wheels Debian 12 and 13 take."""
HARDWARE = "-smp 1 -m 2048"
KEPT, TREE = "processor", "tree.dtb"
TICKS_HZ = 62_500_000
"""How often the clock of QEMU's ARM machine ticks (`-machine virt`)."""


class Processor(Struct, frozen=True):
    """One kind of machine: QEMU's words for it, what Debian calls its kernel, its console, and what wheels call it."""

    qemu: str
    kind: str
    kernel: str
    console: str
    wheels: str
    two_lines: bool
    """It has a second serial line, on which it tells its time."""
    gips: int = 1

    @property
    def programs(self) -> tuple[str, ...]:
        """What has to be installed for it."""
        return (self.qemu, "fdtput") if self.gips > 1 else (self.qemu,)

    @property
    def platforms(self) -> tuple[str, ...]:
        """What wheels for it are tagged with."""
        return (f"manylinux2014_{self.wheels}", *(f"manylinux_2_{glibc}_{self.wheels}" for glibc in GLIBCS))

    def command(self, folder: Path) -> str:
        """Return how QEMU begins as the machine of a folder."""
        tree = f" -dtb {folder / TREE}" if self.gips > 1 else ""
        return f"{self.qemu} {self.kind} {HARDWARE}{tree}"

    def prepare(self, folder: Path) -> None:
        """Write down for the kernel how fast its clock is to be taken for."""
        if self.gips > 1:
            tree = str(folder / TREE)
            dump = f"{self.qemu} {self.kind} {HARDWARE} -machine dumpdtb={tree}"
            programs.run(dump.split(), check=True)
            fast = str(self.gips * TICKS_HZ)
            programs.run(["fdtput", "-t", "i", tree, "/timer", "clock-frequency", fast], check=True)


PROCESSORS = {
    "amd64": Processor("qemu-system-x86_64", "-cpu max", "linux-image-amd64", "ttyS0", "x86_64", two_lines=True),
    "arm64": Processor(
        "qemu-system-aarch64",
        "-machine virt -cpu cortex-a76",
        "linux-image-arm64",
        "ttyAMA0",
        "aarch64",
        two_lines=False,
        gips=4,
    ),
}
"""The second has a core as a Raspberry Pi 5 has four of."""
HERE = next((name for name, one in PROCESSORS.items() if one.wheels == os.uname().machine), "amd64")


def keep(folder: Path, name: str) -> None:
    """Have the machine of a folder be of that processor."""
    (folder / KEPT).write_text(name)
    PROCESSORS[name].prepare(folder)


def of(folder: Path) -> Processor:
    """Return the processor of a folder's machine."""
    return PROCESSORS[(folder / KEPT).read_text()]
