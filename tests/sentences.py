"""Count the literals of the tests that repeat a sentence of the product, or write `sentences.txt` anew.

`python -m tests.sentences --count [FOLDER...]` and `--write [MODULE...]`. A test asserts a refusal's code and its subject;
sentences that people read stand in that one file. One that stands in tests, too, cannot be improved alone.
"""

import argparse
import ast
from collections import Counter
from collections.abc import Iterable, Iterator
from pathlib import Path

import pytest

from tests.support.wording import Writer

SHORTEST = 25
ROOT = Path(__file__).parent.parent


def literals(source: str) -> Iterator[tuple[int, str]]:
    """Yield each string of `source` with its line, an f-string in its parts; what documents code is left out."""
    tree = ast.parse(source)
    documents = {
        id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
    }
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in documents:
            yield node.lineno, node.value


def sentences(paths: Iterable[Path]) -> Iterator[tuple[Path, int, str]]:
    """Yield the literals that are long enough for a sentence, each with its place."""
    for path in paths:
        for line, text in literals(path.read_text(encoding="utf-8")):
            if len(text.strip()) >= SHORTEST and " " in text.strip():
                yield path, line, text.strip()


def repeated(folders: list[Path]) -> list[tuple[Path, int, str]]:
    """Return the literals under `folders` that stand in one of the product, or in which one of the product stands."""
    product = {text for _, _, text in sentences(sorted((ROOT / "lbr").rglob("*.py")))}
    whole = "\0".join(sorted(product))
    return [
        (path, line, text)
        for folder in folders
        for path, line, text in sentences(sorted(folder.rglob("*.py")))
        if text in whole or any(part in text for part in product)
    ]


def write(paths: list[Path]) -> int:
    """Run the tests that compare sentences, and write down what they are."""
    modules = [path for under in paths for path in ([under] if under.is_file() else sorted(under.rglob("test_*.py")))]
    asking = [str(path) for path in modules if "wording" in path.read_text(encoding="utf-8")]
    return pytest.main(["-m", "nightly or not nightly", *(asking or map(str, paths))], plugins=[Writer()])


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m tests.sentences", description=__doc__)
    action = parser.add_mutually_exclusive_group(required=True)
    action.add_argument("--count", action="store_true", help="print how many there are in each folder")
    action.add_argument("--write", action="store_true", help="write down what the tests of these modules have found")
    parser.add_argument("--lines", action="store_true", help="print each with its file and line, too")
    parser.add_argument("folders", nargs="*", type=Path, default=[ROOT / "tests"])
    options = parser.parse_args()
    folders = [folder.resolve() for folder in options.folders]
    if options.write:
        raise SystemExit(write(folders))
    rows = repeated(folders)
    if options.lines:
        for path, line, text in rows:
            print(f"{path.relative_to(ROOT)}:{line}: {text!r}")
    for folder, count in sorted(Counter(path.parent.relative_to(ROOT) for path, _, _ in rows).items()):
        print(f"{count:5} {folder}")
    print(f"{len(rows):5} literals repeat sentences of lbr")


if __name__ == "__main__":
    main()
