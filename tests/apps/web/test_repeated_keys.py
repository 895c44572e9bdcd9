"""A key that stands twice in one JSON object is refused at each door: which of both values is meant, nobody knows."""

import json
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.apps.foxglove import services
from lbr.apps.mqtt import documents
from lbr.apps.web import routing
from lbr.apps.web.api import page_message
from lbr.apps.web.api.page_message import Rubbish
from lbr.apps.web.face import Refused
from lbr.bus import codec
from lbr.errors import InputError, MalformedError
from lbr.messages.drive import DriveCommand
from lbr.messages.unreadable import keyed_once
from lbr.robots.lbr.original import wishes

DOORS = {
    "a command on the bus": codec.Decoder(DriveCommand, command=True).decode,
    "a request over HTTP": lambda body: routing.decoded(body, Any),
    "a page": page_message.parse,
    "the old API": wishes.asked,
    "MQTT": documents.read,
    "Foxglove": services.read,
}
TWICE = (
    b'{"level": 0.1, "power": 0.1, "angle_deg": 90, "power": 0.4}',
    b'{"level": 0.1, "power": 0.1, "hold": {"to": "drive/command", "n": 1, "n": 2}}',
)


@pytest.mark.parametrize("body", TWICE)
@pytest.mark.parametrize("door", DOORS.values(), ids=DOORS)
def test_a_key_that_stands_twice_is_refused(door, body):
    with pytest.raises((Refused, Rubbish, InputError, MalformedError)) as refused:
        door(body)
    assert "'power'" in str(refused.value) or "'n'" in str(refused.value)


@given(
    st.recursive(
        st.none() | st.floats() | st.text(),
        lambda some: st.lists(some, max_size=4) | st.dictionaries(st.text(), some, max_size=4),
        max_leaves=12,
    )
)
def test_other_json_is_left_as_it_is(value):
    data = json.dumps(value).encode()
    assert keyed_once(data) is data


@given(st.binary())
def test_what_is_not_json_is_left_to_the_decoder(data):
    assert keyed_once(data) is data
