"""The sentences that people read, in one file: a test compares those that it brings about with what stands there.

`python -m tests.sentences --write` rewrites the file; what differs is read in review.
"""

import re
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path

import pytest
from msgspec import Struct

from lbr.messages.codes import MEANINGS

ROOT = Path(__file__).parents[2]
GOLDEN = ROOT / "tests" / "sentences.txt"
PLACES = ("home", "shared_home", "tmp_path")
"""Fixtures whose value is another one in each run."""
TIME = re.compile(r"\d{4}-\d\d-\d\dT[\d:.]+Z")
LINE_ENDS = re.compile(r"[\n\r\x0b\x0c\x1c-\x1e\x85\u2028\u2029]")

Sentences = dict[str, dict[str, list[str]]]
"""The lines of each test of each module."""


@cache
def read() -> Sentences:
    found: Sentences = {}
    module = test = ""
    for line in GOLDEN.read_text(encoding="utf-8").splitlines():
        if line.startswith("    "):
            found[module][test].append(line[4:])
        elif line.startswith("  "):
            test = line[2:]
            found[module][test] = []
        elif line:
            module = line
            found[module] = {}
    return found


def write(sentences: Sentences) -> None:
    blocks = []
    for module, tests in sorted(sentences.items()):
        stand = [(name, said) for name, said in sorted(tests.items()) if stands(module, name)]
        lines = [line for name, said in stand for line in (f"  {name}", *(f"    {one}" for one in said))]
        blocks += ["\n".join([module, *lines]) + "\n"] if lines else []
    GOLDEN.write_text("\n".join(blocks), encoding="utf-8")


def stands(module: str, name: str) -> bool:
    """Say whether there is such a test, and it compares sentences."""
    path = ROOT / module
    signature = rf"def {name.partition('[')[0]}\([^)]*\bwording\b"
    return path.is_file() and bool(re.search(signature, path.read_text(encoding="utf-8")))


def sentence(said: object) -> str:
    """Return a sentence, after the code of an error or an answer."""
    code = getattr(said, "code", "") if isinstance(said, Exception | Struct) else ""
    text = str(said.reason if isinstance(said, Struct) and hasattr(said, "reason") else said) or "(nothing)"
    return f"{code}: {text}" if code in MEANINGS else text


class Wording:
    """The sentences of one test, in order; `hidden` has what is another one in each run, and its name."""

    def __init__(self, golden: list[str] | None, hidden: dict[str, str]) -> None:
        self.lines: list[str] = []
        self._golden = golden
        self._hidden = hidden

    def __call__(self, *texts: object) -> None:
        """Compare sentences with the next lines of the file."""
        at = len(self.lines)
        said = "\n".join(map(sentence, texts))
        for volatile, name in self._hidden.items():
            said = said.replace(volatile, name)
        said = TIME.sub("(time)", said)
        self.lines += [line.rstrip() for line in LINE_ENDS.split(said) if line.strip()]
        if self._golden is not None:
            assert self.lines[at:] == self._golden[at : len(self.lines)], (
                "`python -m tests.sentences --write` writes down what is said now"
            )

    @contextmanager
    def of(self, kind: type[BaseException]) -> Iterator["pytest.ExceptionInfo[BaseException]"]:
        """Expect an error, and compare it."""
        with pytest.raises(kind) as caught:
            yield caught
        self(caught.value)


class Writer:
    """A plugin of pytest that takes sentences as they are, and writes them if all tests pass."""

    def __init__(self) -> None:
        self.sentences: Sentences = {}

    def pytest_configure(self, config: pytest.Config) -> None:
        config.stash[WRITER] = self

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        """Leave out the tests that compare none."""
        self.sentences.update((item.location[0], {}) for item in items)
        items[:] = [item for item in items if "wording" in getattr(item, "fixturenames", ())]

    def pytest_sessionfinish(self, exitstatus: int) -> None:
        if exitstatus == pytest.ExitCode.OK:
            write({**read(), **self.sentences})


WRITER = pytest.StashKey[Writer]()


@pytest.fixture
def wording(request: pytest.FixtureRequest) -> Iterator[Wording]:
    """The sentences of this test: what differs from the file, or is not in it, fails."""
    module = request.node.location[0]
    hidden = {str(request.getfixturevalue(name)): name for name in PLACES if name in request.fixturenames}
    writer = request.config.stash.get(WRITER, None)
    golden = None if writer else read().get(module, {}).get(request.node.name, [])
    found = Wording(golden, hidden)
    yield found
    assert found.lines, "nothing was compared"
    if writer:
        writer.sentences[module][request.node.name] = found.lines
    else:
        assert len(found.lines) >= len(golden), "more is in the file"
