"""The cost of lbr-client for a program: the processor time of its import, and its size with its dependencies.

`python -m benchmarks client --n 20`. The wheel is built, and unpacked like by pip in an environment without lbr;
dependencies count as they are installed here. For comparison, an interpreter imports only the bus library.
"""

import argparse
import os
import resource
import tempfile
from importlib.metadata import files
from pathlib import Path

from benchmarks import Measured
from tests.support import lbr_client, programs
from tests.support.figures import Promise, Results

SMOKE = "--n 2"
PROMISES = {
    "import": Promise(
        what="import of lbr_client, processor time beyond an interpreter's", target=100.0, statistic="p50"
    ),
    "bus": Promise(what="import of zenoh and msgspec alone, the same"),
    "install": Promise(what="lbr-client installed, with what it needs", unit="MB", target=30.0),
}


def options(parser: argparse.ArgumentParser) -> None:
    """Add the number."""
    parser.add_argument("--n", type=int, default=20, help="imports of each (default %(default)s)")


def measure(given: argparse.Namespace) -> Measured:
    """Import it repeatedly, in turns with the libraries alone."""
    results = Results(PROMISES)
    with tempfile.TemporaryDirectory() as place:
        wheel = lbr_client.build("wheel", Path(place))
        files_of_own = lbr_client.unpacked(wheel, Path(place) / "unpacked").rglob("*")
        own = sum(path.stat().st_size for path in files_of_own if path.is_file())
        needed = sum(
            Path(one.locate()).stat().st_size
            for name in lbr_client.NEEDS
            for one in files(name) or ()
            if one.suffix != ".pyc"
        )
        results.sample("install", (own + needed) / 1e6)
        python = lbr_client.alone(Path(place) / "alone", wheel)
        _spent_ms("import lbr_client", python)  # compiles
        for _ in range(given.n):
            empty = _spent_ms("pass", python)
            results.sample("import", _spent_ms("import lbr_client", python) - empty)
            results.sample("bus", _spent_ms("import zenoh, msgspec", python) - empty)
    return Measured(results=results.ordered())


def _spent_ms(code: str, python: Path) -> float:
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    programs.run([python, "-c", code], env=environment, cwd="/", check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return (after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime) * 1000.0
