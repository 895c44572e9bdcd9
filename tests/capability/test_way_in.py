"""What is left of a capability that is not let in."""

import os

import pytest
from msgspec import Raw

from lbr.bus import session
from lbr.capability import Capability, Kind, NoSettings, way_in
from lbr.capability.config import ProcessConfig
from lbr.capability.reporter import Reporter
from lbr.capability.runtime import ProcessContext
from lbr.errors import BusError


class Arm(Capability[NoSettings]):
    """Moves."""


def test_a_mover_that_is_not_let_in_leaves_no_session_of_its_emergency_stop_in_the_process(tmp_path, monkeypatch):
    place = f"unixsock-stream/{tmp_path}/r"
    opened = []
    enter_alone = way_in.enter_alone

    def once(config):
        if opened:
            raise BusError("the router lets nobody in")
        opened.append(enter_alone(config))
        return opened[0]

    monkeypatch.setattr(way_in, "enter_alone", once)
    kind = Kind(name="arm", summary="moves", family="operation", entry=Arm, moves=True)
    config = ProcessConfig(
        robot="r", name="arm", kind="arm", settings=Raw(b"{}"), endpoints=(place,), home=str(tmp_path), process="crew"
    )
    reports, report = os.pipe()
    router = session.open_router(session.Router(listen=(place,)))
    try:
        with pytest.raises(BusError, match="lets nobody in"):
            ProcessContext(config, kind, Reporter(report), lambda: None, False)
        assert [one.is_closed() for one in opened] == [True]
    finally:
        router.close()
        os.close(reports)
        os.close(report)
