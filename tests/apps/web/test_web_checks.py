"""What the doctor says of the port that a robot is served on."""

import json
import socket

import pytest

from lbr import home
from lbr.apps.http import listening
from lbr.apps.web.commands import checks as web_checks
from lbr.commands import device_checks
from lbr.database.rows import CapabilityRow, DeviceRow


@pytest.fixture
def taken():
    with socket.socket() as listening:
        listening.bind(("127.0.0.1", 0))
        listening.listen()
        yield listening.getsockname()[1]


def judged(port, monkeypatch, *running, host="127.0.0.1"):
    monkeypatch.setattr(home, "running", lambda: running)
    settings = json.dumps({"port": port, "host": host})
    rows = [
        CapabilityRow(name="web", kind="web", settings=settings),
        CapabilityRow(name="off", kind="web", enabled=False),
        CapabilityRow(name="other", kind="drive"),
    ]
    (found,) = web_checks.ports("uxa90", rows)
    return found


def test_a_port_that_is_taken_is_a_hint_unless_the_robot_itself_has_it(taken, monkeypatch):
    found = judged(taken, monkeypatch)
    assert (found.level, found.do) == ("hint", f"ss -ltnp 'sport = :{taken}'")
    assert "without its API" in found.text

    class Running:
        robot = "uxa90"

    assert judged(taken, monkeypatch, Running).level == "good"


def test_a_free_port_says_who_reaches_it(monkeypatch, wording):
    wording(judged(0, monkeypatch).text)
    assert judged(0, monkeypatch, host="0.0.0.0").text.endswith("the network reaches it")


def test_an_address_that_this_machine_has_not_is_named(monkeypatch):
    assert "cannot be used" in judged(0, monkeypatch, host="203.0.113.1").text


def test_an_adapter_that_holds_answers_back_is_a_hint_with_what_to_type(tmp_path, monkeypatch):
    monkeypatch.setattr(device_checks, "USB_SERIAL", tmp_path)
    row = DeviceRow(name="main_board", type="uxa90", address=str(tmp_path / "by-id"))
    assert list(device_checks.latency(row)) == []
    (tmp_path / "by-id").symlink_to(tmp_path / "ttyUSB7")
    timer = tmp_path / "ttyUSB7" / "latency_timer"
    timer.parent.mkdir()
    timer.write_text("16\n")
    (found,) = device_checks.latency(row)
    assert (found.level, f"echo 1 | sudo tee {timer}" in found.do) == ("hint", True)
    assert "16 ms" in found.text
    timer.write_text("1\n")
    (found,) = device_checks.latency(row)
    assert found.level == "good"
    assert list(device_checks.latency(DeviceRow(name="d", type="roboteq", address=row.address))) == []


@pytest.mark.skipif(not listening.is_here("::1"), reason="no IPv6 here")
def test_a_port_that_is_taken_by_ipv6_alone_is_named(monkeypatch):
    with socket.create_server(("::1", 0), family=socket.AF_INET6) as other:
        port = other.getsockname()[1]
        found = judged(port, monkeypatch)
    assert (found.level, found.text.partition(" cannot ")[0]) == ("hint", f"port {port} at ::1")
