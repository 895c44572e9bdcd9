"""The first lbr's state machine reads its tables as its documents say: what its cells mean."""

import pytest

from tests.models.original.machine import Machine, fits


@pytest.mark.parametrize(
    ("cell", "value", "expected"),
    [
        ("85:100", 85, True),
        ("85 : 100", 101, False),
        ("< 255", 254.9, True),
        (">=20", 25, False),
        (">= 20", 20, True),
        ("1", 1.0, True),
        ("0", 0, True),
        ("abc", "abc", True),
        ("== 5", 5, False),
        ("-5:-1", -3, True),
        ("1", None, False),
    ],
)
def test_a_cell_means_what_it_always_has(cell, value, expected):
    assert fits(cell, value) is expected


def test_a_null_heading_ends_the_machine_as_it_did():
    told = {
        "MPU": {"heading": None},
        "Ranges": {"Forward": 1, "Left": 1, "Right": 1, "Back": 1},
        "amperages": {"leftMotor": 0.0, "rightMotor": 0.0},
        "Bat": {"voltage": 12.6},
    }
    table = ["Type,Current State,heading,Next State", "start,A,,B", "end,B,,"]
    with pytest.raises(TypeError):
        Machine(table, lambda *_: told).run()
