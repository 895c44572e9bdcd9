"""A program on another machine finds the robot by the network, and comes in by its door with a token from a keyring."""

import json
import os
import sys

import pytest

from tests.support import programs
from tests.support.door import opened
from tests.support.robot import prepare

pytestmark = pytest.mark.timeout(40)
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
