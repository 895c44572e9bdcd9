"""What was edited, as people are told of it: by table and key, whatever tables there are."""

from hypothesis import given
from hypothesis import strategies as st

from lbr.database.rows import RevisionRow
from lbr.executive.planning.watch import edited


def row(table, *key, operation="update", number=1):
    return RevisionRow(
        id=number,
        table=table,
        row_key=key,
        operation=operation,
        before=None,
        after=None,
        changed_at="2026-01-01T00:00:00Z",
    )


def test_a_row_is_told_by_its_key_without_whose_it_is():
    assert edited([row("capability", "lbr", "drive")], "lbr") == ["update capability 'drive'"]
    assert edited([row("motor", "lbr", "api", "3", operation="insert")], "lbr") == ["insert motor 'api/3'"]
    assert edited([row("robot", "lbr")], "lbr") == ["update robot 'lbr'"]
    assert edited([row("phrase", "hello", "en")], "lbr") == ["update phrase 'hello/en'"]


def test_the_many_rows_of_one_thing_are_one_edit_in_any_table():
    numbers = [row("calibration", "lbr", "imu", f"bias_{axis}", operation="insert") for axis in "xyz"]
    frames = [row("my_steps", "lbr", "wave", str(n), operation=how) for n, how in enumerate(("insert", "delete"))]
    assert edited([*numbers, *frames], "lbr") == [
        "insert 3 rows of calibration 'imu'",
        "edit 2 rows of my_steps 'wave'",
    ]


def test_rows_that_have_only_a_name_are_told_each():
    rows = [row("capability", "lbr", name) for name in ("drive", "motors", "drive")]
    assert edited(rows, "lbr") == ["update capability 'drive'", "update capability 'motors'"]


def test_one_row_that_was_edited_twice_is_one_row():
    twice = [row("motor", "lbr", "api", "3"), row("motor", "lbr", "api", "3", number=2)]
    assert edited(twice, "lbr") == ["update motor 'api/3'"]


@given(
    st.lists(
        st.tuples(st.sampled_from("ab"), st.lists(st.text("xyz", min_size=1), min_size=1, max_size=3)), max_size=12
    )
)
def test_each_table_that_was_edited_is_named_whatever_its_keys(found):
    told = " ".join(edited([row(table, *key) for table, key in found], "x"))
    assert all(f"update {table} '" in told or f"rows of {table} '" in told for table, _ in found)
