import os

from lbr.simulation.painter import Painter


def test_pictures_give_way_to_what_moves_the_robot(tmp_path, monkeypatch):
    ranks = []
    monkeypatch.setattr(os, "getpriority", lambda _which, _who: -10)
    monkeypatch.setattr(os, "setpriority", lambda which, who, nice: ranks.append((which, who, nice)))
    painter = Painter()
    painter._worker.submit(lambda: None).result(5.0)
    painter.close()
    assert ranks == [(os.PRIO_PROCESS, 0, 0)]
