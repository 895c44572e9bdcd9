"""Pictures are drawn by a process of their own, and what goes wrong there is a sentence."""

import time
from pathlib import Path

import pytest

from lbr.operations.attitude import painter as painting
from lbr.operations.attitude.painter import Painter
from lbr.operations.attitude.picture import Drawing
from tests.support.robot import until

DRAWING = Drawing(title="a title", measured=[(1.0, 2.0), (3.0, 4.0)], corrected=[(0.0, 1.0)])


@pytest.fixture
def painter():
    under_test = Painter()
    yield under_test
    under_test.close()


@pytest.fixture
def instead(tmp_path, monkeypatch):
    """Put a program of our own in the place of the one that draws."""

    def put(source: str):
        (tmp_path / "draws_otherwise.py").write_text(source)
        monkeypatch.setenv("PYTHONPATH", str(tmp_path))
        monkeypatch.setattr(painting, "MODULE", "draws_otherwise")

    return put


def outcome(painter: Painter, path: Path, *, late: float = 0.0):
    assert painter.begin(DRAWING, path, time.monotonic()) == ""
    return until(lambda: painter.poll(time.monotonic() + late), limit_s=9.0, what="a picture")


@pytest.mark.slow_start
@pytest.mark.timeout(30)
def test_a_picture_is_drawn(painter, tmp_path):
    painter.begin(DRAWING, tmp_path / "mag.png", time.monotonic())
    drawn = until(lambda: painter.poll(time.monotonic()), limit_s=25.0, what="a picture")
    assert drawn.path == str(tmp_path / "mag.png")
    assert (tmp_path / "mag.png").read_bytes().startswith(b"\x89PNG")
    assert painter.poll(time.monotonic()) is None


@pytest.mark.parametrize(
    ("source", "words"),
    [
        ("raise SystemExit(3)", "extra 'plots'"),
        ("raise ValueError('no ink')", "no ink"),
        ("raise SystemExit(5)", "exit code 5"),
    ],
)
def test_why_there_is_no_picture_is_a_sentence(painter, tmp_path, instead, source, words):
    instead(source)
    drawn = outcome(painter, tmp_path / "mag.png")
    assert drawn.path == ""
    assert words in drawn.trouble


def test_a_picture_that_takes_for_ever_is_given_up(painter, tmp_path, instead):
    instead("import time\ntime.sleep(60)")
    assert "within 60 s" in outcome(painter, tmp_path / "mag.png", late=61.0).trouble


def test_the_program_gets_what_is_to_be_drawn(painter, tmp_path, instead):
    instead("import sys, pathlib\npathlib.Path(sys.argv[1]).write_bytes(sys.stdin.buffer.read())")
    drawn = outcome(painter, tmp_path / "mag.png")
    assert b"a title" in Path(drawn.path).read_bytes()
