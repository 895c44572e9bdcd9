"""Changes of rows as forms make them: what comes of any change, as a pure function of the tables."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.database import forms
from lbr.database.proposals import propose
from lbr.database.reading import Problem
from lbr.database.rows import CORE, ChannelRow, DeviceRow
from lbr.errors import InputError
from lbr.messages.calibration import CalibrationValue
from lbr.messages.manage import RowChange


class Schema(dict):
    """Tables, and what tells their rows apart."""

    keys_of: dict[str, tuple[str, ...]]


SCHEMA = Schema(
    robot=("name", "model"),
    device=("robot", "name", "type", "address", "settings"),
    channel=("robot", "source", "target"),
)
SCHEMA.keys_of = {"robot": ("name",), "device": ("robot", "name"), "channel": ("robot", "source", "target")}
CLASSES = {row.TABLE: row for row in CORE}
TABLES = {
    "robot": [{"name": "lbr", "model": "a"}, {"name": "other", "model": "b"}],
    "device": [
        {"robot": "lbr", "name": "board", "type": "roboteq", "address": "/dev/a", "settings": '{"left_channel": 2}'},
        {"robot": "other", "name": "board", "type": "roboteq", "address": "/dev/b", "settings": "{}"},
    ],
    "channel": [],
}
BOARD = forms.json_row(DeviceRow, TABLES["device"][0])
JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text(max_size=8),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=8), inner, max_size=3),
    max_leaves=8,
)
VALUES = st.none() | st.dictionaries(st.sampled_from(["name", "type", "address", "settings", "source", "nonsense"]) | st.text(max_size=8), JSON, max_size=5)  # fmt: skip


def changed(*changes: RowChange) -> dict:
    return forms.changed(TABLES, SCHEMA, "lbr", changes, CLASSES)


def test_json_is_told_as_what_it_says_and_only_what_changes_is_written():
    assert BOARD["settings"] == {"left_channel": 2}
    after = changed(
        RowChange(table="device", before=BOARD, after={"address": "/dev/c", "settings": {"left_channel": 2}})
    )
    mine = next(one for one in after["device"] if one["robot"] == "lbr")
    assert mine == {**TABLES["device"][0], "address": "/dev/c"}
    assert TABLES["device"][1] in after["device"]


def test_another_robots_row_of_the_same_name_is_left_alone():
    after = changed(RowChange(table="device", before=BOARD, after=None))
    assert after["device"] == [TABLES["device"][1]]


def test_of_a_new_row_what_is_left_out_has_its_default():
    new = {"name": "second", "type": "roboteq", "address": "/dev/d"}
    after = changed(RowChange(table="device", after=new))
    assert {"robot": "lbr", **new, "settings": "{}"}.items() <= after["device"][-1].items()


@pytest.mark.parametrize(
    ("change", "code"),
    [
        (RowChange(table="device", before={**BOARD, "address": "/dev/z"}, after={"type": "x"}), "changed"),
        (RowChange(table="device", before={**BOARD, "name": "gone"}, after={"type": "x"}), "changed"),
        (RowChange(table="device", before=BOARD, after={"name": "renamed"}), "bad_value"),
        (RowChange(table="device", after=BOARD), "exists"),
        (RowChange(table="device"), "bad_value"),
        (RowChange(table="nothing", after={"name": "a"}), "unknown_name"),
        (RowChange(table="verb", after={"word": "a"}), "unknown_name"),
        (RowChange(table="robot", before={"name": "lbr"}, after=None), "denied"),
    ],
)
def test_what_may_not_be_changed_is_refused_with_its_code(change, code):
    with pytest.raises(InputError) as refused:
        changed(change)
    assert refused.value.code == code


def test_of_two_changes_of_one_row_the_second_sees_the_first():
    first = RowChange(table="device", before=BOARD, after={"address": "/dev/c"})
    with pytest.raises(InputError, match="changed meanwhile: address"):
        changed(first, first)


@given(st.lists(st.builds(RowChange, table=st.sampled_from(["device", "channel", "robot", "verb", "x"]), before=VALUES, after=VALUES), min_size=1, max_size=3))  # fmt: skip
def test_any_change_gives_tables_or_a_refusal_and_touches_no_other_robot(changes):
    try:
        after = changed(*changes)
    except InputError:
        return
    assert TABLES["device"][1] in after["device"]
    for row in after["device"] + after["channel"]:
        assert all(value is None or isinstance(value, str | int | float) for value in row.values())
    assert ChannelRow.TABLE in after


def test_what_refers_to_a_deleted_row_goes_with_it_and_bad_rows_are_mended_one_after_the_other(database, client):
    client.execute("INSERT INTO device (robot, name, type, address) VALUES ('lbr', 'spare', 'roboteq', '/dev/spare')")
    client.execute("INSERT INTO calibration (robot, device, name, value) VALUES ('lbr', 'spare', 'scale', 1.0)")
    tables, _ = database.tables()
    spare = forms.json_row(DeviceRow, next(row for row in tables["device"] if row["name"] == "spare"))
    bad = Problem("capability", "lbr/drive", "settings", "was bad before")
    wanted = forms.wanted("lbr", [RowChange(table="device", before=spare)], CLASSES)
    tried = propose(database, wanted, lambda _rows: [bad], robot="lbr", dry_run=True)
    assert (len(tried.changes), tried.revision, tried.problems) == (1, database.revision(), ())
    assert propose(database, wanted, lambda _rows: [bad], robot="lbr").revision == tried.revision + 2
    assert not [row for row in database.tables()[0]["calibration"] if row["device"] == "spare"]


def test_a_change_is_taken_back_with_the_rows_that_went_with_it(database, client):
    client.execute("INSERT INTO device (robot, name, type, address) VALUES ('lbr', 'spare', 'roboteq', '/dev/spare')")
    client.execute("INSERT INTO calibration (robot, device, name, value) VALUES ('lbr', 'spare', 'scale', 1.0)")
    tables, _ = database.tables()
    spare = forms.json_row(DeviceRow, next(row for row in tables["device"] if row["name"] == "spare"))
    classes = {**CLASSES, CalibrationValue.TABLE: CalibrationValue}
    taken_out = forms.wanted("lbr", [RowChange(table="device", before=spare)], classes)
    revision = propose(database, taken_out, lambda _rows: [], robot="lbr", by="ann").revision
    with pytest.raises(InputError, match="'bob'"):
        database.around(revision, "bob")
    back = forms.undoing(*database.around(revision, "ann"), classes)
    assert [one.table for one in back] == ["device", "calibration"]
    assert not propose(database, forms.wanted("lbr", back, classes), lambda _rows: [], robot="lbr").problems
    assert database.tables()[0] == tables


def test_only_the_columns_that_a_change_wrote_are_taken_back():
    after = changed(RowChange(table="device", before=BOARD, after={"address": "/dev/c"}))
    (back,) = forms.undoing(TABLES, after, SCHEMA, CLASSES)
    assert back.before == {"name": "board", "address": "/dev/c"}
    assert back.after == {"name": "board", "address": "/dev/a"}
