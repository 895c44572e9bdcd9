"""Benchmarks run by their names, all in the same way, and what the pages say of them is so."""

import re
import sys
from pathlib import Path

import msgspec
import pytest

from tests.support import programs
from tests.support.figures import Report

pytestmark = pytest.mark.timeout(40)

ROOT = Path(__file__).parents[2]
NAMES = sorted(path.stem for path in (ROOT / "benchmarks").glob("[a-z]*.py"))
PAGES = [
    ROOT / "README.md",
    ROOT / "CONTRIBUTING.md",
    ROOT / "benchmarks" / "README.md",
    *(ROOT / "docs").rglob("*.md"),
]


def benchmarks(*words):
    argv = [sys.executable, "-m", *words]
    return programs.run(argv, cwd=ROOT, capture_output=True, text=True, check=False, timeout=30)


def test_without_a_name_it_says_what_there_is():
    done = benchmarks("benchmarks")
    assert done.returncode == 0, done.stderr
    assert [line.split()[0] for line in done.stdout.splitlines()] == NAMES


def test_a_smoke_run_comes_to_its_end_and_leaves_a_report(tmp_path):
    file = tmp_path / "report.json"
    done = benchmarks("benchmarks", "turning", "--smoke", "--json", str(file))
    assert done.returncode == 0, done.stderr
    report = msgspec.json.decode(file.read_bytes(), type=Report)
    assert {result.figure for result in report.results} >= {"T1", "T2", "T3"}
    assert "|T1|" in done.stdout


@pytest.mark.parametrize("words", [("benchmarks", "nothing"), ("benchmarks.turning", "--n", "1")])
def test_what_is_no_name_measures_nothing_and_says_so(words):
    done = benchmarks(*words)
    assert done.returncode != 0
    assert "benchmark" in done.stderr
    assert not done.stdout


def test_pages_name_benchmarks_that_there_are():
    said = {name for page in PAGES for name in re.findall(r"-m benchmarks (\w+)", page.read_text())}
    assert said
    assert said <= set(NAMES)


def test_what_the_readme_says_needs_more_is_there():
    table = re.findall(r"^\| (`.*?) \|", (ROOT / "benchmarks" / "README.md").read_text(), re.MULTILINE)
    assert table
    assert {name for cell in table for name in re.findall(r"`(\w+)`", cell)} <= set(NAMES)
