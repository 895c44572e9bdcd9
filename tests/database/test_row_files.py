"""Rows as files: what is written is what is taken, and what cannot be taken is told with file, row and column."""

import json
import os
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.database import changes, row_files, sources
from lbr.database.reading import Problem
from lbr.database.row_files import File
from lbr.errors import InputError, RowError
from tests.support import databases

TABLES, SCHEMA = databases.tables()


def changed(table: str, rows: list) -> tuple[File, ...]:
    return (File(robot="lbr", table=table, text=json.dumps(rows)),)


def faults(file: File) -> tuple[str, ...]:
    with pytest.raises(RowError) as caught:
        row_files.applied((file,), TABLES, SCHEMA)
    return caught.value.problems


def test_what_is_written_is_what_is_taken_in_the_database_and_in_an_empty_one():
    files = row_files.written(TABLES, SCHEMA)
    assert changes.between(TABLES, row_files.applied(files, TABLES, SCHEMA), SCHEMA) == ()
    into_nothing = row_files.applied(files, dict.fromkeys(SCHEMA, ()), SCHEMA)
    assert changes.between(TABLES, into_nothing, SCHEMA) == ()
    assert row_files.written(into_nothing, SCHEMA) == files


TEXTS = st.text(st.characters(codec="utf-8", exclude_characters="\0"), max_size=12)
VALUES = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-(2**63), 2**63 - 1)
    | st.floats(allow_nan=False, allow_infinity=False)
    | TEXTS,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(TEXTS, inner, max_size=3),
    max_leaves=6,
)
HELD = TEXTS | VALUES.map(json.dumps) | st.sampled_from(['{"a": 1, "a": 2}', "[1e999]", "{cut", "[ 1,2 ]", '"x"'])
"""What a column of text may hold: JSON, what only looks like it, and any text."""


@given(
    st.lists(st.tuples(st.sampled_from("abcdef"), HELD, HELD, st.integers(0, 1)), unique_by=lambda row: row[0]),
    st.lists(st.tuples(TEXTS, TEXTS, TEXTS), unique_by=lambda row: row[:2]),
)
def test_any_rows_come_back_as_they_were(tmp_path_factory, capabilities, phrases):
    tables = {
        **dict.fromkeys(SCHEMA, ()),
        "robot": TABLES["robot"],
        "capability": [
            {**TABLES["capability"][0], "robot": "lbr", "name": name, "settings": of, "help": text, "enabled": on}
            for name, of, text, on in capabilities
        ],
        "phrase": [{"name": name, "language": language, "text": text} for name, language, text in phrases],
    }
    folder = tmp_path_factory.mktemp("rows")
    files = row_files.written(tables, SCHEMA)
    row_files.write(folder, files)
    read = row_files.read(folder)
    assert sorted(read, key=lambda file: file.name) == sorted(files, key=lambda file: file.name)
    assert changes.between(tables, row_files.applied(read, TABLES, SCHEMA), SCHEMA) == ()


def test_what_else_lies_in_a_folder_of_rows_is_left_out(tmp_path):
    files = row_files.written(TABLES, SCHEMA)
    row_files.write(tmp_path, files)
    (tmp_path / "README.md").write_text("Our robot.")
    (tmp_path / ".git").mkdir()
    (tmp_path / ".git" / "robot.json").write_text("{}")
    assert {file.name for file in row_files.read(tmp_path)} == {file.name for file in files}


def test_files_of_an_editor_that_marks_utf_8_and_ends_lines_its_own_way_are_read(tmp_path):
    files = row_files.written(TABLES, SCHEMA)
    row_files.write(tmp_path, files)
    for path in tmp_path.rglob("*.json"):
        path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes().replace(b"\n", b"\r\n"))
    assert changes.between(TABLES, row_files.applied(row_files.read(tmp_path), TABLES, SCHEMA), SCHEMA) == ()


@given(st.sampled_from(row_files.written(TABLES, SCHEMA)), st.data())
def test_a_file_that_is_cut_is_refused_with_its_name(file, data):
    cut = file.text[: data.draw(st.integers(0, max(0, len(file.text) - 3)))]
    (fault,) = faults(File(robot=file.robot, table=file.table, text=cut))
    assert fault.startswith(f"{file.name}, line ")
    assert "is it cut off?" in fault


@given(st.sampled_from(sorted(SCHEMA)), VALUES)
def test_any_json_is_rows_or_told_why_not(table, value):
    file = File(robot="lbr", table=table, text=json.dumps(value))
    if value != []:
        assert all(fault.startswith(f"lbr/{table}.json") for fault in faults(file))
    elif table != "phrase":
        row_files.applied((file,), TABLES, SCHEMA)


def test_rows_are_sorted_by_their_keys_and_json_stands_as_such():
    (file,) = [one for one in row_files.written(TABLES, SCHEMA, "lbr") if one.table == "capability"]
    rows = json.loads(file.text)
    assert [row["name"] for row in rows] == sorted(row["name"] for row in rows)
    assert isinstance(next(row for row in rows if row["name"] == "drive")["settings"], dict)
    assert all("robot" not in row for row in rows)


def test_what_lbr_itself_writes_and_other_robots_stay_out_of_it():
    files = row_files.written(TABLES, SCHEMA, "lbr")
    assert {file.robot for file in files} == {"lbr"}
    (row,) = json.loads(next(file.text for file in files if file.table == "robot"))
    assert set(row) == {"name", "model", "description", "owner"}


def test_a_table_without_a_file_stays_and_an_empty_one_is_emptied():
    after = row_files.applied(changed("channel", []), TABLES, SCHEMA)
    assert {change.table for change in changes.between(TABLES, after, SCHEMA)} == {"channel"}
    assert {change.robot for change in changes.between(TABLES, after, SCHEMA)} == {"lbr"}


def test_a_column_that_is_left_out_has_its_default_and_a_latch_stays():
    latched = {**TABLES, "robot": [{**row, "estop_engaged": 1} for row in TABLES["robot"]]}
    after = row_files.applied(changed("robot", [{"name": "lbr"}]), latched, SCHEMA)
    (row,) = [row for row in after["robot"] if row["name"] == "lbr"]
    assert (row["model"], row["estop_engaged"]) == ("", 1)


@pytest.mark.parametrize(
    "file",
    [
        File(robot="lbr", table="gone", text="[]"),
        File(robot="lbr", table="phrase", text="[]"),
        File(robot="_shared", table="motor", text="[]"),
        File(robot="lbr", table="device", text="{}"),
        File(robot="lbr", table="device", text="[1]"),
        File(robot="lbr", table="device", text='[{"name": 1, "name": 2}]'),
        File(robot="lbr", table="device", text='[{"name": NaN}]'),
        File(robot="lbr", table="device", text='[{"name": "d", "colour": 1}]'),
        File(robot="lbr", table="device", text='[{"name": "d"}]'),
        File(robot="lbr", table="robot", text='[{"name": "x"}]'),
    ],
)
def test_what_cannot_be_taken_is_told_with_file_row_and_column(file, wording):
    wording(*faults(file))


def test_a_row_that_is_there_twice_is_told():
    file = File(robot="_shared", table="phrase", text=json.dumps([{"name": "a", "language": "en", "text": "x"}] * 2))
    assert faults(file) == ("_shared/phrase.json, row 2 ('a/en'): is there twice",)


def test_a_problem_is_told_with_the_file_where_it_stands():
    assert row_files.place(Problem("capability", "lbr/drive", "settings", "is bad"), SCHEMA) == (
        "lbr/capability.json, 'drive', settings: is bad"
    )
    assert row_files.place(Problem("phrase", "a/en", "", "is bad"), SCHEMA) == "_shared/phrase.json, 'a/en': is bad"


def test_a_folder_without_rows_is_refused_in_words(tmp_path: Path, wording):
    with wording.of(InputError):
        row_files.read(tmp_path)
    with pytest.raises(InputError, match="cannot be read"):
        row_files.read(tmp_path / "gone")


@pytest.mark.parametrize("name", ["..", "../x", "a/b", "."])
def test_no_file_is_written_elsewhere(tmp_path: Path, name):
    with pytest.raises(InputError, match="would be no file"):
        row_files.write(tmp_path / "rows", (File(robot=name, table="device", text="[]"),))
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_cannot_be_written_is_told(tmp_path: Path):
    (tmp_path / "lbr").write_text("a file")
    with pytest.raises(InputError, match="cannot be written"):
        row_files.write(tmp_path, changed("device", []))


def test_a_pipe_among_the_files_is_refused_and_not_waited_for(tmp_path: Path):
    row_files.write(tmp_path, row_files.written(TABLES, SCHEMA, "lbr"))
    pipe = tmp_path / "lbr" / "device.json"
    pipe.unlink()
    os.mkfifo(pipe)
    with pytest.raises(InputError, match=r"device\.json is no file"):
        row_files.read(tmp_path)


@pytest.mark.parametrize("kind", ["pipe", "device"])
def test_a_source_of_rows_without_an_end_is_refused(tmp_path: Path, kind):
    source = tmp_path / "rows.sql"
    os.mkfifo(source) if kind == "pipe" else source.symlink_to("/dev/zero")
    with pytest.raises(InputError, match="no file"):
        sources.wanted(source, tmp_path / "robot.db")
