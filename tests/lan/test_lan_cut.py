"""Two machines and the cable between them: what is cut off stops, and what was held back moves nothing."""

import json
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.support import netns, programs
from tests.support.door import Door
from tests.support.netns import Network
from tests.support.robot import running
from tests.support.waiting import HANG_S, STOPS_S, until

EXAMPLE = Path(__file__).parents[2] / "docs" / "examples" / "drive_with_plain_zenoh.py"


def tell(popen: "subprocess.Popen[str]", word: str) -> None:
    """Switch a plain client, and wait until it has heard."""
    assert popen.stdin is not None
    popen.stdin.write(f"{word}\n")
    popen.stdin.flush()
    assert popen.stdout is not None
    while json.loads(popen.stdout.readline()).get("heard") != word:
        pass


def stands_for(door: Door, seconds: float) -> None:
    since_ns = time.monotonic_ns()
    with pytest.raises(AssertionError, match="never"):
        until(door.moving, what="never")
    assert all(output.zero for output in door.trace.outputs(since_ns))


def test_our_tools_reach_the_robot_from_another_machine(far_door: Door):
    assert far_door.drive("phone", "/r/0.1/90", hold_s=0.5)["text"] == "accepted"
    far_door.rest()


def test_the_example_drives_from_another_machine_by_its_file_alone(far_door: Door):
    command = [*far_door.elsewhere, sys.executable, str(EXAMPLE), str(far_door.file("phone")), "0.5"]
    done = programs.run(command, capture_output=True, text=True, timeout=HANG_S, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[-1] == "stopped"


@pytest.mark.parametrize(("manner", "cut_s"), [("quoting", 0.3), ("quoting", 0.9), ("stamped", 0.9), ("asking", 0.9)])
def test_what_a_cut_held_back_moves_nothing_when_it_heals(far_door: Door, network: Network, manner, cut_s):
    with far_door.plain("phone", manner) as client:
        until(far_door.moving, what="it drives")
        network.cut()
        cut_ns = time.monotonic_ns()
        try:
            zero = far_door.trace.first_zero(cut_ns, 1.0)
            if zero is None:  # who asks each time may have stood in that moment, for want of an answer in time
                assert manner == "asking"
                assert far_door.trace.at(time.monotonic_ns()).zero
                assert far_door.trace.at(cut_ns).zero
            else:
                assert (zero.at_ns - cut_ns) / 1e9 < 0.5
            until(lambda: time.monotonic_ns() - cut_ns > cut_s * 1e9, what="the cut lasts")
            tell(client, "cease")
        finally:
            network.heal()
        stands_for(far_door, 1.2)
    far_door.rest()


def test_what_quotes_no_lease_never_moves_anything_from_afar(far_door: Door):
    with far_door.plain("phone", "careless"):
        stands_for(far_door, 0.6)


def test_a_client_that_is_killed_leaves_the_motors_standing(far_door: Door):
    with far_door.plain("phone", "quoting") as client:
        until(far_door.moving, what="it drives")
        killed_ns = time.monotonic_ns()
        client.kill()
        assert far_door.trace.first_zero(killed_ns, STOPS_S) is not None
    far_door.rest()


@pytest.mark.slow_start
def test_a_robot_as_it_comes_cannot_be_reached_and_says_nothing_to_the_network(home: Path, network: Network):
    with netns.network() as alone, running(home, prefix=alone.robot) as robot:
        listening = programs.run([*alone.robot, "ss", "-Hlntu"], capture_output=True, text=True, check=True)
        assert listening.stdout == ""
        before = said_to_the_network(alone)
        robot.line("/r/0.1/90")
        until(lambda: robot.ask("world/pose") is not None, what="it works")
        assert said_to_the_network(alone) == before == ["Ip:OutRequests 0", "Tcp:ActiveOpens 0", "Udp:OutDatagrams 0"]


def said_to_the_network(network: Network) -> list[str]:
    """Count what programs on the robot's machine have sent."""
    text = programs.run([*network.robot, "cat", "/proc/net/snmp"], capture_output=True, text=True, check=True).stdout
    rows = [line.split() for line in text.splitlines() if line.startswith(("Ip:", "Tcp:", "Udp:"))]
    found = {
        f"{names[0]}{name}": value
        for names, values in zip(rows[::2], rows[1::2], strict=True)
        for name, value in zip(names, values, strict=True)
    }
    return [f"{name} {found[name]}" for name in ("Ip:OutRequests", "Tcp:ActiveOpens", "Udp:OutDatagrams")]
