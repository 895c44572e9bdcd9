"""What requests of lbr's old API ask for: the documented ones as documented, and anything else in words."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.errors import InputError
from lbr.messages.drive import DriveCommand, HeadingCommand, TurnCommand
from lbr.robots.lbr.original import wishes
from lbr.robots.lbr.original.wishes import Asked, NotFiniteError

AHEAD = DriveCommand(power=0.3, angle_deg=0.0)


def asked(body):
    return wishes.asked(json.dumps(body).encode())


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ({"level": 0.25, "angle": 90}, Asked(motion=DriveCommand(power=0.25, angle_deg=90.0))),
        (
            {"level": 0.2, "angle": 0, "range": 40, "sensor": "Forward"},
            Asked(motion=DriveCommand(power=0.2, range_cm=40.0, sensor="forward")),
        ),
        (
            {"level": 0.25, "angle": 180, "duration": 5},
            Asked(motion=DriveCommand(power=0.25, angle_deg=180.0, interval_s=5.0)),
        ),
        ({"heading": 95}, Asked(motion=HeadingCommand(heading_deg=95.0))),
        ({"turn": -90, "speech": "x"}, Asked(motion=TurnCommand(angle_deg=-90.0), speech="x")),
        ({"level": 0, "angle": 0}, Asked(stop=True)),
        ({"level": 0, "angle": 0, "duration": -10}, Asked(stop=True)),
        ({"level": -0.5, "angle": 0}, Asked(stop=True)),
        ({"level": 0.004, "angle": 0}, Asked(stop=True)),
        ({"level": 7, "angle": 0}, Asked(motion=DriveCommand(power=1.0))),
        ({"level": 0.256, "angle": 12.9}, Asked(motion=DriveCommand(power=0.26, angle_deg=12.0))),
        ({"level": 0.3, "angle": "-405"}, Asked(motion=DriveCommand(power=0.3, angle_deg=-45.0))),
        ({"level": 0.3, "angle": 0, "range": "", "duration": ""}, Asked(motion=AHEAD)),
        ({"level": 0.3, "angle": 0, "range": -4, "sensor": "nowhere"}, Asked(motion=AHEAD)),
        (
            {"level": 0.3, "angle": 180, "range": 900, "sensor": "back"},
            Asked(motion=DriveCommand(power=0.3, angle_deg=180.0, range_cm=768.0, sensor="back")),
        ),
        (
            {"level": 0.3, "angle": 0, "range": 5, "sensor": ""},
            Asked(motion=DriveCommand(power=0.3, range_cm=17.0, sensor="forward")),
        ),
        ({"heading": "95.04", "turn": 5, "level": 1}, Asked(motion=HeadingCommand(heading_deg=95.0))),
        ({"heading": "", "turn": 5, "level": 1}, Asked(motion=TurnCommand(angle_deg=5.0))),
        ({"speech": "a text with / and text"}, Asked(speech="a text with / and text")),
        ({"speech": {"text": "hello", "time": 4}}, Asked(speech="hello")),
    ],
)
def test_a_documented_request_asks_for_what_is_documented(body, expected):
    assert asked(body) == expected


@pytest.mark.parametrize(
    ("body", "said"),
    [
        ({}, "say 'level' and 'angle'"),
        ({"speech": ""}, "say 'level' and 'angle'"),
        ({"level": 0.3}, "level needs an angle"),
        ({"level": "0.3", "angle": 0}, "level must be a number"),
        ({"level": True, "angle": 0}, "level must be a number"),
        ({"level": 0.3, "angle": "left"}, "angle must be a number, not 'left'"),
        (
            {"level": 0.3, "angle": 0, "range": 40, "sensor": "Forwards"},
            "sensor 'forwards' is not one of Forward, Back",
        ),
        ({"level": 0.3, "angle": 0, "duration": 9999}, "duration 9999 is longer than 3600 s"),
        ({"heading": 361}, "heading 361 is outside 0 to 360"),
        ({"heading": [1]}, "heading must be a number"),
        ({"turn": 720}, "turn 720 is outside"),
        ({"speech": 5}, "speech must be a text"),
        ([1], "must be an object"),
        ("x", "must be an object"),
    ],
)
def test_a_request_that_makes_no_sense_is_refused_in_words(body, said):
    with pytest.raises(InputError, match=said):
        asked(body)


@pytest.mark.parametrize("body", [b'{"level": NaN, "angle": 0}', b'{"turn": Infinity}', b'{"heading": 1e999}',
                                  b'{"level": 1' + b"0" * 400 + b', "angle": 0}', b'{"turn": "nan"}'])  # fmt: skip
def test_a_number_that_is_none_is_known_as_such(body):
    with pytest.raises(NotFiniteError):
        wishes.asked(body)


NO_OBJECTS = (b"", b"{", b"\xff\xfe", b"[" * 100_000, b'{"level": ' + b"1" * 5000 + b"}", b"null", b'{"speech": "\\ud800"}',
              b'{"level": 1, "angle": "\\udc00"}')  # fmt: skip


@pytest.mark.parametrize("body", NO_OBJECTS)
def test_a_body_that_is_no_json_object_is_refused_in_words(body):
    for read in (wishes.asked, wishes.speech, wishes.beams):
        with pytest.raises(InputError):
            read(body)


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ({"dockSignal": {"time": 1676000000.0, "left": 1}}, {"left": True}),
        ({"dockSignal": {"left": 0, "right": 1, "time": 3}}, {"left": False, "right": True}),
        ({"dockSignal": {"power": "1"}}, {"power": True}),
    ],
)
def test_beams_of_the_dock_are_read(body, expected):
    assert wishes.beams(json.dumps(body).encode()) == expected


@pytest.mark.parametrize("body", [{}, {"dockSignal": 1}, {"dockSignal": {"time": 4}}, {"dockSignal": {"left": [1]}}])
def test_beams_that_make_no_sense_are_refused(body):
    with pytest.raises(InputError):
        wishes.beams(json.dumps(body).encode())


def understood(read, body):
    """Return what is read; None if it is refused, which is in words."""
    try:
        return read(body)
    except InputError as err:
        said = str(err)
    assert said
    return None


SCALARS = st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8)
VALUES = st.recursive(
    SCALARS,
    lambda more: st.lists(more, max_size=3) | st.dictionaries(st.text(max_size=4), more, max_size=3),
    max_leaves=6,
)
NAMES = st.sampled_from(["level", "angle", "range", "sensor", "duration", "heading", "turn", "speech", "dockSignal"])


@given(st.dictionaries(NAMES, VALUES))
def test_whatever_is_sent_is_understood_or_refused_in_words_and_what_moves_is_in_bounds(body):
    sent = json.dumps(body).encode()
    for read in (wishes.speech, wishes.beams):
        understood(read, sent)
    found = understood(wishes.asked, sent)
    if found is None:
        return
    motion = found.motion
    if isinstance(motion, DriveCommand):
        assert 0.0 < motion.power <= 1.0
        assert -360.0 < motion.angle_deg < 360.0
        assert motion.range_cm == 0.0 or 17.0 <= motion.range_cm <= 768.0
        assert 0.0 <= motion.interval_s <= 3600.0
    elif isinstance(motion, TurnCommand):
        assert -360.0 <= motion.angle_deg <= 360.0
    elif isinstance(motion, HeadingCommand):
        assert 0.0 <= motion.heading_deg <= 360.0
    else:
        assert found.stop or found.speech


@given(st.binary(max_size=60))
def test_any_bytes_are_refused_in_words_or_understood(body):
    for read in (wishes.asked, wishes.speech, wishes.beams):
        understood(read, body)
