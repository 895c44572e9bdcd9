"""A new table touches two files, its class and the kind that reads it; one command writes all else from them."""

import os
import shutil
import sys
from pathlib import Path

import pytest

from lbr.database import migrate
from tests.support import databases, programs

ROOT = Path(__file__).parents[2]
NEXT = f"{int(migrate.HEAD) + 1:04d}"
pytestmark = [pytest.mark.timeout(300)]
ENCORE = '''

class Encore(Row, frozen=True, kw_only=True):
    """What is danced once more."""

    TABLE = "encore"
    KEY = ("dance",)

    dance: Annotated[Name, "which dance"]
    times: Annotated[int, Meta(ge=1, le=9), "how often"] = 1
'''
BEATS = 'Meta(ge=1, le=64), "for how many beats"] = 1\n'
OPENED = """
import sys
from pathlib import Path
from lbr.apps.dance.messages import Encore
from lbr.database import edits
from lbr.database.store import Database
for path in sys.argv[1:]:
    with Database.open(Path(path)) as database:
        edits.learn(database, "lbr", [Encore(dance="waltz", times=2)])
        print([row.times for row in database.load("lbr").of(Encore)], [one.table for one in database.revisions()])
"""


def run(tree: Path, *arguments: object) -> tuple[int, str, str]:
    environment = {**os.environ, "PYTHONPATH": str(tree)}
    command = [sys.executable, *map(str, arguments)]
    done = programs.run(command, env=environment, cwd=tree, capture_output=True, text=True, check=False)
    return done.returncode, done.stdout, done.stderr


def edit(path: Path, old: str, new: str) -> None:
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))


def declare(tree: Path) -> None:
    """Have a kind read one table more, and give another a column and a wider bound."""
    messages, kind = (tree / "lbr" / "apps" / "dance" / name for name in ("messages.py", "kind.py"))
    messages.write_text(messages.read_text() + ENCORE)
    edit(messages, BEATS, BEATS.replace("64", "99") + '    side: Annotated[int, "which foot"] = 0\n')
    edit(kind, "DanceState, DanceStep\n", "DanceState, DanceStep, Encore\n")
    edit(kind, "import Command, Kind, Known, names", "import Command, Kind, Known, Rows, names")
    edit(kind, "rows=(DanceStep,)", "rows=(DanceStep, Rows(Encore, learnt=True))")


@pytest.fixture(scope="module")
def tree(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """lbr as its source stands, with what was compiled of it, with two files changed and all else written from them."""
    copy = tmp_path_factory.mktemp("tree")
    kept = shutil.ignore_patterns("*.pyc.*", "node_modules", "page")
    shutil.copytree(ROOT / "lbr", copy / "lbr", ignore=kept)
    shutil.copytree(ROOT / "docs" / "reference", copy / "docs" / "reference")
    for name in ("docs/generate.py", "docs/drivers.md", "robot.db.sql", "pyproject.toml"):
        shutil.copy(ROOT / name, copy / name)
    declare(copy)
    code, _, said = run(copy, "docs/generate.py", "--check")
    assert (code, "encore" in said, "choreography" in said) == (1, True, True)
    assert run(copy, "docs/generate.py", "--step", "encores")[::2] == (0, "")
    return copy


@pytest.fixture(scope="module")
def opened(tree: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """An old and a new database, both opened and written to by the changed lbr."""
    old = databases.fresh(tmp_path_factory.mktemp("opened") / "robot.db")
    new = old.with_name("new.db")
    databases.edit(new, (tree / "robot.db.sql").read_text())
    new.chmod(0o600)
    assert run(tree, "-c", OPENED, old, new) == (0, "[2] ['encore']\n" * 2, "")
    return old, new


def test_two_files_make_a_table_in_new_databases_old_ones_and_pages(tree, opened):
    assert "CREATE TRIGGER encore_delete" in (tree / "robot.db.sql").read_text()
    assert "## encore" in (tree / "docs" / "reference" / "rows.md").read_text()
    old, new = opened
    assert schema(old) == schema(new)
    assert old.with_name(f"robot.db.backup-{migrate.HEAD}").exists()


def test_a_table_that_changes_is_built_again_with_what_stood_in_it(opened):
    old, _ = opened
    steps = "SELECT robot, dance, step, beats FROM choreography"
    assert databases.asked(old, "SELECT version_num FROM alembic_version") == [(NEXT,)]
    assert databases.asked(old, steps) == databases.asked(old.with_name(f"robot.db.backup-{migrate.HEAD}"), steps)
    databases.edit(old, "UPDATE choreography SET beats = 80, side = 1 WHERE step = 1")
    assert databases.asked(old, "SELECT table_name FROM revision") == [("encore",), ("choreography",)]


def schema(path: Path) -> list[tuple[str, str]]:
    """Return what is in a database, without the quotes that a table's second name has."""
    found = databases.asked(path, "SELECT name, sql FROM sqlite_schema WHERE sql IS NOT NULL ORDER BY name")
    return [(name, sql.replace('"', "")) for name, sql in found]
