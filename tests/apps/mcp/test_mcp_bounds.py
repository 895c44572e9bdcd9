"""What an argument of a tool may be: within bounds, of its type, and nothing else."""

import math

import pytest

from lbr.apps.mcp import bounds
from lbr.errors import InputError

POWER = {"type": "number", "minimum": 0.0, "maximum": 0.5}
SCHEMA = bounds.of_object(
    {
        "power": POWER,
        "name": {"type": "string", "enum": ["dock", "patrol"]},
        "line": {"type": "string", "maxLength": 5},
        "seconds": {"type": "number", "minimum": 0.1, "maximum": 5.0, "default": 1.0},
    },
    ["power"],
)


def test_what_fits_is_taken_with_the_defaults_of_the_rest():
    assert bounds.checked(SCHEMA, {"power": 0.5}) == {"power": 0.5, "seconds": 1.0}
    assert bounds.checked(SCHEMA, {"power": 0, "name": "dock", "seconds": 5})["seconds"] == 5


@pytest.mark.parametrize(
    ("arguments", "code", "names"),
    [
        ({}, "bad_value", "power"),
        ({"power": 0.51}, "bad_value", "power"),
        ({"power": math.nan}, "bad_value", "power"),
        ({"power": math.inf}, "bad_value", "power"),
        ({"power": True}, "bad_value", "power"),
        ({"power": "0.2"}, "bad_value", "power"),
        ({"power": None}, "bad_value", "power"),
        ({"power": [0.2]}, "bad_value", "power"),
        ({"power": 0.1, "name": "reset"}, "bad_value", "name"),
        ({"power": 0.1, "name": {"dock": 1}}, "bad_value", "name"),
        ({"power": 0.1, "line": "longer"}, "bad_value", "line"),
        ({"power": 0.1, "lease": "x"}, "unknown_name", "lease"),
        ({"power": 0.1, "take_over": True}, "unknown_name", "take_over"),
    ],
)
def test_what_does_not_fit_is_refused_by_its_name(arguments, code, names):
    with pytest.raises(InputError, match=names) as refused:
        bounds.checked(SCHEMA, arguments)
    assert refused.value.code == code


def test_a_field_has_the_bounds_of_its_message_the_names_of_the_rows_and_the_limit_of_agents():
    described = {"type": "number", "minimum": 0.0, "maximum": 1.0, "default": 0.0, "x-typed-minimum": 0.1}
    assert bounds.of_field(described, [], 0.4) == {"type": "number", "minimum": 0.1, "maximum": 0.4}
    assert bounds.of_field({"type": "string", "description": "which"}, ["dock"]) == {
        "type": "string",
        "enum": ["dock"],
        "description": "which",
    }


def test_what_an_agent_sent_is_shown_short_and_in_one_line():
    assert "\n" not in bounds.brief("a\nb\x1b[2J" * 100)
    assert len(bounds.brief("x" * 5000)) < 100
