"""A14: the released packages are locked by hash, and the lock is the one that the project asks for."""

import re
import tomllib
from importlib import metadata
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from tests.support.figures import Results

ROOT = Path(__file__).resolve().parent.parent.parent
LOCK = ROOT / "requirements" / "lock.txt"
_PACKAGE = re.compile(
    r"^(?P<name>[A-Za-z0-9_.-]+)==(?P<version>\S+) \\\n(?P<hashes>(?:    --hash=\S+(?: \\)?\n)+)", re.MULTILINE
)
_HASH = re.compile(r"    --hash=sha256:[0-9a-f]{64}(?: \\)?")


def dependencies(results: Results) -> None:
    """Check the lock; whether a vulnerability is known `requirements/make audit` says, where there is a network."""
    results.check("A14", problems(LOCK.read_text(), (ROOT / "pyproject.toml").read_text()))


def problems(lock: str, project: str) -> list[str]:
    """Return what is wrong with a lock: packages without hashes, not asked for, not there, or of another version."""
    found = {canonicalize_name(match["name"]): match["version"] for match in _PACKAGE.finditer(lock)}
    lines = [line for line in lock.splitlines() if line and not line.lstrip().startswith("#")]
    wrong = [line for line in lines if line[0] == " " and not _HASH.fullmatch(line)]
    wrong += [
        line
        for line in lines
        if line[0] != " " and line.partition("==")[0] and canonicalize_name(line.partition("==")[0]) not in found
    ]
    declared = tomllib.loads(project)["project"]
    asked = [Requirement(text) for text in (*declared["dependencies"], *declared["optional-dependencies"]["sim"])]
    problems = [f"not by hash: {line}" for line in wrong]
    problems += [
        f"{one} is asked for, locked is {found.get(canonicalize_name(one.name))}"
        for one in asked
        if not _fits(one, found)
    ]
    needed = _closure({canonicalize_name(one.name) for one in asked})
    problems += [f"{name} is needed and not locked" for name in sorted(needed - set(found))]
    return problems + [f"{name} is locked and not needed" for name in sorted(set(found) - needed)]


def _fits(asked: Requirement, found: dict[str, str]) -> bool:
    version = found.get(canonicalize_name(asked.name))
    return version is not None and version in asked.specifier


def _closure(names: set[str]) -> set[str]:
    """Return the packages and what they bring along here."""
    seen: set[str] = set()
    waiting = set(names)
    while waiting:
        name = waiting.pop()
        seen.add(name)
        for text in metadata.requires(name) or ():
            one = Requirement(text)
            if one.marker is None or one.marker.evaluate({"extra": ""}):
                waiting |= {canonicalize_name(one.name)} - seen
    return seen
