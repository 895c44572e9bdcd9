"""The recipe for a Raspberry Pi's first start (docs/examples/raspberry-pi), which cloud-init follows in a machine that has nothing of lbr.

There is no network: Debian's packages are in the machine already, wheels lie beside them, and the project comes as a repository in one
file on the volume that has the recipe. Else only what the recipe marks with CHANGE is changed.
"""

import json
import re
import tempfile
from collections.abc import Generator
from pathlib import Path
from typing import Any

from tests.lab import image, stage
from tests.lab.machine import SEED_LABEL, Machine
from tests.lab.stage import AS_SERVICE, Scene, SceneError, Stage, until
from tests.support import programs

ROOT = Path(__file__).resolve().parents[2]
RECIPE = ROOT / "docs" / "examples" / "raspberry-pi" / "user-data"
UNIT = "lbr@lbr-sim.service"
VOLUME, BUNDLE = "/mnt", "lbr.bundle"
MOUNTED = f"mount -o ro /dev/disk/by-label/{SEED_LABEL} {VOLUME}"
RESULT = "/run/cloud-init/result.json"
SCREEN = "iconv -f UCS-4LE -t UTF-8 /dev/vcsu1"
INSTALLED_S = 7200.0
CORNER = "█ ▄▄▄▄▄ █"
"""What a QR code of half blocks has at three corners."""
KEPT = "first_start.json"


def play(folder: Path, suite: str, arch: str) -> Generator[Scene]:
    """Build a machine, start it for the first time with the recipe, and once more."""
    image.build_for_first_start(folder, suite, arch)
    with tempfile.TemporaryDirectory() as place:
        seed = Path(place)
        (seed / "meta-data").write_text("instance-id: first\n")
        (seed / "user-data").write_text(_recipe((folder / "key.pub").read_text().strip()))
        _write_bundle(seed / BUNDLE)
        first = FirstStart(Machine(folder, seed=seed), lambda _: None, UNIT)
        try:
            yield stage.tell("the recipe, at the first start of a machine", first.follow)
            yield stage.tell("a code for a phone is on the screen, and the robot turns", first.shows)
            yield stage.tell("started again", first.starts_again)
        finally:
            first.machine.cut()


class FirstStart(Stage):
    """A machine on which nothing of lbr is installed yet."""

    def follow(self) -> str:
        """Start it, and wait until cloud-init has done all that the recipe says."""
        self.machine.start(snapshot=False)
        result = until(self._result, "cloud-init has ended", INSTALLED_S)
        if result["errors"]:
            said = self.machine.run("tail -n 30 /var/log/cloud-init-output.log").stdout.decode()
            raise SceneError(f"{result['errors']}: {said}")
        self.ready()
        up_s = int(self.property("ActiveEnterTimestampMonotonic")) / 1e6
        ready = [name for name, one in self.capabilities().items() if one["phase"] == "ready"]
        return f"{len(ready)} capabilities ready {up_s:.0f} s after the kernel"

    def shows(self) -> str:
        """Look at the screen, and have the robot turn."""
        screen = until(self._screen, "a QR code on the screen")
        code = re.search(r"(\d{3} \d{3})\s+at (https://\S+)", screen)
        if code is None:
            raise SceneError(f"no code beside it: {screen}")
        self.machine.run(f"{AS_SERVICE} send /r/0.3/90")
        return f"a QR code, and under it six digits at {code[2]}"

    def starts_again(self) -> str:
        """Restart the machine, and look again."""
        self.off("systemctl reboot")
        self.machine.start(snapshot=False)
        self.ready()
        until(self._screen, "a QR code on the screen")
        return "ready, and a QR code"

    def _result(self) -> dict[str, Any]:
        """Return what came of it, once cloud-init has ended."""
        said = self.machine.run(f"cat {RESULT}", check=False).stdout
        return json.loads(said)["v1"] if said else {}

    def _screen(self) -> str:
        """Return what is on the screen, once there is a QR code."""
        said = self.machine.run(SCREEN).stdout.decode()
        return said if CORNER in said else ""


def _recipe(key: str) -> str:
    """Return the recipe with what an owner changes in it."""
    text = re.sub(r"ssh-ed25519 .*(?=  # CHANGE)", key, RECIPE.read_text())
    return re.sub(r"git clone \S+", f"{MOUNTED} && git clone {VOLUME}/{BUNDLE}", text)


def _write_bundle(path: Path) -> None:
    """Write a repository of the source as it is here."""
    with tempfile.TemporaryDirectory() as place:
        programs.run(["git", "checkout-index", "-a", f"--prefix={place}/"], cwd=ROOT, check=True)
        git = ["git", "-C", place, "-c", "user.name=lab", "-c", "user.email=lab@localhost"]
        for words in ("init -q -b main", "add -A", "commit -q -m source", f"bundle create -q {path} HEAD main"):
            programs.run([*git, *words.split()], check=True)
