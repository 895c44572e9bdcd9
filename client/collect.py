"""What goes into the distribution lbr-client: `lbr/client` as the package `lbr_client`, with the modules that it needs.

They are the very modules that lbr's own commands use, under another name, so that both can be installed side by side.
"""

import ast
import re
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

ROOT = Path(__file__).resolve().parent.parent
FRONT = ROOT / "lbr" / "client"
NAMED = re.compile(r"^(\s*(?:from|import)\s+)lbr(?:\.client)?(?=[.\s])", re.MULTILINE)


class Collect(BuildHookInterface):
    """Collects the modules when the wheel is built; an editable installation has them too, as they are then."""

    PLUGIN_NAME = "custom"

    def initialize(self, _version: str, build_data: dict[str, Any]) -> None:
        """Say what is to be included."""
        self._folder = tempfile.TemporaryDirectory(prefix="lbr-client-")
        folder = Path(self._folder.name) / "lbr_client"
        for path in set().union(*map(modules, FRONT.glob("*.py"))):
            place = folder / path.relative_to(FRONT if path.is_relative_to(FRONT) else ROOT / "lbr")
            place.parent.mkdir(parents=True, exist_ok=True)
            place.write_text(NAMED.sub(r"\1lbr_client", path.read_text()))
        (folder / "py.typed").touch()
        build_data["force_include"][str(folder)] = "lbr_client"

    def finalize(self, _version: str, _build_data: dict[str, Any], _artifact: str) -> None:
        """Remove what was collected."""
        self._folder.cleanup()


def modules(start: Path) -> set[Path]:
    """Return a module of lbr and all others that it imports, also within functions, without lbr's own `__init__`."""
    waiting, found = [start], set[Path]()
    while waiting:
        path = waiting.pop()
        if path not in found:
            found.add(path)
            waiting += _imported(path)
    return found - {ROOT / "lbr" / "__init__.py"}


def _imported(path: Path) -> Iterator[Path]:
    for node in ast.walk(ast.parse(path.read_text())):
        names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
        if isinstance(node, ast.ImportFrom) and node.module and not node.level:
            names = [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
        for name in names:
            parts = name.split(".")
            for end in range(2, len(parts) + 1) if parts[0] == "lbr" else ():
                yield from _module(ROOT.joinpath(*parts[:end]))


def _module(place: Path) -> Iterator[Path]:
    yield from (path for path in (place / "__init__.py", place.with_suffix(".py")) if path.is_file())
