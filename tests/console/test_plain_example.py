"""The plain Zenoh client of the documentation, where it cannot reach a robot: one sentence, no traceback."""

import json
import os
import sys
from pathlib import Path

import pytest

from tests.support import programs
from tests.support.waiting import HANG_S

SCRIPT = Path(__file__).parents[2] / "docs" / "examples" / "drive_with_plain_zenoh.py"


def run(home: Path, *arguments: str) -> str:
    done = programs.run(
        [sys.executable, str(SCRIPT), *arguments],
        env=os.environ | {"LBR_HOME": str(home)},
        capture_output=True,
        text=True,
        timeout=HANG_S,
        check=False,
    )
    assert done.returncode == 1
    assert len(done.stderr.splitlines()) == 1
    return done.stderr


@pytest.mark.parametrize("endpoint", ["nonsense", "tcp/127.0.0.1:1", ""])
def test_a_wrong_endpoint_is_one_sentence(tmp_path, endpoint):
    assert run(tmp_path, endpoint).startswith(f"no robot can be reached at '{endpoint}'")


def test_without_an_endpoint_the_robot_of_this_machine_is_meant(tmp_path):
    assert run(tmp_path).startswith("no robot runs here")
    (tmp_path / "run").mkdir()
    for name, pid in (("gone", 2**22 + 1), ("here", os.getpid())):
        record = {"robot": name, "pid": pid, "endpoints": [f"unixsock-stream//nowhere/{name}"]}
        (tmp_path / "run" / f"{name}.json").write_text(json.dumps(record))
    assert run(tmp_path).startswith("no robot can be reached at 'unixsock-stream//nowhere/here'")
