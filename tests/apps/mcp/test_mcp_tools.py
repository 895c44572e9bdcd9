"""The tools that agents have: few and fixed, made from the robot's words, and nothing that people alone may do."""

from io import BytesIO

import pytest
from PIL import Image

from lbr.apps.mcp.agent import LARGEST_SIDE, scaled
from lbr.apps.mcp.messages import NEVER, WORDS, Rules
from lbr.apps.mcp.tools import TOOLS, Known, allowed_line, named
from lbr.errors import InputError

FIELDS = {"power": {"type": "number", "minimum": 0.0, "maximum": 1.0}, "angle_deg": {"type": "number"}}
DISTANCE = {"distance_cm": {"type": "number", "x-typed-minimum": 1.0, "minimum": 0.0, "maximum": 10000.0}}
KNOWN = Known(
    words=(
        {"word": "s", "pattern": "s", "role": "view", "target": "executive.stop", "fields": []},
        {"word": "stop", "pattern": "stop", "role": "view", "target": "executive.stop", "fields": []},
        {
            "word": "s",
            "pattern": "/s/{text...}",
            "role": "operate",
            "target": "speech.say",
            "fields": [{"name": "text"}],
        },
        {"word": "reset", "pattern": "reset", "role": "operate", "target": "executive.reset", "fields": []},
        {"word": "r", "pattern": "/r/{power}/{angle_deg}", "role": "operate", "target": "drive.command"},
        {"word": "go", "pattern": "/go/{distance_cm}/{power}", "role": "operate", "target": "drive.command"},
        {"word": "back", "pattern": "/back/{distance_cm}/{power}", "role": "operate", "target": "drive.command"},
        {"word": "clock", "pattern": "clock", "role": "operate", "target": "external", "fields": []},
        {"word": "mark", "pattern": "mark", "role": "admin", "target": "box.mark", "fields": []},
    ),
    described={"drive.command": FIELDS | DISTANCE},
    rules=Rules(words=("s", "clock", "mark"), most_power=0.4),
)


def test_the_tools_are_few_and_none_is_for_people_alone():
    names = {tool.name for tool in TOOLS}
    assert len(names) == len(TOOLS) <= 14
    assert not names & {"reset", "torque", "publish", "rows", "tokens", *NEVER}
    assert not set(WORDS) & NEVER


def test_a_tool_is_there_if_the_robot_has_its_word():
    fitting = {tool.name for tool in TOOLS if tool.fits(KNOWN)}
    assert {"drive", "go", "stop", "estop", "say"} <= fitting
    assert not fitting & {"play", "turn", "look", "behaviour_run"}


def test_bounds_come_from_messages_and_rows():
    schema = named("drive").schema(KNOWN)
    assert schema["properties"]["power"]["maximum"] == 0.4
    assert schema["properties"]["seconds"]["maximum"] == 5.0
    assert schema["required"] == ["power", "angle_deg"]
    assert schema["additionalProperties"] is False


@pytest.mark.parametrize(
    ("tool", "arguments", "line"),
    [
        ("drive", {"power": 0.25, "angle_deg": -90, "seconds": 2}, "/r/0.25/-90"),
        ("drive", {"power": 1e-9, "angle_deg": 0.0}, "/r/0/0"),
        ("go", {"distance_cm": 30, "power": 0.2}, "/go/30/0.2"),
        ("go", {"distance_cm": -30, "power": 0.2}, "/back/30/0.2"),
    ],
)
def test_a_tool_says_a_line_of_the_robot(tool, arguments, line):
    assert named(tool).line(arguments) == line


@pytest.mark.parametrize("line", ["stop", "/s/hello there", " s "])
def test_an_agent_says_stops_and_what_the_row_allows(line):
    assert allowed_line(line, KNOWN) == line.strip()


@pytest.mark.parametrize(
    "line", ["reset", "/r/0.2/0", "clock", "mark", "!print(1)", "", "/", "//", "/s/a\nreset", "\x00s"]
)
def test_an_agent_says_nothing_else(line):
    with pytest.raises(InputError):
        allowed_line(line, KNOWN)


@pytest.mark.parametrize(("size", "expected"), [((1280, 960), (LARGEST_SIDE, 480)), ((320, 240), (320, 240))])
def test_a_picture_is_no_larger_than_an_agents_context_has_room_for(size, expected):
    Image.new("RGB", size).save(taken := BytesIO(), "JPEG")
    with Image.open(BytesIO(scaled(taken.getvalue()))) as picture:
        assert picture.size == expected


def test_what_is_no_picture_is_handed_on_as_it_is():
    assert scaled(b"rubbish") == b"rubbish"
