"""Faults are settings, and can be changed one at a time."""

import pytest

from lbr.errors import InputError
from lbr.simulation.devices.roboteq import RoboteqFaults
from lbr.simulation.devices.ultrasonic_ring import UltrasonicFaults
from lbr.simulation.faults import changed


@pytest.mark.parametrize(
    ("faults", "name", "value", "field", "result"),
    [
        (RoboteqFaults(), "silent", True, "silent", True),
        (RoboteqFaults(), "drop", 0.5, "drop", 0.5),
        (RoboteqFaults(), "drop", True, "drop", 1.0),
        (RoboteqFaults(), "drop", "0.25", "drop", 0.25),
        (RoboteqFaults(), "silent", "true", "silent", True),
        (UltrasonicFaults(), "range_forward_m", "0.3", "range_forward_m", 0.3),
        (UltrasonicFaults(), "missing", "left", "missing", ("left",)),
        (RoboteqFaults(), "unplug", True, "unplug", True),
        (RoboteqFaults(unplug=True), "replug", True, "unplug", False),
        (RoboteqFaults(unplug=True), "replug", None, "unplug", False),
        (RoboteqFaults(drop=0.5), "drop", None, "drop", 0.0),
        (UltrasonicFaults(), "missing", "left, back", "missing", ("left", "back")),
        (UltrasonicFaults(), "missing", ("left",), "missing", ("left",)),
        (UltrasonicFaults(), "range_forward_m", 0.3, "range_forward_m", 0.3),
        (UltrasonicFaults(range_forward_m=0.3), "range_forward_m", None, "range_forward_m", None),
    ],
)
def test_one_fault_changes(faults, name, value, field, result):
    assert getattr(changed(faults, name, value), field) == result


@pytest.mark.parametrize(
    ("name", "value", "complaint"),
    [
        ("explode", True, "no fault 'explode'; allowed here: unplug, silent"),
        ("half_lines", 2.0, "fault 'half_lines'"),
        ("silent", "maybe", "fault 'silent'"),
        ("missing", "Up", "fault 'missing'"),
        ("missing", True, "name them after it"),
        ("range_left_m", float("nan"), "fault 'range_left_m'"),
    ],
)
def test_what_cannot_be_set_is_named(name, value, complaint):
    with pytest.raises(InputError, match=complaint):
        changed(UltrasonicFaults(), name, value)
