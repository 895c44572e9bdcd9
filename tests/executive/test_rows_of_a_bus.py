"""Which joints a driver, and joints operation, get of a robot with several buses."""

from lbr.drivers.dynamixel import KIND as DRIVER
from lbr.executive.planning.process_specs import read_by
from lbr.messages.joints import Joint
from lbr.operations.joints import KIND as JOINTS
from lbr.operations.motions import KIND as MOTIONS


def joints(*buses):
    return tuple(
        Joint(name=f"joint_{bus}", device_id=1, lower_rad=-1.0, upper_rad=1.0, speed_rps=1.0, bus=bus) for bus in buses
    )


def got(kind, settings, rows):
    return [joint.bus for joint in read_by(kind.reads[0], kind.parse(settings), rows)]


def test_a_driver_gets_the_joints_of_its_device_and_those_that_name_none():
    assert got(DRIVER, '{"device": "left"}', joints("left", "right")) == ["left"]
    assert got(DRIVER, '{"device": "left"}', joints("", "right")) == [""]
    assert got(DRIVER, '{"device": "left"}', joints("", "")) == ["", ""]


def test_operations_have_all_joints_unless_they_say_which():
    for kind in (JOINTS, MOTIONS):
        assert got(kind, "{}", joints("left", "right", "")) == ["left", "right", ""]
        assert got(kind, '{"bus": "right"}', joints("left", "right")) == ["right"]
