"""An edit of rows that a page has its reader type changes one robot, whichever others are in the database."""

import re
import sqlite3
from contextlib import closing

import pytest

from tests.docs.pages import PAGES, ROOT
from tests.support import databases

EDIT = re.compile(r"(?:UPDATE (\w+) SET [^`\n]*?|DELETE FROM (\w+)) WHERE ([^`\";\n]+)")
EDITS = [
    pytest.param(updated or deleted_from, where, id=f"{page.relative_to(ROOT)}: {where}")
    for page in PAGES
    for updated, deleted_from, where in EDIT.findall(page.read_text())
]


@pytest.fixture(scope="module")
def rows(tmp_path_factory):
    with closing(sqlite3.connect(databases.fresh(tmp_path_factory.mktemp("rows") / "robot.db"))) as found:
        yield found


@pytest.mark.parametrize(("table", "where"), EDITS)
def test_an_edit_is_of_one_robot(rows, table, where):
    if table != "robot":
        (robots,) = rows.execute(f"SELECT count(DISTINCT robot) FROM {table} WHERE {where}").fetchone()
        assert robots <= 1


def test_there_are_edits_to_look_at():
    assert len(EDITS) > 20
