import os
from types import SimpleNamespace

import pytest
from PIL import Image

from lbr.simulation.painter import Painter
from tests.support.waiting import HANG_S


def test_pictures_give_way_to_what_moves_the_robot(tmp_path, monkeypatch):
    ranks = []
    monkeypatch.setattr(os, "getpriority", lambda _which, _who: -10)
    monkeypatch.setattr(os, "setpriority", lambda which, who, nice: ranks.append((which, who, nice)))
    painter = Painter(SimpleNamespace(home=str(tmp_path), robot="lbr"))
    painter._worker.submit(lambda: None).result(HANG_S)
    painter.close()
    assert ranks == [(os.PRIO_PROCESS, 0, 0)]


@pytest.fixture
def bench(tmp_path):
    (tmp_path / "pictures").mkdir()
    return SimpleNamespace(ctx=SimpleNamespace(home=str(tmp_path), robot="lbr"), replies=[], refused=[])


def asked(bench, wanted, times=1):
    call = SimpleNamespace(reply=bench.replies.append, refuse=lambda why, _code: bench.refused.append(why))
    painter = Painter(bench.ctx)
    for _ in range(times):
        painter.ask(call, wanted, lambda: Image.new("1", (1, 1)))
    painter._worker.submit(lambda: None).result(HANG_S)
    painter.finish()
    painter.close()
    return [reply.path for reply in bench.replies]


def test_of_two_pictures_of_one_moment_the_second_gets_another_name(bench, tmp_path, monkeypatch):
    monkeypatch.setattr("lbr.simulation.painter.name_now", lambda _of: "a")
    assert asked(bench, "", times=2) == [str(tmp_path / "pictures" / one) for one in ("a.png", "a-2.png")]
    assert not bench.refused


def test_no_picture_takes_the_place_of_a_file_that_was_named_or_makes_a_folder(bench, tmp_path):
    named = str(tmp_path / "a.png")
    assert asked(bench, named, times=2) == [named]
    assert asked(bench, str(tmp_path / "new" / "a.png")) == [named]
    assert ["File exists" in bench.refused[0], "No such file" in bench.refused[1]] == [True, True]
    assert not (tmp_path / "new").exists()


@pytest.mark.parametrize("path", ["~nobody-of-this-name/a.png", "/tmp/a\0.png", "a.png", "/tmp/a.gif"])
def test_a_path_that_cannot_be_is_refused(bench, path, wording):
    assert asked(bench, path) == []
    wording(bench.refused[0])


def test_a_home_without_room_for_pictures_is_refused(bench, tmp_path):
    bench.ctx.home = str(tmp_path / "gone")
    assert asked(bench, "") == []
    assert "name a file" in bench.refused[0]
