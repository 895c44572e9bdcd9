"""Run a benchmark by its name: `python -m benchmarks safety --gate`. Without a name, list all.

`--json FILE` keeps the results; `python -m benchmarks safety --merge FILE --write-docs` puts them into the table in
benchmarks/figures.md. `--smoke` shows in seconds that a benchmark still works: only violations count, not
durations. Without a name, it runs all of them, several at a time. Exit code 1 if a hard value is broken.
"""

import argparse
import ast
import importlib
import os
import signal
import subprocess
import sys
import tempfile
import time
from io import BufferedRandom
from pathlib import Path

import msgspec

from benchmarks import FOLDER, Measured, names
from tests.support import programs
from tests.support.figures import Report, machine, table

SMOKE_S = 120.0
SPARE = 1
"""They wait more than they compute: so many more run at a time than there are cores."""


def main(words: list[str]) -> int:
    """Run the chosen benchmark."""
    signal.signal(
        signal.SIGINT, signal.default_int_handler
    )  # a shell in the background ignores the signal, also for its children
    if words[:1] and words[0] in names():
        return run(words[0], words[1:])
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks",
        description=__doc__,
        epilog=f"{listing()}\n\n`python -m benchmarks NAME --help` says what its options are.",
        formatter_class=argparse.RawDescriptionHelpFormatter,
        usage="%(prog)s [NAME] [options]",
    )
    parser.add_argument("--smoke", action="store_true", help="show that all of them still work")
    parser.add_argument("name", nargs="?", metavar="NAME", help=argparse.SUPPRESS)
    given = parser.parse_args(words)
    if given.name:
        parser.error(f"there is no benchmark {given.name}; there are {', '.join(names())}")
    if given.smoke:
        return smoke_all()
    print(listing())
    return 0


def listing() -> str:
    """Return the list of benchmarks, a line each."""
    return "\n".join(f"  {name:16} {_first_line(FOLDER / f'{name}.py')}" for name in names())


def run(name: str, words: list[str]) -> int:
    """Run one benchmark: print the results, keep them if requested, and return the exit code."""
    module = importlib.import_module(f"benchmarks.{name}")
    parser = argparse.ArgumentParser(
        prog=f"python -m benchmarks {name}",
        description=module.__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--json", type=Path, metavar="FILE", help="keep what came out in this file")
    parser.add_argument("--smoke", action="store_true", help=f"the same as {module.SMOKE}, judged by no time")
    module.options(parser)
    given = parser.parse_args(words)
    if given.smoke:
        given = parser.parse_args([*module.SMOKE.split(), *words])
    began, started = time.monotonic(), time.strftime("%Y-%m-%d %H:%M:%S %Z")
    found = module.measure(given)
    if found is None:
        return 0
    report = Report(
        machine=machine(),
        load=found.load,
        started=started,
        took_s=round(time.monotonic() - began, 1),
        results=found.results,
        repeated=found.repeated,
        disturbed=found.disturbed,
        figures=found.figures,
    )
    if given.json:
        report.write(given.json)
    return tell(report, found, smoke=given.smoke)


def tell(report: Report, found: Measured, *, smoke: bool) -> int:
    """Print the results; return 1 if they are bad."""
    print(f"{report.machine}; {report.load}\n")
    if report.results:
        print(table(report.results))
    if found.text:
        print(found.text)
    if found.figures:
        print(msgspec.json.format(msgspec.json.encode(found.figures)).decode())
    report.tell_repeated()
    for text in found.broken:
        print(f"BROKEN: {text}", file=sys.stderr)
    code = report.tell_broken() or int(bool(found.broken))
    return int(any(result.violations for result in report.results)) if smoke else code


def smoke_all() -> int:
    """Show that each benchmark still works; print the last output of those that do not. A failure beside others is
    tried again alone."""
    beside = _smoke(names(), (os.cpu_count() or 1) + SPARE)
    if beside:
        print(f"once more, alone: {', '.join(beside)}", flush=True)
    failed = _smoke(beside, 1)
    print(f"{len(names()) - len(failed)} of {len(names())} benchmarks work{'; not ' * bool(failed)}{', '.join(failed)}")
    return int(bool(failed))


def _smoke(wanted: list[str], at_once: int) -> list[str]:
    """Run benchmarks, so many at a time, and return the failed ones."""
    waiting, failed = list(wanted), []
    running: dict[str, tuple[subprocess.Popen[bytes], BufferedRandom, float]] = {}
    while waiting or running:
        while waiting and len(running) < at_once:
            name, said = waiting.pop(0), tempfile.TemporaryFile("w+b")  # noqa: SIM115 - closed when the program has ended
            argv = [sys.executable, "-m", "benchmarks", name, "--smoke"]
            running[name] = (programs.start(argv, stdout=said, stderr=said), said, time.monotonic())
        time.sleep(0.1)
        for name, (program, said, began) in list(running.items()):
            took_s = time.monotonic() - began
            if program.poll() is None and took_s > SMOKE_S:
                program.kill()
                program.wait()
            if program.poll() is not None:
                del running[name]
                failed += [name] if program.returncode else []
                print(f"{name}: {'FAILS' if program.returncode else 'works'}, {took_s:.0f} s", flush=True)
                said.seek(0)
                print("".join(f"    {line}\n" for line in _last(said.read()) if program.returncode), end="", flush=True)
                said.close()
    return failed


def _last(said: bytes) -> list[str]:
    return said.decode(errors="replace").strip().splitlines()[-20:]


def _first_line(path: Path) -> str:
    return (ast.get_docstring(ast.parse(path.read_text())) or "").split("\n", 1)[0]


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
