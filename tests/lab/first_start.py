"""The recipe for a Raspberry Pi's first start (docs/examples/raspberry-pi), which cloud-init follows in the machine.

There is no network: Debian's packages and the wheels are in the machine already, and so is a repository of the project. Else only
what the recipe marks with CHANGE is changed.
"""

import re
import tempfile
from collections.abc import Generator
from pathlib import Path

from tests.lab import stage
from tests.lab.image import WHEELS
from tests.lab.machine import Machine
from tests.lab.stage import AS_SERVICE, Scene, SceneError, Stage, until
from tests.support import programs

ROOT = Path(__file__).resolve().parents[2]
RECIPE = ROOT / "docs" / "examples" / "raspberry-pi" / "user-data"
UNIT = "lbr@lbr-sim.service"
BUNDLE = "/opt/lbr.bundle"
SEED = "/var/lib/cloud/seed/nocloud"
PIP = f"[global]\nno-index = true\nfind-links = {WHEELS}\n"
EMPTIED = f"""/opt/lbr/bin/lbr service remove; rm -rf /opt/lbr /var/lib/lbr; userdel lbr
    rm /etc/cloud/cloud-init.disabled && mkdir -p {SEED} && echo 'instance-id: first' >{SEED}/meta-data"""
SCREEN = "iconv -f UCS-4LE -t UTF-8 /dev/vcsu1"
CORNER = "█ ▄▄▄▄▄ █"
"""What a QR code of half blocks has at three corners."""
KEPT = "first_start.json"


def play(machine: Machine) -> Generator[Scene]:
    """Start a machine for the first time, with the recipe."""
    first = FirstStart(machine, lambda _: None, UNIT)
    yield stage.tell("the recipe, at the first start of a machine", first.follow)
    yield stage.tell("what a phone needs is on the screen", first.shows)


class FirstStart(Stage):
    """A machine on which nothing of lbr is installed yet."""

    def follow(self) -> str:
        """Start it, and wait until cloud-init has done all that the recipe says."""
        machine = self.machine
        machine.run(EMPTIED)
        machine.run(f"cat >{BUNDLE}", data=_bundle())
        machine.run("cat >/etc/pip.conf", data=PIP.encode())
        machine.run(f"cat >{SEED}/user-data", data=self._recipe().encode())
        self.off("systemctl reboot")
        machine.start(snapshot=False)
        said = until(self._told, "cloud-init done")
        if "done" not in said:
            raise SceneError(machine.run("tail -n 30 /var/log/cloud-init-output.log").stdout.decode())
        self.ready()
        up_s = int(self.property("ActiveEnterTimestampMonotonic")) / 1e6
        ready = [name for name, one in self.capabilities().items() if one["phase"] == "ready"]
        return (
            f"cloud-init {said}; installed, and the robot up {up_s:.0f} s after the kernel; ready: {', '.join(ready)}"
        )

    def shows(self) -> str:
        """Look at the screen."""
        screen = until(self._screen, "a QR code")
        address = re.search(r"https?://\S+", screen)
        self.machine.run(f"{AS_SERVICE} send /r/0.3/90")
        return f"a QR code, {address[0] if address else 'no address beside it'}; it turns when told to"

    def _told(self) -> str:
        said = self.machine.run("cloud-init status", check=False).stdout.decode()
        return "" if "running" in said or "not run" in said else said.removeprefix("status: ").strip()

    def _screen(self) -> str:
        """Return what is on the screen, once there is a QR code."""
        said = self.machine.run(SCREEN).stdout.decode()
        return said if CORNER in said else ""

    def _recipe(self) -> str:
        """Return the recipe with what an owner changes in it."""
        key = (self.machine.folder / "key.pub").read_text().strip()
        text = re.sub(r"ssh-ed25519 .*(?=  # CHANGE)", key, RECIPE.read_text())
        return re.sub(r"git clone \S+", f"git clone {BUNDLE}", text)


def _bundle() -> bytes:
    """Return a repository of the source as it is here, in one file."""
    with tempfile.TemporaryDirectory() as place:
        bundle, own = (
            f"{place}/lbr.bundle",
            ["git", "-C", place, "-c", "user.name=lab", "-c", "user.email=lab@localhost"],
        )
        programs.run(["git", "checkout-index", "-a", f"--prefix={place}/"], cwd=ROOT, check=True)
        for words in ("init -q -b main", "add -A", "commit -q -m source", f"bundle create -q {bundle} HEAD main"):
            programs.run([*own, *words.split()], check=True)
        return Path(bundle).read_bytes()
