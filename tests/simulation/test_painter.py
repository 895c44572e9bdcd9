import os
from types import SimpleNamespace

import pytest
from PIL import Image

from lbr.simulation.painter import Painter


def test_pictures_give_way_to_what_moves_the_robot(tmp_path, monkeypatch):
    ranks = []
    monkeypatch.setattr(os, "getpriority", lambda _which, _who: -10)
    monkeypatch.setattr(os, "setpriority", lambda which, who, nice: ranks.append((which, who, nice)))
    painter = Painter()
    painter._worker.submit(lambda: None).result(5.0)
    painter.close()
    assert ranks == [(os.PRIO_PROCESS, 0, 0)]


@pytest.mark.parametrize(("named", "refused"), [(False, False), (True, True)])
def test_of_two_pictures_that_are_to_be_one_file_a_nameless_one_gets_another_name(tmp_path, named, refused):
    replies, refusals = [], []
    call = SimpleNamespace(reply=replies.append, refuse=lambda why, _code: refusals.append(why))
    painter = Painter()
    for _ in range(2):
        painter.ask(call, tmp_path / "a.png", lambda: Image.new("1", (1, 1)), named=named)
    painter._worker.submit(lambda: None).result(5.0)
    painter.finish()
    painter.close()
    there = ["a.png"] if refused else ["a-2.png", "a.png"]
    assert sorted(one.name for one in tmp_path.iterdir()) == there
    assert sorted(reply.path for reply in replies) == [str(tmp_path / one) for one in there]
    assert len(refusals) == refused
