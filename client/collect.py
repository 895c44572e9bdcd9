"""The build hook of the distribution lbr-client: adds the modules of lbr that `lbr.client` needs, unchanged.

A wheel has them in a folder of its own, so that it touches no file of an installed lbr. It has them again as the stubs
`lbr-stubs`, because type checkers do not look into that folder. A source distribution has them as in the tree, and is
built without the tree.
"""

import ast
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

PRIVATE = "lbr_client/_modules"
STUBS = "lbr-stubs"


class Collect(BuildHookInterface):
    """Collects the modules at a build; an editable installation has the whole tree on its path instead."""

    PLUGIN_NAME = "custom"

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Set the files to include."""
        if version == "editable":
            return
        here = Path(self.root)
        root = here if (here / "lbr").is_dir() else here.parent
        found = modules(root)
        prefix = Path(PRIVATE if self.target_name == "wheel" else "")
        build_data["force_include"] |= {str(path): str(prefix / path.relative_to(root)) for path in found}
        if self.target_name == "wheel":
            self._stubs = tempfile.TemporaryDirectory(prefix="lbr-client-")
            _write_stubs(Path(self._stubs.name), root / "lbr", found)
            build_data["force_include"][self._stubs.name] = STUBS

    def finalize(self, version: str, _build_data: dict[str, Any], _artifact: str) -> None:
        """Remove the collected files."""
        if version != "editable" and self.target_name == "wheel":
            self._stubs.cleanup()


def modules(root: Path) -> set[Path]:
    """Return the modules of `lbr.client` and all others of lbr that they import, even within functions."""
    waiting, found = list((root / "lbr" / "client").glob("*.py")), set[Path]()
    while waiting:
        path = waiting.pop()
        if path not in found:
            found.add(path)
            waiting += _imported(path, root)
    return found


def _imported(path: Path, root: Path) -> Iterator[Path]:
    for node in ast.walk(ast.parse(path.read_text())):
        names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
        if isinstance(node, ast.ImportFrom) and node.module and not node.level:
            names = [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
        for name in names:
            parts = name.split(".")
            for end in range(1, len(parts) + 1) if parts[0] == "lbr" else ():
                yield from _module(root.joinpath(*parts[:end]))


def _module(place: Path) -> Iterator[Path]:
    yield from (path for path in (place / "__init__.py", place.with_suffix(".py")) if path.is_file())


def _write_stubs(folder: Path, package: Path, found: set[Path]) -> None:
    for path in found:
        stub = folder / path.relative_to(package).with_suffix(".pyi")
        stub.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(path, stub)
    (folder / "py.typed").write_text("partial\n")  # the other modules are those of an installed lbr
