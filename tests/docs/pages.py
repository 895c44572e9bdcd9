"""The pages as tests see them: their fenced blocks, what those claim, and their links."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
PAGES = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")])
VARYING = "<!-- run: numbers vary -->"
RUN = {"<!-- run -->", VARYING}
"""What stands on the line before a block that is run: what is typed, and what must come back."""
FILE = re.compile(r"<!-- run: file ~/(\S+) -->")
"""Or before a block that is to be saved in a file."""

RUNNABLE = {"sh", "console", "text", "python", "csv"}
EVERY_ROBOT = ROOT / "docs" / "robots" / "lbr.md"
_LINK = re.compile(r"\[[^\]]*\]\(([^)\s]+)\)")
_HEADING = re.compile(r"^#{1,6} (.*)$")


@dataclass(frozen=True)
class Block:
    """A fenced block: its language, what stands on the line before it, and its text."""

    page: Path
    line: int
    language: str
    marker: str
    text: str

    @property
    def claimed(self) -> bool:
        """Whether the page claims that this is run."""
        return self.marker in RUN or FILE.fullmatch(self.marker) is not None

    @property
    def where(self) -> str:
        return f"{self.page.relative_to(ROOT)}:{self.line}"


def blocks(page: Path) -> list[Block]:
    """Return a page's fenced blocks in their order."""
    found, before, lines = [], "", iter(enumerate(page.read_text().splitlines(), 1))
    for number, line in lines:
        if line.startswith("```"):
            inside = list(_until_fence(lines))
            found.append(Block(page, number, line.strip("` "), before.strip(), "\n".join([*inside, ""])))
        before = line
    return found


def said(page: Path) -> set[str]:
    """Return what a robot's page types in its blocks, what its table of words says, and the words of every robot."""
    typed = {line for block in blocks(page) for line in re.findall(r"^Robot> (.+)$", block.text, flags=re.MULTILINE)}
    return typed | _words(page, "## What you can say") | _words(EVERY_ROBOT, "### Words of every robot")


def links(page: Path) -> list[str]:
    """Return the targets of a page's links, without those in fenced blocks."""
    text = re.sub(r"^```.*?^```", "", page.read_text(), flags=re.DOTALL | re.MULTILINE)
    return _LINK.findall(re.sub(r"`[^`\n]*`", "", text))


def anchors(page: Path) -> set[str]:
    """Return what a link to a heading of this page may name."""
    found = set()
    for line in re.sub(r"^```.*?^```", "", page.read_text(), flags=re.DOTALL | re.MULTILINE).splitlines():
        if heading := _HEADING.match(line):
            found.add(re.sub(r"[^\w\- ]", "", heading[1].lower()).replace(" ", "-"))
    return found


def _until_fence(lines: Iterator[tuple[int, str]]) -> Iterator[str]:
    for _number, line in lines:
        if line.startswith("```"):
            return
        yield line


def _words(page: Path, heading: str) -> set[str]:
    """Return what the first columns of a section's tables say."""
    section = page.read_text().split(f"{heading}\n")[1].split("\n## ")[0]
    cells = [line.split(" | ")[0] for line in section.splitlines() if line.startswith("| `")]
    return {word for cell in cells for word in re.findall(r"`([^`]+)`", cell)}
