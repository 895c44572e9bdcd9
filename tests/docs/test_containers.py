"""The image of a container gets all that lbr needs to be installed, and what is said of it is so."""

import re
import shlex
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
FILE = (ROOT / "Containerfile").read_text()
LET_IN = {line[1:] for line in (ROOT / ".containerignore").read_text().splitlines() if line.startswith("!")}
COPIED = [source for line in re.findall(r"^COPY (?!--from)(.+)$", FILE, re.MULTILINE) for source in line.split()[:-1]]


@pytest.mark.parametrize("source", COPIED)
def test_what_is_copied_is_there_and_is_let_in(source):
    assert (ROOT / source).exists()
    assert source in LET_IN


def test_what_the_project_is_built_from_is_copied():
    named = re.findall(r'^(?:readme|license-files) = \[?"([^"]+)"', (ROOT / "pyproject.toml").read_text(), re.MULTILINE)
    shipped = re.findall(r'^"([^"]+)" = "(?:lbr/_shipped|share)/', (ROOT / "pyproject.toml").read_text(), re.MULTILINE)
    assert {*named, *shipped, "lbr", "pyproject.toml"} <= set(COPIED)


def test_it_runs_as_a_user_of_its_own_what_lbr_understands():
    assert re.search(r"^USER lbr$", FILE, re.MULTILINE)
    command = shlex.split(re.sub(r"[\[\],]", " ", re.findall(r"^CMD (.+)$", FILE, re.MULTILINE)[-1]))
    assert command == ["run", "lbr-sim", "--no-console"]
    assert "\t" not in (ROOT / "docs" / "examples" / "raspberry-pi" / "user-data").read_text()
