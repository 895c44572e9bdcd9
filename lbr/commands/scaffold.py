"""The packages that `lbr new` writes from the templates beside this module, under an unused name."""

import importlib.util
import keyword
import os
import re
import shlex
import shutil
import string
import sys
from collections.abc import Iterator
from contextlib import suppress
from importlib import resources
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Literal

from lbr import home, plugins
from lbr.capability import registry
from lbr.capability.kind import KindError
from lbr.database import builtin
from lbr.errors import InputError
from lbr.plugins import Field
from lbr.robot import registry as robots
from lbr.robot.registry import plain

What = Literal["robot", "driver", "servos", "wheels", "silent_wheels", "capability"]
BASES: dict[What, What] = {"silent_wheels": "wheels"}
"""Templates whose files complete those of another template."""
BROUGHT: dict[Field, str] = {
    "robots": "a robot",
    "kinds": "a kind of capability",
    "twins": "a type of device",
    "faces": "a face",
}
LONGEST = 30
_NAME = re.compile(r"[a-z][a-z0-9]*([-_][a-z0-9]+)*")
_OURS = {"lbr", "lbr_client", "tests", "docs", "executive"}
"""Names of lbr itself, and of folders beside a package's own."""


def write(template: What, name: str, into: Path) -> Path:
    """Write a package into a folder of that name, whole or not at all; raise InputError with reason and cure."""
    check_name(template, name)
    if not into.is_dir():
        raise InputError(f"there is no folder {into}: make it first, or name another with --into")
    folder = into / name
    if folder.exists() or folder.is_symlink():
        raise InputError(f"{folder} is there already, and stays as it is: choose another name, or --into", "exists")
    fresh = into / f".{name}.{os.getpid()}"
    try:
        try:
            for path, text in files(template, name):
                (fresh / path).parent.mkdir(parents=True, exist_ok=True)
                (fresh / path).write_text(text, encoding="utf-8")
            fresh.rename(folder)
        finally:
            shutil.rmtree(fresh, ignore_errors=True)
    except OSError as err:
        raise InputError(f"{folder} cannot be written: {err.strerror or err}") from err
    return folder


def files(template: What, name: str) -> Iterator[tuple[Path, str]]:
    """Yield the files of a package: the path in it, and the content."""
    words = {
        "name": plain(name),
        "dash": name.replace("_", "-"),
        "Class": "".join(part.capitalize() for part in plain(name).split("_")),
        "requires": _required(plugins.version()),
    }
    folder = resources.files("lbr.commands") / "templates" / "new"
    templates = dict(_templates(folder / BASES[template])) if template in BASES else {}
    for path, text in (templates | dict(_templates(folder / template))).items():
        place = path.replace("NAME", words["name"]).replace("DASH", words["dash"]).removesuffix(".in")
        yield Path(place), string.Template(text).substitute(words)


def check_name(template: What, name: str) -> None:
    """Refuse a name that is invalid or in use; the text proposes another."""
    if not _NAME.fullmatch(name) or len(name) > LONGEST:
        rule = f"small letters, digits and single dashes or underscores, beginning with a letter, {LONGEST} at most"
        raise InputError(f"'{name}' is not a name of a package: {rule}{_hint(template, _near(name))}")
    for why in _conflicts(template, plain(name)):
        raise InputError(f"'{name}' {why}: choose another name{_hint(template, f'my-{name}')}", "exists")


def next_steps(template: What, name: str, folder: Path) -> tuple[str, ...]:
    """Return the next commands to type in this shell, and the page to read."""
    tools, extra = _tools(), "" if importlib.util.find_spec("pytest") is not None else "[test]"
    typed = f"./{folder}" if not folder.is_absolute() and folder.parts[0] != ".." else str(folder)
    page = {"robot": "robot_packages", "capability": "capabilities"}.get(template, "drivers")
    return (
        f"{tools}pip install -e {shlex.quote(f'{typed}{extra}')}",
        f"{tools}lbr run {name.replace('_', '-')}-sim",
        f"{tools}pytest {shlex.quote(typed)}",
        f"{typed}/README.md explains each file, docs/{page}.md of lbr all the rest",
    )


def _hint(what: What, name: str) -> str:
    """Return a proposal for a name, as a question; empty if that one is not usable either."""
    free = _NAME.fullmatch(name) and len(name) <= LONGEST and not any(_conflicts(what, plain(name)))
    return f"; did you mean '{name}'?" if free else ""


def _near(name: str) -> str:
    """Return the most similar name of valid form."""
    apart = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "-", name).lower()
    return re.sub(r"[^a-z0-9]+", "-", apart).lstrip("-0123456789")[:LONGEST].strip("-")


def _conflicts(template: What, name: str) -> Iterator[str]:
    """Yield why the name is already in use, for each owner."""
    if keyword.iskeyword(name):
        yield "is a word of Python itself"
    elif name in sys.stdlib_module_names:
        yield "is a module of Python's own library"
    elif name in _OURS:
        yield "is a name of lbr itself"
    yield from _brought(name)
    if (own := registry.user_directory(home.home()) / f"{name}.py").is_file():
        yield f"is a capability of your own already, in {own}"
    if template == "capability" and (whose := _word_of(name)):
        yield f"is a word of the console already, of {whose}"
    with suppress(ImportError, ValueError):
        if (spec := importlib.util.find_spec(name)) is not None:
            yield f"is a module that is installed already, at {spec.origin or 'several places'}"


def _brought(name: str) -> Iterator[str]:
    """Yield the packages that bring something of that name."""
    for field, kind in BROUGHT.items():
        known = {plain(one.name): one for one in plugins.every(field)}
        if name in known:
            yield f"is {kind} of package '{known[name].package}' already"
    for found in robots.every():
        profiles = map(plain, robots.profiles(found.robot)) if found.robot is not None else ()
        if found.name != name and {name, f"{name}_sim"} & set(profiles):
            yield f"is a launch profile of the robot '{found.name}' already"


def _word_of(name: str) -> str:
    """Return the source of a console word; empty without one."""
    if builtin.is_builtin(name):
        return "every robot"
    for kind in plugins.installed("kinds"):
        with suppress(KindError):
            if any(
                word.pattern.strip("/").partition("/")[0] == name for word in registry.find(kind, home.home()).words
            ):
                return f"the kind '{kind}'"
    return ""


def _templates(folder: Traversable, at: str = "") -> Iterator[tuple[str, str]]:
    for entry in sorted(folder.iterdir(), key=lambda entry: entry.name):
        if entry.is_dir():
            yield from _templates(entry, f"{at}{entry.name}/")
        elif entry.name.endswith(".in"):
            yield f"{at}{entry.name}", entry.read_text(encoding="utf-8")


def _required(version: str) -> str:
    """Return the versions of lbr for a package that was begun with this one: until 1.0 each minor version may
    differ."""
    major, minor = (int(part) for part in version.split(".")[:2])
    return f"lbr>={major}.{minor},<{major}.{minor + 1}" if major == 0 else f"lbr>={major}.{minor},<{major + 1}"


def _tools() -> str:
    """Return the prefix of `pip` for the running Python; empty if that one is on the path."""
    folder = Path(sys.executable).parent
    if (found := shutil.which("pip")) is not None and Path(found).parent == folder:
        return ""
    with suppress(ValueError):
        return f"{folder.relative_to(Path.cwd())}/"
    return f"{folder}/"
