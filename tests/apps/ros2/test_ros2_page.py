"""docs/ros2.md says what is so: its commands work on the shipped rows, and its topics, types and settings are there."""

import json
import re
import shlex
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from lbr.messages.sensing import RangeSensor, ring
from tests.support import databases, needs

needs.modules("rosbags")
needs.modules("xxhash")
from lbr.apps.ros2 import topics  # noqa: E402 - it needs both
from lbr.apps.ros2.kind import KIND, Ros2Settings  # noqa: E402

PAGE = (Path(__file__).parents[3] / "docs" / "ros2.md").read_text()
LIDAR = RangeSensor(name="lidar", kind="lidar", rays=360)
TYPES = re.compile(r"`([a-z0-9_]+)/([A-Z]\w+)`")


def rows(heading):
    """Return the cells of the table below a heading."""
    part = PAGE.partition(f"## {heading}\n")[2].partition("\n## ")[0]
    return [
        [cell.strip() for cell in line.strip("|").split("|")] for line in part.splitlines() if line.startswith("| `")
    ]


@pytest.fixture(scope="module")
def ports():
    return topics.ports(Ros2Settings(), lambda _port: ("somebody",), (*ring(0.4, 0.3), LIDAR))


def steps():
    """Return its first commands after the installation: the words for `lbr`, and the edit of the rows."""
    _pip, token, edit = re.findall(r"```sh\n(.*?)```", PAGE, re.DOTALL)[0].splitlines()
    return shlex.split(token)[1:], shlex.split(edit)[-1]


def test_its_command_switches_the_row_on_with_a_token(tmp_path):
    databases.fresh(tmp_path / "robot.db")
    with closing(sqlite3.connect(tmp_path / "robot.db")) as database:
        database.execute(steps()[1])
        query = "SELECT enabled, settings FROM capability WHERE robot = 'lbr' AND kind = 'ros2'"
        enabled, settings = database.execute(query).fetchone()
    assert enabled == 1
    assert KIND.parse(settings).token == "ros"
    assert "dock" in json.loads(settings)["services"]


def test_its_settings_are_there_with_their_values():
    named = re.findall(r"`(\w+)`", " ".join(cells[0] for cells in rows("Where ROS is")))
    assert set(named) <= set(Ros2Settings.__struct_fields__)
    said = dict(re.findall(r"(\d[\d.]*) s \(`(\w+)`\)", PAGE))
    assert said
    assert all(getattr(Ros2Settings(), name) == float(value) for value, name in said.items())


def test_its_topics_are_published_by_the_types_that_it_names(ports):
    shown = {port.topic: port.type for port in ports.values() if port.kind == "MP"}
    for names, types in rows("Topics"):
        found = [
            shown[name.replace("NAME", "forward").replace("CAMERA", "somebody")]
            for name in re.findall(r"`(/\S+)`", names)
        ]
        expected = [f"{package}/msg/{name}" for package, name in TYPES.findall(types)]
        assert not expected or found == expected


def test_its_services_are_served(ports):
    served = {port.topic for port in ports.values() if port.kind == "SS"}
    assert set(re.findall(r"`(/\w+)`", rows("Services")[0][0])) == served
