from pathlib import Path

import pytest

from tests.lab import __main__ as lab
from tests.lab import processor, robots, stage, table
from tests.lab.processor import PROCESSORS
from tests.lab.stage import Scene

REPORT = """<testsuites><testsuite>
<testcase classname="tests.bus.test_wire" name="test_a" time="1.5"/>
<testcase classname="tests.bus.test_wire" name="test_b" time="0.5"><failure message="not | so"/></testcase>
<testcase classname="tests.console.test_page" name="test_c" time="0"><skipped message="no browser"/></testcase>
<testcase classname="tests.console.test_page" name="test_d" time="0"><skipped message="no browser"/></testcase>
</testsuite></testsuites>"""


def test_each_part_of_the_tests_has_a_row_and_what_did_not_pass_says_why() -> None:
    rows = table.of_parts(REPORT).split("\n")
    assert "| tests.bus | 1 | 1 | 0 | 2 |" in rows
    assert "| tests.console | 0 | 0 | 2 | 0 |" in rows
    assert "| tests.bus.test_wire: b | **failed** | not / so | 1 |" in rows
    assert "| tests.console | skipped | no browser | 2 |" in rows


@pytest.mark.parametrize("name", PROCESSORS)
def test_a_machine_begins_as_the_processor_that_its_folder_was_made_for(name: str, tmp_path: Path) -> None:
    (tmp_path / processor.KEPT).write_text(name)
    kind = processor.of(tmp_path)
    assert kind is PROCESSORS[name]
    assert kind.command(tmp_path).startswith(f"{kind.qemu} ")
    assert (str(tmp_path / processor.TREE) in kind.command(tmp_path)) is (kind.gips > 1)


def test_what_came_of_the_last_runs_is_shown_for_the_processor_that_is_asked_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(lab, "FOLDER", tmp_path)
    (place := tmp_path / "trixie-arm64").mkdir()
    stage.keep(place / robots.KEPT, [Scene("waves", True, "played to its end")])
    (place / lab.OTHERS).write_text(REPORT)
    for arch, seen in (("arm64", True), ("amd64", False)):
        monkeypatch.setattr("sys.argv", ["lab", "table", "--suite", "trixie", "--arch", arch, "words"])
        assert lab.main() == 0
        said = capsys.readouterr().out
        assert ("| waves | passed | played to its end |" in said) is seen
        assert ("| tests.bus |" in said) is seen
