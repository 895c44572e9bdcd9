"""Ports that faces bring: the kind `web` has them, and what does not go together is refused in words."""

import pytest
from msgspec import Struct

from lbr.apps.web.kind import KIND, PORTS
from lbr.apps.web.ports import FacePorts, with_faces
from lbr.messages.faces import Motor
from lbr.messages.leases import StopCommand
from lbr.messages.rows import Row
from tests.support.packages import imported_from, package

OWN = FacePorts(
    inputs={"joints": Motor},
    states=("joints",),
    requests={"move": StopCommand},
    replies={"move": StopCommand},
    rows=(Motor,),
)
BROUGHT = """
from msgspec import Struct
from lbr.apps.web.ports import FacePorts
from lbr.messages.faces import Motor
from lbr.messages.leases import StopCommand
from lbr.messages.rows import Row

class Gripper(Struct):
    "A gripper."
    open: bool = False

class Mine(Row, frozen=True, kw_only=True):
    TABLE = "motor"
    KEY = ("layer",)
    layer: str = ""

PORTS = {ports}
"""


def brought(site, ports: str) -> tuple[FacePorts, tuple[str, ...]]:
    package(
        site,
        "my-gripper",
        brings={"ports": {"gripper": "my_gripper:PORTS"}},
        files={"my_gripper.py": BROUGHT.replace("{ports}", ports)},
    )
    with imported_from(site):
        return with_faces(OWN)


def test_the_kind_has_the_servers_own_ports_and_those_of_our_faces():
    assert {"joints", "drive", "controller", "cameras", "frames"} <= set(KIND.inputs)
    assert set(KIND.optional) == set(KIND.inputs)
    assert {"move", "take_control", "edit"} <= set(KIND.requests)
    assert "controller" in PORTS.states
    assert "frames" not in PORTS.states


def test_a_packages_face_brings_inputs_states_requests_and_rows(tmp_path):
    found, refused = brought(
        tmp_path,
        'FacePorts(inputs={"gripper": Gripper}, states=("gripper",), requests={"grip": StopCommand}, rows=(Motor,))',
    )
    assert refused == ()
    assert issubclass(found.inputs["gripper"], Struct)
    assert found.states[:1] == ("joints",)
    assert "gripper" in found.states
    assert found.requests["grip"] is StopCommand
    assert found.rows[0] is Motor


def test_two_faces_may_have_the_same_port_of_the_same_message(tmp_path):
    found, refused = brought(tmp_path, 'FacePorts(inputs={"joints": Motor}, requests={"move": StopCommand})')
    assert refused == ()
    assert found.inputs["joints"] is Motor


@pytest.mark.parametrize(
    ("ports", "why"),
    [
        ("None", "is no FacePorts"),
        ('FacePorts(inputs={"joints": Gripper})', "input 'joints' is Gripper"),
        ('FacePorts(requests={"move": Gripper})', "request 'move' is Gripper"),
        ('FacePorts(requests={"grip": Gripper}, replies={"move": Gripper})', "reply 'move' is Gripper"),
        ('FacePorts(replies={"grip": Gripper})', "no request 'grip'"),
        ('FacePorts(states=("grip",))', "no input 'grip'"),
        ('FacePorts(inputs={"robot": Gripper}, states=("robot",))', "choose another name"),
        ('FacePorts(inputs={"no name": Gripper})', "input 'no name' is not a name"),
        ("FacePorts(rows=(Mine,))", "table 'motor' is read as Motor already"),
        ("1 / 0", "it does not load: ZeroDivisionError"),
    ],
)
def test_what_does_not_go_with_the_others_is_refused_with_its_package_and_the_rest_stays(tmp_path, ports, why):
    found, (refused,) = brought(tmp_path, ports)
    assert "my-gripper" in refused
    assert why in refused
    assert found.inputs["joints"] is Motor
    assert "grip" not in found.requests
    assert "controller" in found.inputs


def test_a_row_of_ports_is_a_row():
    assert all(issubclass(row, Row) for row in PORTS.rows)
