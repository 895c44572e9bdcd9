"""Two machines, one robot: what the profile places on the other one runs there, and stops when contact is lost."""

import os
import signal
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from lbr.bus import stamp, wire
from tests.lan.agents import Two, end, placed
from tests.support import netns, programs
from tests.support.netns import Network
from tests.support.robot import lbr
from tests.support.waiting import until


@pytest.fixture(scope="module")
def two(network: Network) -> Iterator[Two]:
    with (
        tempfile.TemporaryDirectory(prefix="lbr-") as place,
        placed(
            Path(place) / "h",
            network.address,
            network.robot,
            (*network.client, *netns.another_clock(Path(place))),
        ) as found,
    ):
        yield found


def test_a_share_waits_for_its_host_and_who_is_not_that_host_is_told_why(two: Two):
    assert two.phases() == {"waiting"}
    assert f"type: lbr agent operator --connect {two.endpoint}" in two.units()["dance"]["reason"]
    assert "lbr agent operator" in lbr(two.robot.home, "status").stdout
    operator, bench, kitchen = (str(two.tokens[name]) for name in ("operator", "bench", "kitchen"))
    wrong = operator.replace(operator.split(".")[1], "A" * 43)
    tries = {
        ("operator", ""): "wants a token",
        ("operator", wrong): "refuses the token",
        ("operator", kitchen): "'lbr token add operator --role host'",
        ("bench", bench): "the token 'bench' is not one for a host",
        ("kitchen", kitchen): "places nothing on 'kitchen'; it names bench, operator",
    }
    started = [(two.start(*who), why) for who, why in tries.items()]
    for popen, why in started:
        _, errors = popen.communicate(timeout=20)
        assert popen.returncode == 1, errors
        assert why in errors.decode()
    assert two.phases() == {"waiting"}


def test_what_moves_from_the_other_machine_ends_with_the_contact_and_does_not_resume(two: Two, network: Network):
    with two.agent() as agent:
        until(lambda: two.robot.ask("attitude/state"), what="an attitude from afar")
        (told,) = wire.ask(two.robot.bus, "lbr/attitude/state", None, source="test")
        assert getattr(stamp.read(told.attachment), "boot", "") in {netns.OTHER_BOOT, stamp.boot_id()}
        two.dancing()
        assert two.robot.ask("drive/state")["holder"] == "dance"
        before = two.pids()
        network.cut()
        try:
            two.stops_within(1.0)
            until(lambda: two.phases() == {"waiting"}, what="the robot knows that its host is gone")
        finally:
            network.heal()
        two.ready()
        two.stands_for(0.3)
        after = two.pids()
        assert not set(after.values()) & set(before.values())
        two.dancing()
        os.kill(after["far_mover"], signal.SIGSTOP)
        agent.kill()
        two.stops_within(1.5)
        until(lambda: two.phases() == {"waiting"}, what="the robot knows that the agent is gone")
        until(lambda: not any(map(_runs, after.values())), what="no process is orphaned")
    assert "gone with it: " in two.losses()[-1]


def test_edits_stops_and_the_end_of_the_robot_reach_the_other_machine(two: Two):
    with two.agent() as agent:
        before, losses = two.pids(), two.losses()
        two.robot.edit("UPDATE capability SET settings = json_set(settings, '$.max_s', 60) WHERE name = 'dance'")
        until(lambda: two.pids()["dance"] not in {None, before["dance"]}, what="dance is a new process")
        pids = two.pids()
        assert pids == before | {"dance": pids["dance"]} or two.losses() != losses, "a busy machine may lose contact"
        assert "acknowledged by drive, far_mover, motors" in two.robot.line("estop")["text"]
        assert two.robot.line("reset")["code"] == 0
        assert two.robot.close() == 0
        until(lambda: not any(map(_runs, pids.values())), what="the share has ended")
        until(lambda: "waiting for the robot" in two.said.read_text(), what="it says so")
        assert end(agent) == 0


def _runs(pid: int) -> bool:
    found = programs.run(["ps", "-o", "stat=", "-p", str(pid)], capture_output=True, text=True, check=False).stdout
    return os.path.exists(f"/proc/{pid}") and not found.startswith("Z")  # noqa: PTH110
