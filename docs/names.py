"""Read the names in the code of lbr: those that say nothing of the domain and live longer than three lines.

`python docs/names.py` lists how many each package has, and with packages after it each of them. `--check` fails where a
package has more than docs/names.toml says; `--write` stores how many there are now.
"""

import argparse
import ast
import sys
import tomllib
from collections.abc import Container, Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
CEILINGS = Path(__file__).with_name("names.toml")
LIVES_LINES = 3
VAGUE = frozenset({
    "found", "gone", "heard", "here", "it", "kept", "left", "new", "old", "one", "other", "out", "said", "shown", "taken",
    "that", "them", "there", "these", "thing", "those", "told", "what", "who",
})  # fmt: skip
"""Words that are no noun of the domain. As a part of a longer name they do no harm, but for `_said` and `_told`. `left`
is a side where `right` is beside it."""
VERBS = ("_heard", "_said", "_told")
FUNCTIONS = ast.FunctionDef | ast.AsyncFunctionDef


def is_vague(name: str) -> bool:
    """Tell whether a name says nothing of what it names."""
    return name.strip("_") in VAGUE or name.endswith(VERBS)


def vague_names(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """Yield the line and name of each function, attribute, and variable longer than three lines, that is vague."""
    for node in ast.walk(tree):
        match node:
            case ast.ClassDef(body=body):
                yield from _attributes(body)
            case ast.FunctionDef() | ast.AsyncFunctionDef():
                if is_vague(node.name):
                    yield node.lineno, node.name
                yield from _variables(node)


def _attributes(body: list[ast.stmt]) -> Iterator[tuple[int, str]]:
    lines = {
        statement.target.id: statement.lineno
        for statement in body
        if isinstance(statement, ast.AnnAssign) and isinstance(statement.target, ast.Name)
    }
    yield from ((line, name) for name, line in lines.items() if is_vague(name) and not _is_side(name, lines))


def _variables(function: FUNCTIONS) -> Iterator[tuple[int, str]]:
    lines: dict[str, list[int]] = {}
    for node in ast.walk(function):
        match node:
            case ast.Name(id=name) | ast.arg(arg=name):
                lines.setdefault(name, []).append(node.lineno)
    vague = {name: at for name, at in lines.items() if is_vague(name) and not _is_side(name, lines)}
    yield from ((min(at), name) for name, at in vague.items() if max(at) - min(at) > LIVES_LINES)


def _is_side(name: str, beside: Container[str]) -> bool:
    return name == "left" and "right" in beside


def packages() -> dict[str, Path]:
    """Return the packages of lbr, those of the components each by itself."""
    rooms = [path for path in (ROOT / "lbr").iterdir() if (path / "__init__.py").is_file()]
    return {path.relative_to(ROOT).as_posix(): path for path in sorted(rooms)}


def names(package: Path) -> list[str]:
    """Return the vague names in a package, each with file and line."""
    return [
        f"{path.relative_to(ROOT)}:{line}: {name}"
        for path in sorted(package.rglob("*.py"))
        for line, name in vague_names(ast.parse(path.read_text()))
    ]


def main(arguments: list[str]) -> int:
    """List, check or store; return the exit code."""
    parser = argparse.ArgumentParser(description="Names in the code that say nothing of the domain.")
    parser.add_argument("package", nargs="*", help="a package whose names to list, as lbr/drivers")
    parser.add_argument("--check", action="store_true", help="fail where there are more than docs/names.toml says")
    parser.add_argument("--write", action="store_true", help="store how many there are now")
    options = parser.parse_args(arguments)
    listed = {name: names(path) for name, path in packages().items() if not options.package or name in options.package}
    if options.write:
        rows = [f'"{name}" = {len(each)}' for name, each in listed.items()]
        CEILINGS.write_text(
            "\n".join(["# Written by `python docs/names.py --write`: no package may have more.", *rows, ""])
        )
    elif options.check:
        ceilings = tomllib.loads(CEILINGS.read_text())
        worse = {name: each for name, each in listed.items() if len(each) > ceilings.get(name, 0)}
        for name, each in worse.items():
            print(f"{name}: {len(each)} vague names, was {ceilings.get(name, 0)}; `make names P={name}` lists them")
        return 1 if worse else 0
    elif options.package:
        print(*(line for each in listed.values() for line in each), sep="\n")
    else:
        print(*(f"{len(each):5} {name}" for name, each in listed.items()), sep="\n")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
