"""A new table touches two files, its class and the kind that reads it; one command writes all else from them."""

import os
import shutil
import sqlite3
import sys
from contextlib import closing
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


@pytest.fixture
def tree(tmp_path: Path) -> Path:
    """lbr as its source stands, with what was compiled of it, to be changed."""
    copy = tmp_path / "project"
    kept = shutil.ignore_patterns("*.pyc.*", "node_modules", "page")
    shutil.copytree(ROOT / "lbr", copy / "lbr", ignore=kept)
    shutil.copytree(ROOT / "docs" / "reference", copy / "docs" / "reference")
    for name in ("docs/generate.py", "docs/drivers.md", "robot.db.sql", "pyproject.toml"):
        shutil.copy(ROOT / name, copy / name)
    return copy


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
    """Change the two files."""
    messages, kind = (tree / "lbr" / "apps" / "dance" / name for name in ("messages.py", "kind.py"))
    messages.write_text(messages.read_text() + ENCORE)
    edit(kind, "DanceState, DanceStep\n", "DanceState, DanceStep, Encore\n")
    edit(kind, "import Command, Kind, Known, names", "import Command, Kind, Known, Rows, names")
    edit(kind, "rows=(DanceStep,)", "rows=(DanceStep, Rows(Encore, learnt=True))")


def test_two_files_make_a_table_in_new_databases_old_ones_and_pages(tree, tmp_path):
    old = tmp_path / "robot.db"
    databases.fresh(old)
    declare(tree)
    code, _, said = run(tree, "docs/generate.py", "--check")
    assert (code, "encore" in said) == (1, True)
    assert run(tree, "docs/generate.py", "--step", "encores")[::2] == (0, "")
    assert "CREATE TRIGGER encore_delete" in (tree / "robot.db.sql").read_text()
    assert "## encore" in (tree / "docs" / "reference" / "rows.md").read_text()
    with closing(sqlite3.connect(tmp_path / "new.db")) as new:
        new.executescript((tree / "robot.db.sql").read_text())
    (tmp_path / "new.db").chmod(0o600)
    assert run(tree, "-c", OPENED, old, tmp_path / "new.db") == (0, "[2] ['encore']\n" * 2, "")
    assert schema(old) == schema(tmp_path / "new.db")
    assert old.with_name(f"robot.db.backup-{migrate.HEAD}").exists()


def test_a_table_that_changes_is_built_again_with_what_stood_in_it(tree, tmp_path):
    old = tmp_path / "robot.db"
    databases.fresh(old)
    with closing(sqlite3.connect(old)) as before:
        steps = before.execute("SELECT robot, dance, step, beats FROM choreography").fetchall()
    edit(
        tree / "lbr" / "apps" / "dance" / "messages.py",
        'Meta(ge=1, le=64), "for how many beats"] = 1\n',
        'Meta(ge=1, le=99), "for how many beats"] = 1\n    side: Annotated[int, "which foot"] = 0\n',
    )
    assert run(tree, "docs/generate.py", "--step", "longer dances")[::2] == (0, "")
    opened = "import sys, pathlib; from lbr.database.store import Database; Database.open(pathlib.Path(sys.argv[1]))"
    assert run(tree, "-c", opened, old) == (0, "", "")
    with closing(sqlite3.connect(old)) as after:
        assert after.execute("SELECT version_num FROM alembic_version").fetchall() == [(NEXT,)]
        assert after.execute("SELECT robot, dance, step, beats FROM choreography").fetchall() == steps
        after.execute("UPDATE choreography SET beats = 80, side = 1 WHERE step = 1")
        assert after.execute("SELECT count(*) FROM revision").fetchall() == [(1,)]


def schema(path: Path) -> list[tuple[str, str]]:
    with closing(sqlite3.connect(path)) as database:
        return database.execute("SELECT name, sql FROM sqlite_schema WHERE sql IS NOT NULL ORDER BY name").fetchall()
