"""State tables: read from files and written to them, and all that is wrong with one named with row and column."""

import csv
import io
import json
import re
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.apps.behaviours import drawing, files, outputs, texts
from lbr.apps.behaviours.table import Parts, compile_table, linked
from lbr.messages.behaviour import BehaviourRow, BehaviourState, BehaviourTable

TABLES = Path(__file__).with_name("tables")
PATROL = """Type,Current State,Forward,Run Time,O:level,O:range,O:turn,O:speech,Next State,Deadline
start,Deciding,,>= 300,,,,,Home,
,Deciding,> 90,,0.3,70,,,Deciding,60
,Deciding,,,,,90,,Deciding,
# a comment,that says nothing,,,,,,,,
end,Home,,,0,,,"Good, that was it",,
fail,Stuck,,,0,,,,,
"""
T = BehaviourTable(name="t")


def read(text: str | bytes, *, json: bool = False) -> files.Read:
    return files.read(text.encode() if isinstance(text, str) else text, "t", json=json)


def rows(text: str) -> tuple[BehaviourRow, ...]:
    found = read(text)
    assert found.faults == ()
    return found.rows


def faults(text: str, robot: Parts | None = None) -> list[str]:
    compiled = compile_table(T, rows(text), robot or Parts())
    return [texts.fault(one) for one in compiled.errors]


def table(*lines: str) -> str:
    header = "Type,Current State,Forward,level,heading,Time,$laps,O:level,O:angle,O:range,O:sensor,O:turn,O:heading,O:run,O:set,O:wait,Next State,Deadline"
    columns = header.split(",")
    file = io.StringIO()
    writer = csv.DictWriter(file, columns, restval="")
    writer.writeheader()
    for line in lines:
        writer.writerow(dict(part.split("=", 1) for part in re.split(r"(?<! )\|(?! )", line)))
    return file.getvalue()


GOOD = ("Type=start|Current State=A|Next State=B", "Type=end|Current State=B", "Type=fail|Current State=C")


def test_a_table_is_read_with_the_line_of_each_row():
    found = read(PATROL)
    assert found.faults == ()
    assert [row.type for row in found.rows] == ["start", "", "", "#", "end", "fail"]
    assert found.lines == {1: 2, 2: 3, 3: 4, 4: 5, 5: 6, 6: 7}
    assert found.rows[1].conditions == {"Forward": "> 90"}
    assert found.rows[1].outputs == {"level": "0.3", "range": "70"}
    assert found.rows[1].deadline_s == 60.0
    assert found.rows[4].outputs["speech"] == "Good, that was it"


@pytest.mark.parametrize(
    "content",
    [
        PATROL.encode("utf-8-sig"),
        PATROL.encode("utf-16"),
        PATROL.replace("\n", "\r\n").encode(),
        ("sep=;\r\n" + files.to_csv(read(PATROL).rows, ";")).encode("utf-8-sig"),
        files.to_csv(read(PATROL).rows, ";").encode(),
        files.to_csv(read(PATROL).rows, "\t").encode(),
    ],
)
def test_a_table_is_read_as_spreadsheets_write_it(content):
    found = read(content)
    assert found.faults == ()
    assert found.rows == read(PATROL).rows


def test_with_semicolons_a_comma_is_a_decimal_one():
    found = read("Type;Current State;Forward;O:level;O:speech;Next State\nstart;A;0,5:1,5;0,25;Ja, 1,5;B\n")
    assert found.rows[0].conditions == {"Forward": "0.5:1.5"}
    assert found.rows[0].outputs == {"level": "0.25", "speech": "Ja, 1,5"}


def test_the_decimal_mark_is_one_of_a_file():
    found = read((TABLES / "thousands_in_decimal_comma_file.csv").read_bytes())
    assert [(fault.line, fault.column) for fault in found.faults] == [(2, "Run Time")]
    assert found.rows[1].outputs["level"] == "0.3"
    points = read("Type;Current State;Forward;Next State\nstart;A;0.5:1.5;B\n")
    assert (points.faults, points.rows[0].conditions) == ((), {"Forward": "0.5:1.5"})
    quoted = read('Type;Current State;Forward;Word;Next State\nstart;A;< 0,5;"""v1.2,3""";B\n')
    assert (quoted.faults, quoted.rows[0].conditions) == ((), {"Forward": "< 0.5", "Word": '"v1.2,3"'})


def test_with_semicolons_numbers_are_written_with_commas():
    rows = read(
        "Type,Current State,Forward,O:level,O:speech,Next State,Deadline\nstart,A,< 0.5,0.25,Version 1.5,B,2.5\n"
    ).rows
    text = files.to_csv(rows, ";")
    assert text.splitlines()[1] == "start;A;< 0,5;0,25;Version 1.5;B;2,5"
    assert read(text).rows == rows


@pytest.mark.parametrize("name", ["header_in_other_case.csv", "nbsp_in_header.csv"])
def test_a_header_is_taken_as_people_and_programs_write_it(name):
    found = read((TABLES / name).read_bytes())
    assert (found.faults, len(found.rows)) == ((), 5)
    assert (found.rows[0].type, found.rows[0].state, found.rows[0].next_state) == ("start", "Deciding", "Home")


def test_western_letters_without_a_mark_are_read():
    assert read("Type,Current State,Forward,Next State\nstart,A,40 ± 1,B\n".encode("cp1252")).rows[0].conditions == {
        "Forward": "40 ± 1"
    }


@pytest.mark.parametrize(
    "text",
    [
        "",
        "a,b,c\n1,2,3\n",
        "Current State,Next State,x:y\nA,B,1\n",
        "Current State,Next State,Next State\nA,B,1\n",
        "Type,Current State,Next State\nbegin,A,B\n",
        "Type,Current State,Next State\n\nstart,A,B,extra\n",
        'Type,Current State,Next State\nstart,"A,B\n',
        "Type,Current State,Next State,Deadline\nstart,A,B,soon\n",
        "Type,Current State,Next State\nstart," + "A" * 81 + ",B\n",
        b"PK\x03\x04 a spreadsheet",
        b"a\0b",
    ],
)
def test_a_bad_file_is_told_with_line_and_column(text, wording):
    wording(*map(str, read(text).faults))


def test_json_is_written_and_read_again():
    found = read(PATROL)
    assert read(files.to_json(found.rows), json=True).rows == found.rows


def test_json_as_the_first_lbr_wrote_it_is_read():
    """Without types: the first state starts, and a state that leads nowhere else is an end."""
    old = {
        "Go": [
            {"Current State": "Go", "Next State": "Docked", "Inputs": {"Forward": "< 40"}, "Outputs": {"level": 0.2}}
        ],
        "Docked": [{"Current State": "Docked", "Next State": "Docked", "Inputs": {}, "Outputs": {}}],
        "Failed": [{"Current State": "Failed", "Next State": "Failed", "Inputs": {"Volts": "<= 12.7"}, "Outputs": {}}],
    }
    found = read(json.dumps(old), json=True)
    assert [row.type for row in found.rows] == ["start", "end", "end"]
    assert found.rows[0].outputs == {"level": "0.2"}
    made = compile_table(T, found.rows).table
    assert made is not None
    assert made.failure == "Failed"


@pytest.mark.parametrize(
    "text",
    [
        "[",
        "3",
        '{"A": 3}',
        '{"A": [3]}',
        '{"A": [{"Inputs": 3}]}',
        '{"A": [{"Inputs": {"Forward": [1]}}]}',
        '{"A": [{"Inputs": {"Forward": 1e300}}]}',
        '{"A": [{"Input": {}}]}',
    ],
)
def test_bad_json_is_told_with_its_place(text, wording):
    wording(*map(str, read(text, json=True).faults))


def test_json_that_is_nested_deeper_than_python_reads_is_a_fault():
    assert read("[" * 100_000, json=True).faults


@given(st.binary(max_size=300) | st.text(max_size=300).map(str.encode), st.booleans())
def test_no_bytes_are_more_than_a_bad_file(content, as_json):
    found = files.read(content, "t", json=as_json)
    assert all(isinstance(str(fault), str) for fault in found.faults)


cell = st.sampled_from(
    ["", "< 40", "85:100", "true", "low", "§$%", "40 ± 1", "0.2", "-5", "|", "$x", "x = 1", "other", "nan"]
) | st.text(max_size=8)
names = st.sampled_from(["A", "B", "C", "", "Ende"])
a_row = st.builds(
    lambda step, kind, state, conditions, outputs, following: BehaviourRow(
        behaviour="t", step=step, type=kind, state=state, conditions=conditions, outputs=outputs, next_state=following
    ),
    st.integers(1, 50),
    st.sampled_from(["", "start", "end", "fail", "entry", "#"]),
    names,
    st.dictionaries(
        st.sampled_from(["Forward", "heading", "level", "Time", "$x", "nonsense", "charging", ""]), cell, max_size=4
    ),
    st.dictionaries(
        st.sampled_from(
            [
                *"abc",
                "level",
                "range",
                "sensor",
                "turn",
                "set",
                "run",
                "motion",
                "wait",
                "speech",
                "duration",
                "retry",
                "times",
            ]
        ),
        cell,
        max_size=4,
    ),
    names,
)


@given(st.lists(a_row, max_size=12))
def test_no_table_is_more_than_a_faulty_one(some):
    compiled = linked({"t": compile_table(T, some, Parts(sensors=frozenset({"forward"})))})["t"]
    assert all(texts.fault(one) for one in compiled.faults)
    assert (compiled.table is None) == bool(compiled.errors)
    assert texts.graph(T, some)
    assert drawing.svg(T, some).startswith("<svg")
    texts.listed({"t": T}, {"t": compiled}, BehaviourState(phase="resting"))


@given(st.lists(a_row, max_size=8))
def test_what_is_written_is_read_again_or_refused(some):
    for content, as_json in ((files.to_csv(some).encode(), False), (files.to_json(some), True)):
        files.read(content, "t", json=as_json)


def test_a_good_table_has_no_faults():
    assert faults(PATROL) == []
    assert faults(table(*GOOD)) == []


@pytest.mark.parametrize(
    "lines",
    [
        GOOD[1:],
        (*GOOD, "Type=start|Current State=D|Next State=B"),
        GOOD[:1],
        (GOOD[0].replace("B", "b"), *GOOD[1:]),
        (*GOOD, "Current State=D|Next State=B"),
        ("Type=start|Current State=A", *GOOD[1:]),
        (*GOOD, "Current State=B|Next State=A"),
        ("Type=start|Current State=A|Forward=low|Next State=B", *GOOD[1:]),
        ("Type=start|Current State=A|level=lo|Next State=B", *GOOD[1:]),
        ("Type=start|Current State=A|Time=< 0|Next State=B", *GOOD[1:]),
        ("Type=start|Current State=A|Forward=> 5 and < 3|Next State=B", *GOOD[1:]),
        ("Type=start|Current State=A|Forward=40 -1|Next State=B", *GOOD[1:]),
        ("Type=start|Current State=A|$laps=> 1|Next State=B", *GOOD[1:]),
        (GOOD[0] + "|O:level=2", *GOOD[1:]),
        (GOOD[0] + "|O:level=$fast", *GOOD[1:]),
        (GOOD[0] + "|O:level=0.2|O:turn=90", *GOOD[1:]),
        (GOOD[0] + "|O:range=40", *GOOD[1:]),
        (GOOD[0] + "|O:level=0.2|O:sensor=Forward", *GOOD[1:]),
        (GOOD[0] + "|O:level=0.2|O:range=40|O:sensor=nose", *GOOD[1:]),
        (GOOD[0] + "|O:turn=90 | 400", *GOOD[1:]),
        (GOOD[0] + "|O:set=laps", *GOOD[1:]),
        (GOOD[0] + "|O:wait=-1", *GOOD[1:]),
        (GOOD[0] + "|Deadline=60|O:level=x", *GOOD[1:]),
    ],
)
def test_a_fault_is_told_with_row_and_column(lines, wording):
    wording(*faults(table(*lines), Parts(sensors=frozenset({"forward", "back"}))))


def test_a_motion_that_cannot_be_a_name_is_told_in_words(wording):
    ((output, told),) = outputs.faults({"motion": "wave | Wave", "times": "2"})
    assert output == "motion"
    wording(told)


def test_an_output_that_no_command_takes_is_named():
    assert any(
        "did you mean O:level?" in one
        for one in faults(table(*GOOD).replace("O:level", "O:levl").replace("end,B,,,,,,,", "end,B,,,,,,0.2,"))
    )


@pytest.mark.parametrize(
    ("earlier", "later", "shadowed"),
    [
        ("Forward=< 50", "Forward=<50", True),
        ("Forward=< 40", "Forward=< 50", False),
        ("Forward=< 50", "Forward=< 50|Time=> 2", True),
        ("Forward=< 50|Time=> 2", "Forward=< 50", False),
        ("Forward=< 50 for 2 s", "Forward=< 50", False),
        ("O:turn=90", "Forward=< 40", True),
        ("heading=330:30", "heading=20:40", False),
    ],
)
def test_a_row_that_an_earlier_one_always_takes_is_named(earlier, later, shadowed):
    told = faults(
        table(f"Type=start|Current State=A|Next State=A|{earlier}", f"Current State=A|Next State=B|{later}", *GOOD[1:])
    )
    assert any("row 2, Current State: this row is never taken" in one for one in told) is shadowed, told


def test_an_output_that_nothing_carries_out_is_named():
    told = faults(table(GOOD[0] + "|O:turn=90", *GOOD[1:]), Parts(asks=frozenset({"say"})))
    assert told == ["row 1, O:turn: this robot has no drive that runs"]


def test_tables_that_run_themselves_or_what_is_not_there_are_named():
    def of(name: str, called: str):
        some = rows(table(GOOD[0] + f"|O:run={called}", *GOOD[1:]))
        return compile_table(BehaviourTable(name=name), some)

    found = linked({"a": of("a", "b"), "b": of("b", "a"), "c": of("c", "nowhere"), "d": of("d", "c")})
    told = {name: texts.faults(name, one.errors) for name, one in found.items()}
    assert "'b' runs 'a' again" in told["a"]
    assert "there is no table 'nowhere'" in told["c"]
    assert "'c' has errors of its own" in told["d"]


def test_the_tables_in_the_examples_have_no_faults():
    folder = Path("docs/examples/behaviours")
    compiled = {
        path.stem: compile_table(
            BehaviourTable(name=path.stem), files.read(path.read_bytes(), path.stem, json=False).rows
        )
        for path in sorted(folder.glob("*.csv"))
    }
    assert len(compiled) >= 9
    assert {name: one.errors for name, one in linked(compiled).items() if one.errors} == {}


def test_a_graph_says_where_the_robot_is():
    text = texts.graph(T, rows(PATROL), "Deciding")
    assert "● Deciding  ◀ the robot is here" in text
    assert "├─ Forward > 90 [level 0.3, range 70] ─▶ Deciding (within 60 s)" in text
    assert "◎ Home" in text
    assert "✗ Stuck" in text


VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.text(max_size=3),
    lambda inner: st.lists(inner, max_size=2) | st.dictionaries(st.text(max_size=3), inner, max_size=2),
    max_leaves=4,
)
FIELDS = st.sampled_from(("Row", "Type", "Current State", "Next State", "Deadline", "Inputs", "Outputs", "Other"))
JSON_ROWS = st.lists(st.dictionaries(FIELDS, VALUES, max_size=4) | VALUES, max_size=3)


@given(JSON_ROWS | st.dictionaries(st.text(max_size=3), JSON_ROWS | VALUES, max_size=3))
def test_no_json_is_more_than_a_bad_file(found):
    read(json.dumps(found), json=True)


def test_a_value_of_another_kind_is_told_with_its_place():
    text = json.dumps({"A": [{"Next State": "B"}], "B": [{"Next State": ["A"]}]})
    assert "state 'B', row 1, Next State" in str(read(text, json=True).faults[0])


@pytest.mark.parametrize("wrong", ["x = 1e999", "x = -inf", "x = nan"])
def test_a_variable_is_no_number_that_cannot_be_reckoned_with(wrong, wording):
    text = table(f"Type=start|Current State=A|O:set={wrong}|Next State=B", *GOOD[1:])
    wording(*faults(text))


def test_a_cell_is_one_of_so_many_at_most():
    text = table(f"Type=start|Current State=A|O:turn={' | '.join('9' * 21)}|Next State=B", *GOOD[1:])
    assert any("one of 21, and 20 are the most" in one for one in faults(text))


def test_of_a_table_with_many_faults_the_first_are_told(wording):
    many = tuple(
        BehaviourRow(behaviour="t", step=step, state="A", next_state="A", conditions={f"nothing{step}": "1"})
        for step in range(1, 200)
    )
    compiled = compile_table(T, many)
    assert compiled.table is None
    assert len(compiled.faults) == 51
    wording(compiled.faults[-1].text)
