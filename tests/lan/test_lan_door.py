"""The door itself: off until it is opened, degraded while it cannot listen, reopened when it is killed."""

import json
import os
import signal
import socket
from pathlib import Path

import msgspec
import pytest

from lbr.apps.http.rates import Bucket
from lbr.apps.lan import rights
from lbr.apps.lan.kind import KIND
from lbr.bus.access import Credentials
from lbr.bus.door import LanConfig
from tests.support.door import ROLES, Door, add_token, answer
from tests.support.robot import free_port, lbr, running
from tests.support.waiting import until

LAN = LanConfig(
    listen=(),
    link=Credentials(user="@lan", password=""),
    users=(),
    streams=("lbr/motors/state",),
    stops=("lbr/drive/stop",),
    commands={"lbr/drive/command": "operate", "lbr/world/picture": "admin"},
    private_key="",
    certificate="",
)


@pytest.mark.parametrize(
    "listen",
    [
        "tcp/0.0.0.0:7447",
        "tcp/robot:7447",
        "tcp/[::]:7447",
        "tls/0.0.0.0:0",
        "tls/0.0.0.0:99999",
        "udp/0.0.0.0:7447",
        "tls/0.0.0.0",
        "tls/0.0.0.0:7447#iface=eth0",
    ],
)
def test_a_place_to_listen_is_refused_in_one_sentence(listen, wording):
    with pytest.raises(msgspec.ValidationError) as refused:
        KIND.parse(json.dumps({"listen": [listen]}))
    wording(refused.value)


@pytest.mark.parametrize(
    "listen", ["tls/0.0.0.0:7447", "tls/[::]:7447", "tcp/127.0.0.1:7447", "tcp/[::1]:7447", "tcp/localhost:1"]
)
def test_a_place_to_listen_may_be_anywhere_by_tls_and_on_loopback_without(listen):
    assert KIND.parse(json.dumps({"listen": [listen]})).listen == (listen,)


def test_listening_in_clear_text_is_refused_before_anything_starts(home: Path):
    done = lbr(home, "run", "--no-console", "--listen", "tcp/0.0.0.0:7447")
    assert done.returncode == 2
    assert "in clear text" in done.stderr
    assert done.stdout == ""


def test_roles_include_those_below_them_and_none_may_write_a_stream():
    view, operate, admin = (rights.of_role("lbr", LAN, role) for role in ("view", "operate", "admin"))
    for right in ("put", "ask", "hear", "watch"):
        assert set(getattr(view, right)) <= set(getattr(operate, right)) <= set(getattr(admin, right))
    assert "lbr/drive/command" not in view.put
    assert "lbr/world/picture" not in operate.ask
    assert not {"lbr/motors/state", "lbr/@event"} & set(admin.put)
    assert (admin.serve, admin.alive, admin.trusted) == ((), (), False)


def test_a_bucket_lets_pass_its_rate_and_a_little_at_once():
    bucket = Bucket(100.0, 0.0)
    assert sum(bucket.take(0.0) for _ in range(100)) == 25
    assert sum(bucket.take(1.0 + step / 200) for step in range(400)) == pytest.approx(225, abs=2)


def test_the_row_opens_and_closes_the_door_while_the_robot_runs(home: Path):
    held = {name: add_token(home, name, role) for name, role in ROLES.items()}
    with running(home) as robot, socket.socket() as taken:
        assert "lan" not in [one["name"] for one in robot.status()["capabilities"]]
        taken.bind(("127.0.0.1", free_port()))
        taken.listen()
        endpoint = f"tls/127.0.0.1:{taken.getsockname()[1]}"
        door = Door(robot, endpoint, held)
        robot.edit(
            "UPDATE capability SET enabled = 1, settings = json_object('listen', json_array(?)) WHERE name = 'lan'",
            endpoint,
        )
        until(lambda: robot.capability("lan")["phase"] == "degraded", what="the port is taken")
        assert "cannot listen on" in robot.capability("lan")["reason"]
        taken.close()
        door.ready()
        until(lambda: door.refuses("eye") == "", what="it is open")
        record = json.loads((home / "run" / "lbr.json").read_text())
        assert record["lan"] == [endpoint]
        with door.client("eye") as bus:
            until(lambda: answer(bus, "lbr/@status", timeout_s=0.3), what="it routes")
            robot.edit("UPDATE capability SET enabled = 0 WHERE name = 'lan'")
            until(lambda: door.refuses("eye"), what="it is closed")
            assert answer(bus, "lbr/@status", timeout_s=0.3) is None


def test_a_door_that_is_killed_is_open_again_and_routes_both_ways(door: Door):
    with door.client("eye") as bus:
        heard = []
        bus.declare_subscriber("lbr/motors/state", heard.append)
        for _ in range(2):
            until(lambda: heard, what="streams come")
            pid = door.robot.capability("lan")["pid"]
            os.kill(pid, signal.SIGKILL)
            until(lambda before=pid: door.robot.capability("lan")["pid"] not in {before, None}, what="another one")
            heard.clear()
            until(lambda: answer(bus, "lbr/drive/stop", {}, timeout_s=0.3), what="questions pass")
            until(lambda: heard, what="streams come")


def test_a_door_that_hangs_is_replaced(door: Door):
    pid = door.robot.capability("lan")["pid"]
    os.kill(pid, signal.SIGSTOP)
    until(lambda: door.robot.capability("lan")["pid"] not in {pid, None}, what="another one")
    until(lambda: door.refuses("eye") == "", what="it is open")
