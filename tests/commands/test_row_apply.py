"""What `lbr db plan`, `apply`, `export` and `import` do with files, folders and copies."""

import json
import shutil
import sqlite3
from contextlib import closing

import pytest

from tests.support import databases
from tests.support.commands import db
from tests.support.databases import asked

POWER = (
    "UPDATE capability SET settings = json_set(settings, '$.max_power', 0.5) WHERE robot = 'lbr' AND name = 'drive';"
)


@pytest.fixture
def sql(tmp_path):
    def written(script: str) -> str:
        (tmp_path / "edit.sql").write_text(script)
        return str(tmp_path / "edit.sql")

    return written


def refusal(*words: str) -> str:
    return str(db(*words).exception)


def test_plan_tells_rows_and_processes_and_touches_nothing(path, sql, wording):
    done = db("plan", sql(POWER))
    assert done.return_value == 0
    rows, robot, last = done.stdout.splitlines()
    assert rows.startswith("capability 'lbr/drive' changed: settings: ")
    assert robot == "lbr, at its next start: restart drive"
    wording(last)
    assert asked(path, "SELECT count(*) FROM revision") == [(0,)]


def test_plan_tells_problems_and_ends_with_2(path, sql):
    done = db("plan", sql("UPDATE capability SET kind = 'no_such' WHERE robot = 'lbr' AND name = 'drive'"))
    assert done.return_value == 2
    assert "problem: capability 'lbr/drive', kind: " in done.stderr


def test_apply_writes_all_in_one_change_that_says_who_and_from_what(path, sql):
    done = db("apply", sql(POWER + "UPDATE robot SET owner = 'me' WHERE name = 'lbr';"), "--json")
    said = json.loads(done.stdout)
    assert (said["written"], said["before"], said["revision"]) == (True, 0, 2)
    assert said["touched"] == [
        {"robot": "lbr", "runs": False, "start": [], "stop": [], "restart": ["drive"], "tell": []}
    ]
    (change,) = json.loads(db("history", "--json").stdout)
    assert (change["first"], change["last"], change["program"], change["text"]) == (
        1,
        2,
        "lbr db apply",
        "applied edit.sql",
    )


@pytest.mark.parametrize(
    "script",
    [
        "DROP TABLE channel",
        "\nDELETE FROM audit",
        "UPDATE user_token SET role = 'admin'",
        "UPDATE revision SET id = 4",
        "ATTACH '/tmp/x' AS x",
        "UPDATE channel SET rate_hz = -1",
        "BEGIN; DELETE FROM phrase;",
        "DELETE FROM phr",
        "\udcff",
        "DELETE FROM channel;\0",
        "PRAGMA foreign_keys = OFF; INSERT INTO channel (robot, source, target) VALUES ('none', 'a.b', 'c.d')",
        "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n) DELETE FROM phrase WHERE name IN (SELECT i FROM n)",
    ],
)
def test_sql_that_does_anything_else_is_refused_with_its_line(path, tmp_path, script, wording):
    (tmp_path / "edit.sql").write_text(script, errors="surrogateescape")
    wording(refusal("apply", str(tmp_path / "edit.sql")))
    assert asked(path, "SELECT count(*) FROM revision") == [(0,)]


def test_a_plan_is_refused_when_the_rows_were_changed_meanwhile(path, sql):
    asked(path, "UPDATE robot SET owner = 'other' WHERE name = 'lbr'")
    assert "have revision 1, not 0" in refusal("apply", sql(POWER), "--revision", "0")
    assert asked(path, "SELECT count(*) FROM revision") == [(1,)]


def test_a_copy_brings_its_rows_and_nothing_else(path, tmp_path, wording):
    copy = tmp_path / "copy.db"
    asked(path, f"VACUUM INTO '{copy}'")
    asked(path, POWER)
    assert "drive" in db("plan", str(copy)).stdout
    assert db("apply", str(copy)).return_value == 0
    assert db("diff", "0").stdout == "nothing differs\n"
    wording(db("apply", str(copy)).stdout)


def test_what_was_exported_is_imported_again(path, tmp_path, wording):
    folder = tmp_path / "rows"
    assert "wrote " in db("export", str(folder)).stdout
    asked(path, POWER)
    asked(path, "DELETE FROM phrase")
    done = db("import", str(folder))
    assert done.return_value == 0
    assert db("diff", "0").stdout == "nothing differs\n"
    wording(db("import", str(folder)).stdout)


def test_one_robot_alone_is_exported_and_comes_into_another_database(path, tmp_path):
    folder, other = tmp_path / "rows", tmp_path / "other.db"
    db("export", str(folder), "--robot", "uxa90")
    assert [one.name for one in folder.iterdir()] == ["uxa90"]
    databases.fresh(other)
    asked(other, "PRAGMA foreign_keys = ON; ")
    with closing(sqlite3.connect(other, isolation_level=None)) as client:
        client.execute("PRAGMA foreign_keys = ON")
        client.execute("DELETE FROM robot WHERE name = 'uxa90'")
    assert db("import", str(folder), "--db", str(other)).return_value == 0
    assert db("diff", "--db", str(other)).stdout == "the rows are as shipped\n"


def test_a_file_with_a_bad_row_is_refused_with_file_row_and_column(path, tmp_path):
    folder = tmp_path / "rows"
    db("export", str(folder))
    file = folder / "lbr" / "capability.json"
    rows = json.loads(file.read_text())
    next(row for row in rows if row["name"] == "drive")["settings"]["max_power"] = 7
    file.write_text(json.dumps(rows))
    done = db("import", str(folder))
    assert done.return_value == 2
    assert "problem: lbr/capability.json, 'drive', settings: " in done.stderr
    next(row for row in rows if row["name"] == "drive")["enabled"] = 7
    file.write_text(json.dumps(rows))
    assert db("import", str(folder)).return_value == 2
    shutil.rmtree(folder / "lbr")
    (folder / "lbr").mkdir()
    (folder / "lbr" / "channel.json").write_text('[{"source": "a.b"')
    assert "lbr/channel.json, line 1: is not JSON" in refusal("import", str(folder))
    assert asked(path, "SELECT count(*) FROM revision") == [(0,)]


def test_what_only_sqlite_refuses_is_told_with_its_row_also_in_a_dry_run(path, tmp_path):
    folder = tmp_path / "rows"
    db("export", str(folder), "--robot", "lbr")
    file = folder / "lbr" / "verb.json"
    rows = json.loads(file.read_text())
    rows[0]["help"] = 5
    file.write_text(json.dumps(rows))
    done = db("plan", str(folder))
    said = str(done.exception or done.stderr)
    assert "verb" in said
    assert "help" in said


def test_a_source_that_is_not_there_is_told(path, tmp_path):
    assert "cannot be read" in refusal("plan", str(tmp_path / "none.sql"))
    assert "has no rows in it" in refusal("plan", str(tmp_path / "home"))
