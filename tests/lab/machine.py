"""The machine itself: QEMU without acceleration, its monitor, and commands in it by ssh."""

import hashlib
import shlex
import socket
import subprocess
import time
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from tests.lab import processor
from tests.support import programs
from tests.support.robot import free_port

SNAPSHOT = "started"
START_S = 1800.0
"""On a machine that has much else to do; alone it takes half a minute."""
ANSWER_S = 900.0
INSTRUCTIONS = "shift=0"
"""One instruction a nanosecond of QEMU's clock, which waits for nothing of the host's, so that deadlines mean the same
however busy the host is."""


CABLE = "cable"
SEED_LABEL = "CIDATA"
SLOWER_CLOCK = "*/faketime/libfaketimeMT.so.1"
PACE = 0.2
"""How fast the host's clock is for machines with a cable. One that has nothing to do at the moment goes on by that clock, so
what the host withholds from it is time that it loses: half a second of that is 0.1 s, which a driver bears."""


class Machine:
    """A machine whose files are in a folder: `disk.qcow2`, `vmlinuz`, `initrd.img`, the key for its root, and what
    processor it has.

    `cable` is where a second network card leads, in QEMU's words for a socket. One with a cable tells its time, and can be made to
    wait, by the two sockets of `clock`. `seed` is a folder that it finds as a volume of the label by which cloud-init knows its own.
    """

    def __init__(self, folder: Path, *, cable: str = "", seed: Path | None = None) -> None:
        self.folder = folder
        self._seed = seed
        self.clock = (folder / "clock", folder / "control")
        self._cable = cable
        self._port = free_port()
        self._monitor = folder / "monitor"
        self._qemu: subprocess.Popen[bytes] | None = None

    def start(self, *, snapshot: bool, named: str = SNAPSHOT) -> float:
        """Switch it on, or go back to the snapshot of a name; return after how long it answers."""
        began = time.monotonic()
        (self.folder / "ssh").unlink(missing_ok=True)
        self._qemu = programs.start(self._command(named if snapshot else ""), stdin=subprocess.DEVNULL)
        while self.run("true", check=False).returncode:
            if self._qemu.poll() is not None:
                raise RuntimeError("QEMU has ended; its words are above")
            if time.monotonic() > began + START_S:
                raise RuntimeError(f"the machine does not answer: see {self.folder / 'serial.log'}")
            time.sleep(1.0)
        self.run(f"date -s @{int(time.time())} >/dev/null")
        return time.monotonic() - began

    def run(
        self,
        command: str,
        *,
        check: bool = True,
        data: bytes | None = None,
        limit_s: float = ANSWER_S,
        show: bool = False,
    ) -> "subprocess.CompletedProcess[bytes]":
        """Run a command of the shell as root; its output is returned, or shown as it comes."""
        return programs.run([*self.ssh(), command], input=data, capture_output=not show, timeout=limit_s, check=check)

    def ssh(self) -> list[str]:
        """Return the command that leads into it; one connection is kept for all."""
        words = f"""-q -i {shlex.quote(str(self.folder / "key"))} -p {self._port} -o StrictHostKeyChecking=no
            -o UserKnownHostsFile=/dev/null -o ConnectTimeout=60 -o ControlMaster=auto -o ControlPersist=600
            -o ControlPath={shlex.quote(str(self.folder / "ssh"))} root@127.0.0.1"""
        return ["ssh", *shlex.split(words)]

    def monitor(self, line: str) -> str:
        """Say a line to QEMU's monitor; return what it says."""
        with socket.socket(socket.AF_UNIX) as link:
            link.settimeout(ANSWER_S)
            link.connect(str(self._monitor))
            _until_prompt(link)
            link.sendall(line.encode() + b"\n")
            return _until_prompt(link)

    def ended(self, within_s: float) -> bool:
        """Wait for it to be off; say whether it is."""
        assert self._qemu is not None
        with suppress(subprocess.TimeoutExpired):
            self._qemu.wait(within_s)
        return self._qemu.poll() is not None

    def cut(self) -> None:
        """Take its power away: QEMU is killed, and what the guest had not handed to its disk is lost."""
        if self._qemu is not None:
            self._qemu.kill()
            self._qemu.wait()

    def plug(self, *, there: bool) -> None:
        """Pull the cable to the other machine out of this one, or put it in."""
        self.monitor(f"set_link {CABLE} {'on' if there else 'off'}")

    def _command(self, snapshot: str) -> Sequence[str]:
        f, kind = self.folder, processor.of(self.folder)
        told, control = self.clock
        slower = f"env LD_PRELOAD={_slower_clock()} FAKETIME='+0 x{PACE:g}'" if self._cable else ""
        words = f"""nice -n 19 {slower} {kind.command(f)} -accel tcg,tb-size=512 -icount {INSTRUCTIONS} -rtc clock=vm
            -display none -no-reboot -kernel {f}/vmlinuz -initrd {f}/initrd.img
            -drive file={f}/disk.qcow2,if=virtio,cache=writeback -device virtio-rng-pci
            -nic user,model=virtio-net-pci,restrict=on,hostfwd=tcp:127.0.0.1:{self._port}-:22
            -serial file:{f}/serial.log -monitor unix:{self._monitor},server=on,wait=off"""
        kernel = f"root=/dev/vda rw console={kind.console} net.ifnames=0 mitigations=off quiet fsck.mode=auto"
        with_cable = (
            f"""-netdev socket,id={CABLE},{self._cable} -device virtio-net-pci,netdev={CABLE},mac={_mac(f)}
            -serial unix:{told},server=on,wait=off -qmp unix:{control},server=on,wait=off"""
            if self._cable
            else ""
        )
        volume = f"format=raw,readonly=on,file.driver=vvfat,file.dir={self._seed},file.label={SEED_LABEL}"
        with_seed = f"-drive if=virtio,{volume}" if self._seed else ""
        return [
            *shlex.split(f"{words} {with_cable} {with_seed}"),
            "-append",
            kernel,
            *(("-loadvm", snapshot) if snapshot else ()),
        ]


def _slower_clock() -> str:
    """Return the library that slows a program's clock."""
    found = next(Path("/usr/lib").glob(SLOWER_CLOCK), None)
    if found is None:
        raise RuntimeError("the package faketime is missing here")
    return str(found)


def _mac(folder: Path) -> str:
    """Return an address for the card of a machine, of those that anybody may give."""
    return "52:54:00:" + hashlib.sha256(folder.name.encode()).digest()[:3].hex(":")


def _until_prompt(link: socket.socket) -> str:
    heard = b""
    while not heard.endswith(b"(qemu) "):
        data = link.recv(4096)
        if not data:
            break
        heard += data
    return heard.decode(errors="replace")
