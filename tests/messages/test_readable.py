"""A message is shown to people with the units that its fields' names tell."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.messages.readable import LONGEST, fields

VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=20),
    lambda inner: st.lists(inner, max_size=5) | st.dictionaries(st.text(max_size=8), inner, max_size=5),
    max_leaves=20,
)


@pytest.mark.parametrize(
    ("message", "text"),
    [
        ({"forward_m": 2.6149, "bottom_m": None, "age_s": 0.029}, "forward 2.61 m, bottom unknown  (0.029 s old)"),
        ({"heading_deg": 5.84, "charging": True, "cpu_percent": 2.3}, "heading 5.84°, charging yes, cpu 2.3%"),
        ({"gyro_rps": [0.00933, -0.0, 1.0]}, "gyro [0.00933 0 1] rad/s"),
        ({"rates_hz": {"package": 5.0}, "others_m": {}}, "rates (package 5 Hz)"),
        ({"stopped_by": "", "seen": []}, "nothing"),
        (
            {"turn_dps": 12345.6, "cameras": {"front": {"on": True, "reason": ""}}},
            "turn 12346 °/s, cameras (front (on yes))",
        ),
        ({"v": 3, "left": 278}, "v 3, left 278"),
        ({"joints": [{"name": "left_knee", "position_rad": 0.5}]}, "joints (name left_knee, position 0.5 rad)"),
    ],
)
def test_values_have_the_unit_of_their_name(message, text):
    assert fields(message) == text


@given(st.dictionaries(st.text(max_size=12), VALUES, max_size=5))
def test_any_message_has_a_text_that_no_list_makes_long(message):
    assert len(fields(message)) <= len("nothing") + sum(2 * LONGEST + len(name) for name in message)
