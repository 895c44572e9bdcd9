"""`lbr behaviour`: tables from files and back, checked; without a robot that runs."""

from pathlib import Path

import pytest

from lbr.apps.behaviours import files
from lbr.cli import main
from tests.docs.pages import ROOT, blocks
from tests.support import databases

PATROL = (
    "Type,Current State,Forward,O:level,O:range,Next State\nstart,Go,> 90,0.3,70,Home\nend,Home,,,,\nfail,Stuck,,,,\n"
)
EXAMPLES = Path("docs/examples/behaviours")


@pytest.fixture
def home(tmp_path, monkeypatch):
    """A home with the shipped rows."""
    monkeypatch.setenv("LBR_HOME", str(tmp_path / "h"))
    (tmp_path / "h").mkdir(mode=0o700)
    databases.fresh(tmp_path / "h" / "robot.db")
    return tmp_path


def table(folder: Path, text: str = PATROL, name: str = "mine.csv") -> str:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return str(path)


def test_a_file_is_checked_taken_written_and_taken_again(home, capsys):
    path = table(home)
    assert main(["behaviour", "check", path]) == 0
    assert main(["behaviour", "import", path, "--help-text", "mine", "--max", "60"]) == 0
    assert main(["behaviour", "check", "mine"]) == 0
    for kind, name in (("--csv", "out.csv"), ("--json", "out.json")):
        assert main(["behaviour", "export", "mine", kind, "--to", str(home / name)]) == 0
        assert main(["behaviour", "import", str(home / name), "--name", f"of_{kind[2:]}"]) == 0
    assert main(["behaviour", "show", "of_json"]) == 0
    assert "├" in (said := capsys.readouterr().out) or "└─ Forward > 90" in said
    assert main(["behaviour", "list"]) == 0
    assert "mine" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("file", "name"), [("Vòng quanh.csv", "vong_quanh"), ("دورة.csv", "table"), ("2 Türen.csv", "table_2_turen")]
)
def test_a_table_is_named_after_its_file_in_any_script(home, capsys, file, name):
    assert main(["behaviour", "import", table(home, name=file)]) == 0
    assert f"took '{name}'" in capsys.readouterr().out


def test_a_table_that_is_there_is_replaced_only_if_that_is_said(home, capsys, wording):
    path = table(home)
    assert main(["behaviour", "import", path]) == 0
    assert main(["behaviour", "import", path]) == 2
    wording(capsys.readouterr().err)
    assert main(["behaviour", "import", table(home, PATROL.replace("fail,Stuck,,,,\n", "")), "--replace"]) == 0
    assert main(["behaviour", "export", "mine"]) == 0
    assert "Stuck" not in capsys.readouterr().out, "rows that are not in the file any more are gone"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (
            PATROL.replace("Forward", "Forwrd"),
            "mine.csv, line 2, Forwrd: there is no 'Forwrd' in the telemetry; did you mean 'Forward'?",
        ),
        (PATROL.replace("70", "7000"), "mine.csv, line 2, O:range: Expected `float` <= 769.0"),
        ("", "Current State: this column is missing"),
    ],
)
def test_a_faulty_file_is_refused_with_line_and_column_and_nothing_is_written(home, capsys, text, said):
    path = table(home, text)
    for command in ("check", "import"):
        assert main(["behaviour", command, path]) == 2
        assert said in capsys.readouterr().err
    assert main(["behaviour", "show", "mine"]) == 2
    assert "has no behaviour 'mine'" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        (
            "round.csv",
            "Type,Current State,Forward,O:level,Next State,Deadline\nstart,A,> ninety,0.3,B,-1\n,A,,9,B,\nfine,A,far,,B,5\n",
            ["line 2, Deadline:", "line 2, Forward:", "line 3, O:level:", "line 4, Type:", "line 4, Forward:"],
        ),
        (
            "round.json",
            '{"A": [{"Inputs": {"Forward": [1], "Left": "> ninety"}}, {"Inputs": {"Forward": "far"}}]}',
            ["state 'A', row 1, Forward:", "row 1, Left:", "row 2, Forward:"],
        ),
    ],
)
def test_a_cell_that_no_table_can_have_hides_no_fault_of_another(home, capsys, name, text, said):
    assert main(["behaviour", "check", table(home, text, name)]) == 2
    told = [line.partition(f"{name}, ")[2] for line in capsys.readouterr().err.splitlines()]
    assert [one for one in said if not any(line.startswith(one) for line in told)] == []
    assert len(told) == len(said), told


def test_a_picture_is_drawn(home):
    assert main(["behaviour", "show", "patrol", "--svg", "--to", str(home / "patrol.svg")]) == 0
    assert (home / "patrol.svg").read_text().startswith("<svg")


def test_the_columns_are_listed(capsys):
    assert main(["behaviour", "columns"]) == 0
    assert "ranges.forward_m" in (said := capsys.readouterr().out)
    assert "O:level" in said


@pytest.mark.parametrize("robot", ["lbr", "bioloid", "uxa90"])
def test_the_shipped_behaviours_have_no_faults_and_are_those_in_the_examples(home, capsys, robot):
    folder = EXAMPLES if robot == "lbr" else EXAMPLES / robot
    assert main(["behaviour", "list", "--robot", robot]) == 0
    assert "✗" not in capsys.readouterr().out
    rows, _ = databases.tables()
    names = {row["name"] for row in rows["behaviour"] if row["robot"] == robot}
    assert names == {path.stem for path in folder.glob("*.csv")}
    for name in sorted(names):
        assert main(["behaviour", "export", name, "--json", "--robot", robot]) == 0
        written = files.read(capsys.readouterr().out.encode(), name, json=True)
        assert written.rows == files.read((folder / f"{name}.csv").read_bytes(), name, json=False).rows, name


def test_a_file_may_be_checked_where_there_is_no_robot(tmp_path, monkeypatch):
    monkeypatch.setenv("LBR_HOME", str(tmp_path / "nothing"))
    assert main(["behaviour", "check", table(tmp_path)]) == 0


def test_the_tables_of_the_page_are_good(home, capsys):
    first, mended = [one for one in blocks(ROOT / "docs" / "behaviours.md") if one.language == "csv"]
    for block, rows in ((first, 5), (mended, 7)):
        path = table(home, block.text, "round.csv")
        assert main(["behaviour", "check", path]) == 0
        assert main(["behaviour", "import", path, "--replace"]) == 0
        assert f"{rows} rows" in capsys.readouterr().out
