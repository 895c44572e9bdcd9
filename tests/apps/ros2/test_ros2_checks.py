"""What the doctor says of the router of ROS."""

import json
import socket

import pytest

from lbr import home
from lbr.apps.ros2.commands import checks
from lbr.database.rows import CapabilityRow
from tests.support.robot import free_port


class Running:
    robot = "lbr"


def judged(monkeypatch, *running, **settings):
    monkeypatch.setattr(home, "running", lambda: running)
    rows = [
        CapabilityRow(name="ros2", kind="ros2", settings=json.dumps(settings)),
        CapabilityRow(name="off", kind="ros2", enabled=False),
    ]
    (found,) = checks.router("lbr", rows)
    return found


@pytest.mark.parametrize(
    ("field", "running", "there", "level", "do"),
    [
        ("connect", (), True, "good", ""),
        ("connect", (), False, "hint", "rmw_zenohd"),
        ("listen", (Running,), True, "good", ""),
        ("listen", (Running,), False, "hint", "lbr status"),
        ("listen", (), True, "hint", "connect"),
        ("listen", (), False, "good", ""),
    ],
)
def test_it_tells_whether_the_router_is_there_and_what_to_do(monkeypatch, field, running, there, level, do):
    with socket.socket() as router:
        router.bind(("127.0.0.1", 0))
        router.listen()
        port = router.getsockname()[1] if there else free_port()
        found = judged(monkeypatch, *running, **{field: f"tcp/127.0.0.1:{port}"})
    assert found.level == level
    assert do in found.do


def test_settings_that_cannot_be_read_are_a_finding(monkeypatch):
    assert judged(monkeypatch, connect="tcp/nowhere").level == "bad"
