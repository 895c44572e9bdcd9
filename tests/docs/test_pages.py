"""What the pages claim holds: links lead somewhere, reference pages are fresh, blocks marked as run are run."""

import os
import re
import select
import shutil
import subprocess
import sys
import tempfile
import time
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from lbr import plugins
from tests.docs.pages import FILE, PAGES, ROOT, RUNNABLE, VARYING, Block, anchors, blocks, links
from tests.docs.ready import measured
from tests.support import packages, programs
from tests.support.robot import Robot, prepare, running
from tests.support.waiting import HANG_S

CLIENT = """#!{python}
import sqlite3, sys
database = sqlite3.connect(sys.argv[1], timeout=5)
if len(sys.argv) > 2:
    for row in database.execute(sys.argv[2]):
        print("|".join(str(value) for value in row))
    database.commit()
else:
    database.executescript(sys.stdin.read())
database.close()
"""
"""Stands in for the program `sqlite3` on machines that lack it."""

FOREIGN = {
    "ensurepip is not available",
    "requires a different Python",
    "No matching distribution found for mujoco-core",
    "lbr: command not found",
    "database is locked",
    "CHECK constraint failed",
    "FOREIGN KEY constraint failed",
    "capability 'lbr/…', settings: Object contains unknown field …",
}
"""Messages of pip, the shell, SQLite and msgspec."""

RUN_PAGES = [page for page in PAGES if any(block.claimed for block in blocks(page))]


def name(page: Path) -> str:
    return str(page.relative_to(ROOT))


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_links_lead_somewhere(page):
    for link in links(page):
        if link.startswith(("http://", "https://", "mailto:")):
            continue
        place, _, anchor = link.partition("#")
        target = (page.parent / place).resolve() if place else page
        assert target.exists(), f"{name(page)} links to {link}"
        assert ROOT in (target, *target.parents), f"{name(page)} links out of the project: {link}"
        assert not anchor or anchor in anchors(target), f"{name(page)} links to {link}, and there is no such heading"


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_every_fenced_block_says_its_language(page):
    for block in blocks(page):
        assert block.language, f"{block.where}: a fenced block without a language"
        assert not block.claimed or block.language in RUNNABLE, f"{block.where}: {block.language} is not run by tests"


def generate(*arguments: str) -> "subprocess.CompletedProcess[str]":
    command = [sys.executable, str(ROOT / "docs" / "generate.py"), *arguments]
    return programs.run(command, capture_output=True, text=True, check=False)


def test_reference_pages_are_fresh():
    done = generate("--check")
    assert done.returncode == 0, done.stderr


def test_what_other_packages_bring_is_not_in_the_reference(tmp_path):
    kind = "from lbr.capability import Capability, Kind\nKIND = Kind(name='stranger', summary='', family='app', entry=Capability)\n"
    brings = {field: {"stranger": "stranger:KIND"} for field in ("kinds", "twins", "commands")}
    packages.package(tmp_path, "stranger", brings=brings, files={"stranger.py": kind})
    command = [sys.executable, str(ROOT / "docs" / "generate.py"), "--check"]
    environment = {**os.environ, "PYTHONPATH": packages.on_path(tmp_path)}
    done = programs.run(command, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_a_stale_reference_page_is_noticed(tmp_path):
    copy = tmp_path / "project"
    for part in ("docs/generate.py", "docs/drivers.md", "docs/reference/cli.md", "robot.db.sql", "pyproject.toml"):
        (copy / part).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / part, copy / part)
    for page in (ROOT / "docs" / "reference").glob("*.md"):
        shutil.copy(page, copy / "docs" / "reference")
    with (copy / "docs" / "reference" / "rows.md").open("a") as file:
        file.write("an afterthought\n")
    done = programs.run(
        [sys.executable, str(copy / "docs" / "generate.py"), "--check"], capture_output=True, text=True, check=False
    )
    assert done.returncode == 1
    assert "rows.md" in done.stderr


def test_every_column_of_every_table_is_in_the_reference():
    import sqlite3

    database = sqlite3.connect(":memory:")
    database.executescript((ROOT / "robot.db.sql").read_text())
    page = (ROOT / "docs" / "reference" / "rows.md").read_text()
    sections = {part.split("\n", 1)[0]: part for part in page.split("\n## ")[1:]}
    tables = [row[0] for row in database.execute("SELECT name FROM pragma_table_list WHERE schema = 'main'")]
    for table in (one for one in tables if not one.startswith("sqlite_")):
        for (column,) in database.execute("SELECT name FROM pragma_table_info(?)", (table,)):
            assert f"\n|`{column}`" in sections[table], f"{table}.{column}"
    database.close()


def code(page: Path) -> str:
    """What a page shows as code: its fenced blocks and what stands in backquotes."""
    text = page.read_text()
    fenced = [block.text for block in blocks(page) if block.language in {"sh", "console"}]
    outside = re.sub(r"^```.*?^```", "", text, flags=re.DOTALL | re.MULTILINE)
    return "\n".join([*fenced, *re.findall(r"`([^`\n]+)`", outside)])


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_commands_that_a_page_names_exist(page):
    for command, word in re.findall(r"((?:^|[/ ])lbr ([a-z]+)(?: [a-z-]+)*)", code(page), flags=re.MULTILINE):
        assert word in {one.name for one in plugins.own("commands")}, f"{name(page)} names '{command.strip()}'"


def test_every_dependency_is_explained():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    extras = [one for group in project["optional-dependencies"].values() for one in group if not one.startswith("lbr[")]
    page = (ROOT / "docs" / "dependencies.md").read_text()
    for one in (*project["dependencies"], *extras):
        package = re.split(r"[<>=!~\[ ]", one)[0]
        assert f"`{package}`" in page, f"{package} is not in docs/dependencies.md"


def messages(page: Path) -> list[str]:
    """The messages that a page's tables explain: what stands in backquotes in a first column."""
    rows = [line.split(" | ")[0] for line in page.read_text().splitlines() if line.startswith("| ")]
    return [found for row in rows for found in re.findall(r"`([^`]+)`", row)]


def test_every_message_that_troubleshooting_explains_is_one_that_is_said():
    source = "".join(path.read_text() for path in (ROOT / "lbr").rglob("*.py"))
    explained = messages(ROOT / "docs" / "troubleshooting.md")
    assert len(explained) > 30
    for message in explained:
        parts = [part for part in re.split(r"…|: |'[a-z]+'|[0-9.]+ (?:s|m)\b", message) if len(part.strip()) > 3]
        missing = [part for part in parts if part.strip() not in source]
        assert message in FOREIGN or not missing, f"nobody says {missing} of '{message}'"


class Newcomer:
    """Somebody who types what a page says, with a home of their own and the robot running there."""

    def __init__(self, home: Path, robot: Robot) -> None:
        self.home = home
        self.robot = robot
        path = f"{home / 'bin'}:{Path(sys.executable).parent}:{os.environ['PATH']}"
        kept = {key: value for key, value in os.environ.items() if key != "LBR_HOME"}
        self.environment = kept | {"HOME": str(home), "PATH": path, "COLUMNS": "120", "LC_ALL": "C.UTF-8"}

    def follow(self, block: Block) -> None:
        if place := FILE.fullmatch(block.marker):
            path = self.home / place[1]
            path.parent.mkdir(mode=0o755, exist_ok=True)
            path.write_text(block.text)
            path.chmod(0o644)
        elif block.language in {"sh", "python"}:
            script = block.text if block.language == "sh" else f"python - <<'EOF'\n{block.text}EOF"
            done = self.shell(script)
            assert done.returncode == 0, f"{block.where}: {done.stderr}"
        else:
            self.converse(block)

    def converse(self, block: Block) -> None:
        """Type what the block says is typed, and expect what it says comes back."""
        for said, expected in exchanges(block):
            typed = said.removeprefix("$ ")
            if said == typed:
                self.see(block, expected, typed.removeprefix("Robot> "), lambda line: self.robot.line(line)["text"])
            elif block.marker == VARYING:
                self.see(block, expected, typed, self.both)
            else:
                self.check(block, typed, expected, self.both(typed))

    def see(self, block: Block, expected: str, typed: str, do: Callable[[str], str]) -> None:
        """Type something, and again while an edit or the status of a moment ago may still be on its way."""
        end = time.monotonic() + HANG_S
        got = do(typed)
        while not agrees(expected, got, varying=block.marker == VARYING) and time.monotonic() < end:
            select.select([], [], [], 0.1)
            got = do(typed)
        self.check(block, typed, expected, got)

    def check(self, block: Block, said: str, expected: str, got: str) -> None:
        assert agrees(expected, got, varying=block.marker == VARYING), (
            f"{block.where}: {said}\nexpected:\n{expected}\ngot:\n{got}"
        )

    def both(self, command: str) -> str:
        """Return what a command prints, on either stream, in the order it was printed."""
        said = self.shell(command, errors=subprocess.STDOUT).stdout
        return "".join(line for line in said.splitlines(keepends=True) if NOT_RUN_HERE not in line)

    def shell(self, script: str, errors: int = subprocess.PIPE) -> "subprocess.CompletedProcess[str]":
        return programs.run(
            ["bash", "-uo", "pipefail", "-ec", script],
            env=self.environment,
            cwd=ROOT,
            stdout=subprocess.PIPE,
            stderr=errors,
            text=True,
            timeout=20,
            check=False,
            stdin=subprocess.DEVNULL,
        )


NOT_RUN_HERE = ": hint: nothing feeds 'drive."
"""The robot of these tests lacks what feeds its drive besides the ranges; the pages' robot is whole."""


def agrees(expected: str, got: str, *, varying: bool = False) -> bool:
    """Compare word by word: `...` stands for anything, and in a block that varies a number for any number."""
    pattern = re.escape(" ".join(expected.split()))
    pattern = re.sub(r"(\\ )?\\\.\\\.\\\.(\\ )?", ".*", pattern)
    if varying:
        pattern = re.sub(r"\d+(\\\.\d+)?", r"\\d+(\\.\\d+)?", pattern)
    return re.fullmatch(pattern, " ".join(got.split())) is not None


def exchanges(block: Block) -> list[tuple[str, str]]:
    """Split a block into what is typed and what is answered."""
    found: list[tuple[str, list[str]]] = []
    for line in block.text.splitlines():
        if line.startswith(("$ ", "Robot> ")):
            found.append((line, []))
        else:
            assert found, f"{block.where}: output before any input"
            found[-1][1].append(line)
    assert found, f"{block.where}: nothing is typed"
    return [(said, "\n".join(lines)) for said, lines in found]


@pytest.mark.parametrize(
    ("expected", "got", "varying", "fits"),
    [
        ("power is 0 to 1, not 3", "power is 0 to 1, not 3\n", False, True),
        ("power is 0 to 1, not 3", "power is 0 to 1, not 4", False, False),
        ("pid ..., up ... s", "pid 71, up 3 s", False, True),
        ("a ... b", "a b", False, True),
        ("a ... b", "a b c", False, False),
        ("up 3.5 s (?)", "up 12 s (?)", True, True),
        ("up 3.5 s", "up long s", True, False),
    ],
)
def test_outputs_are_compared_as_the_pages_say(expected, got, varying, fits):
    assert agrees(expected, got, varying=varying) is fits


@pytest.fixture
def newcomer() -> Iterator[Newcomer]:
    with tempfile.TemporaryDirectory(prefix="lbr-") as place:
        home = Path(place)
        (home / "bin").mkdir()
        (home / ".sqliterc").write_text(".timeout 2000\n")  # as the pages say that it should be, once
        if shutil.which("sqlite3") is None:
            client = home / "bin" / "sqlite3"
            client.write_text(CLIENT.format(python=sys.executable))
            client.chmod(0o755)
        with running(prepare(home / ".lbr")) as robot:
            measured(robot)
            yield Newcomer(home, robot)


@pytest.mark.slow_start
@pytest.mark.parametrize("page", RUN_PAGES, ids=name)
def test_what_a_page_says_is_run_works(newcomer, page):
    for block in blocks(page):
        if block.claimed:
            newcomer.follow(block)


def test_the_commands_that_the_readme_begins_with_are_the_ones_that_are_checked():
    marked = {block.marker: block.text for block in blocks(ROOT / "README.md") if not block.claimed}
    run, test = marked["<!-- run-command -->"], marked["<!-- test-command -->"]
    assert "\n" not in run.strip() + test.strip()
    assert run.split(" && ")[0] == test.split(" && ")[0]
    check = (ROOT / ".ci" / "run").read_text()
    assert all(f"command_of {name}" in check for name in ("run", "test"))
    installed = run.split(" && ")[1]
    assert installed.endswith("pip install -e '.[sim]'")
    lighter = installed.replace("install", "install --no-compile")  # tests import a tenth of it
    assert test.split(" && ")[1] == lighter.replace("[sim]", "[sim,test]")


@pytest.mark.slow_start
def test_the_first_command_of_the_readme_starts_a_robot_in_a_new_home(tmp_path):
    command = next(b.text for b in blocks(ROOT / "README.md") if b.marker == "<!-- run-command -->").split(" && ")[-1]
    arguments = command.strip().split("/lbr ")[1].split()
    environment = {key: value for key, value in os.environ.items() if key != "LBR_HOME"} | {"HOME": str(tmp_path)}
    done = programs.run(
        [sys.executable, "-m", "lbr.start", *arguments],
        env=environment,
        input="status\nShutdown\n",
        capture_output=True,
        text=True,
        timeout=20,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert "shutting down" in done.stdout
    assert (tmp_path / ".lbr" / "robot.db").stat().st_mode & 0o777 == 0o600
