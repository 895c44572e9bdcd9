"""What lbr-client costs a program: the processor time of its import, and the room that it takes with what it needs.

`python -m benchmarks client --n 20`. The wheel is built and unpacked as pip would; what it needs is counted as it is
installed here. Beside it stands the import of an interpreter with its bus library alone.
"""

import argparse
import os
import resource
import sys
import tempfile
import zipfile
from importlib.metadata import files
from pathlib import Path

from benchmarks import FOLDER, Measured
from tests.support import programs
from tests.support.figures import Promise, Results

SMOKE = "--n 2"
BUILD = "from hatchling.build import build_wheel; import sys; print(build_wheel(sys.argv[1]))"
NEEDS = ("eclipse-zenoh", "msgspec")
PROMISES = {
    "import": Promise(
        what="import of lbr_client, processor time beyond an interpreter's", target=100.0, statistic="p50"
    ),
    "bus": Promise(what="import of zenoh and msgspec alone, the same"),
    "install": Promise(what="lbr-client installed, with what it needs", unit="MB", target=30.0),
}


def options(parser: argparse.ArgumentParser) -> None:
    """Add how often."""
    parser.add_argument("--n", type=int, default=20, help="imports of each (default %(default)s)")


def measure(given: argparse.Namespace) -> Measured:
    """Import it again and again, in turns with the libraries alone."""
    results = Results(PROMISES)
    with tempfile.TemporaryDirectory() as place:
        site = _unpacked(Path(place))
        own = sum(path.stat().st_size for path in site.rglob("*") if path.is_file())
        needed = sum(
            Path(one.locate()).stat().st_size for name in NEEDS for one in files(name) or () if one.suffix != ".pyc"
        )
        results.sample("install", (own + needed) / 1e6)
        _spent_ms("import lbr_client", site)  # compiles
        for _ in range(given.n):
            empty = _spent_ms("pass", site)
            results.sample("import", _spent_ms("import lbr_client", site) - empty)
            results.sample("bus", _spent_ms("import zenoh, msgspec", site) - empty)
    return Measured(results=results.ordered())


def _unpacked(place: Path) -> Path:
    command = [sys.executable, "-c", BUILD, str(place)]
    built = programs.run(command, cwd=FOLDER.parent / "client", capture_output=True, text=True)
    with zipfile.ZipFile(place / built.stdout.split()[-1]) as packed:
        packed.extractall(place / "site")
    return place / "site"


def _spent_ms(code: str, site: Path) -> float:
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    programs.run([sys.executable, "-c", code], env=environment | {"PYTHONPATH": str(site)}, check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return (after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime) * 1000.0
