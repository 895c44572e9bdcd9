"""How often a process's link says that it is there."""

import pytest
from msgspec import Raw

from lbr.bus import session
from lbr.capability import way_in
from lbr.capability.config import ProcessConfig


@pytest.mark.parametrize(("host", "lease_ms"), [("", session.WATCHED_MS), ("pi4", session.LINK_LEASE_MS)])
def test_only_where_the_executive_hears_its_heartbeats_the_link_may_be_silent_for_long(monkeypatch, host, lease_ms):
    asked = []
    monkeypatch.setattr(session, "open_client", lambda *_place, **more: asked.append(more))
    settings = Raw(b"{}")
    way_in.enter(
        ProcessConfig(robot="r", name="n", kind="k", settings=settings, endpoints=("tcp/h:1",), home="/h", host=host)
    )
    assert asked == [{"certificate": "", "lease_ms": lease_ms}]
