"""A program on another machine finds the robot by the network, and comes in by its door with a token from a keyring."""

import json
import os
import sys

from tests.support import programs
from tests.support.door import opened
from tests.support.robot import prepare

KEYRING = """
import os
from keyring.backend import KeyringBackend

class Keyring(KeyringBackend):
    priority = 1

    def get_password(self, service, username):
        return os.environ["SECRET"] if (service, username) == ("lbr-token", os.environ["DOOR"]) else None

    def set_password(self, *_what):
        raise NotImplementedError
"""
FINDING = """
import json
from lbr import client

found = [one for _ in range(3) for one in client.find(within_s=1.5)]
robot = next(one for one in found if one.door)
with robot.connect(name="afar") as connected:
    print(json.dumps([robot, connected.role, "forward_m" in connected.latest("ranges/readings")]))
"""
OPENED = "UPDATE capability SET settings = json_set(settings, '$.host', '0.0.0.0', '$.announce', json('true')) WHERE name = 'web'"


def test_a_robot_of_the_network_is_found_and_reached(network, tmp_path):
    home = prepare(tmp_path / "home", "web", edits=(OPENED,))
    (tmp_path / "kept_in_memory.py").write_text(KEYRING)
    with opened(home, network.address, prefix=network.robot, elsewhere=network.client) as door:
        environment = os.environ | {
            "LBR_HOME": str(door.away),
            "PYTHONPATH": str(tmp_path),
            "PYTHON_KEYRING_BACKEND": "kept_in_memory.Keyring",
            "SECRET": str(door.tokens["phone"]),
            "DOOR": door.endpoint,
        }
        command = [*network.client, sys.executable, "-c", FINDING]
        done = programs.run(command, env=environment, capture_output=True, text=True, timeout=30, check=False)
        assert done.returncode == 0, done.stderr
        (name, host, at, page), role, looked = json.loads(done.stdout)
        assert (name, host, at) == ("lbr", network.address, door.endpoint)
        assert page.startswith(f"https://{network.address}:")
        assert (role, looked) == ("operate", True)


ANNOUNCING = """
import asyncio, sys
from lbr.apps.web.announce import Announcer

asyncio.run(Announcer("lbr on pi", int(sys.argv[2]), lambda: (sys.argv[1],), lambda: {"robot": "lbr"}).run())
"""
LISTING = """
import json, sys, time
from zeroconf import ServiceBrowser, Zeroconf

names, network = set(), Zeroconf()
ServiceBrowser(network, "_lbr._tcp.local.", handlers=[lambda name, **_rest: names.add(name)])
end = time.monotonic() + 20.0
while len(names) < 2 and time.monotonic() < end:
    time.sleep(0.05)
infos = [network.get_service_info("_lbr._tcp.local.", name) for name in names]
print(json.dumps({info.port: [info.server, *info.parsed_addresses()] for info in infos if info}))
network.close()
"""


def test_two_robots_of_one_host_name_are_two_each_at_its_own_address(network, tmp_path):
    environment = os.environ | {"LBR_HOME": str(tmp_path)}
    robots_at = [(network.address, "50001", network.robot), (network.client_address, "50002", network.client)]
    robots = [
        programs.start([*where, sys.executable, "-c", ANNOUNCING, address, port], env=environment)
        for address, port, where in robots_at
    ]
    try:
        done = programs.run(
            [*network.client, sys.executable, "-c", LISTING],
            env=environment,
            capture_output=True,
            text=True,
            timeout=30,
            check=False,
        )
        assert done.returncode == 0, done.stderr
        hosts = json.loads(done.stdout)
        assert {port: addresses for port, (_, *addresses) in hosts.items()} == {
            port: [address] for address, port, _ in robots_at
        }
        assert len({server for server, *_ in hosts.values()}) == 2
        assert [robot.poll() for robot in robots] == [None, None]
    finally:
        for robot in robots:
            robot.kill()
            robot.wait()
