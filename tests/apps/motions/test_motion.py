"""`lbr motion`: what a file has becomes a row, or a sentence; and what was written out comes in again."""

import json

import pytest

from lbr import cli
from lbr.database import store
from lbr.messages.joints import MotionRow
from tests.apps.motions.test_motion_files import NOD, content
from tests.support import databases


@pytest.fixture
def place(tmp_path, monkeypatch):
    monkeypatch.setenv("LBR_HOME", str(tmp_path))
    databases.fresh(tmp_path / "robot.db")
    (tmp_path / "nod.rbm").write_bytes(NOD)
    return tmp_path


def lbr(capsys, *arguments: object) -> tuple[int, str, str]:
    code = cli.main(["motion", *map(str, arguments)])
    return code, *capsys.readouterr()


def motion(place, name):
    with store.Database.open(place / "robot.db") as database:
        return [row.help for row in database.load("uxa90").of(MotionRow) if row.name == name]


def test_a_factory_motion_is_looked_at_taken_listed_and_taken_again_only_if_told(place, capsys):
    code, out, _ = lbr(capsys, "import", place / "nod.rbm", "--dry-run")
    assert (code, motion(place, "a_test")) == (0, [])
    assert out.startswith(
        "would take 'a_test' for uxa90: 3 key frames, 1.7 s, 25 joints\nfastest: head_pitch, 1.42 rad/s of"
    )
    code, out, _ = lbr(capsys, "import", place / "nod.rbm", "--name", "nod")
    assert (code, out.partition(":")[0], motion(place, "nod")) == (0, "took 'nod' for uxa90", ["A: test"])
    code, _, err = lbr(capsys, "import", place / "nod.rbm", "--name", "nod")
    assert (code, "lbr: motion 'nod' is there already: --replace puts this one in its place" in err) == (2, True)
    code, out, _ = lbr(capsys, "import", place / "nod.rbm", "--name", "nod", "--replace", "--json")
    assert json.loads(out)["written"]
    code, out, _ = lbr(capsys, "list", "--robot", "uxa90")
    assert "uxa90 nod: 1.7 s, 3 key frames, 25 joints. A: test" in out
    assert "uxa90 sit_down: 7 s, in slot 21" in out


def test_what_is_written_out_comes_in_again(place, capsys):
    lbr(capsys, "import", place / "nod.rbm", "--name", "nod")
    code, out, _ = lbr(capsys, "export", "nod", "--to", place / "nod.json")
    assert (code, out) == (0, f"wrote {place / 'nod.json'}\n")
    code, _, err = lbr(capsys, "import", place / "nod.json")
    assert (code, "is there already" in err) == (2, True)
    code, out, _ = lbr(capsys, "import", place / "nod.json", "--name", "nod_2")
    assert (code, motion(place, "nod_2")) == (0, ["A: test"])
    code, out, _ = lbr(capsys, "export", "nod")
    assert json.loads(out) == json.loads((place / "nod.json").read_text())
    assert lbr(capsys, "export", "nod", "--to", place / "nod.json")[0] == 2


def test_joints_beyond_their_limits_are_refused_or_clipped(place, capsys):
    (place / "far.rbm").write_bytes(content((20, 400, {24: 250})))
    code, _, err = lbr(capsys, "import", place / "far.rbm")
    assert (code, "head_pitch: 2.27" in err) == (2, True)
    code, out, _ = lbr(capsys, "import", place / "far.rbm", "--clip")
    assert (code, "1 angle brought within" in out) == (0, True)


@pytest.mark.parametrize(
    "arguments",
    [
        ("import", "nowhere.rbm"),
        ("import", "{place}/robot.db"),
        ("import", "{place}/nod.rbm", "--robot", "bioloid"),
        ("import", "{place}/nod.rbm", "--robot", "nobody"),
        ("import", "{place}/nod.rbm", "--name", "sit_down", "--replace"),
        ("import", "{place}/nod.rbm", "--name", "No Name"),
        ("export", "nothing"),
        ("export", "turn_left"),
        ("export", "kick_right"),
    ],
)
def test_what_cannot_be_done_is_said_in_a_sentence(place, capsys, arguments, wording):
    code, _, err = lbr(capsys, *(text.format(place=place) for text in arguments))
    assert code == 2
    wording(err)
