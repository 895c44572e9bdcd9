"""What a package says of how its device is recognised is checked before any line is opened."""

import pytest

from lbr.capability.kind import Kind, KindError, NoSettings, OnDevice
from lbr.capability.recognition import NameHandshake, Seen, handshakes
from lbr.drivers import recognising
from tests.support.packages import imported_from

MODULE = "from lbr.capability.recognition import SerialHandshake\nHANDSHAKE = SerialHandshake({})\n"
KIND = Kind(
    name="crab",
    summary="a crab",
    family="driver",
    entry="crab:Crab",
    settings=NoSettings,
    device=OnDevice("crab", recognised="crab_recognition:HANDSHAKE"),
)


@pytest.mark.parametrize(
    "said",
    [
        "baud='x', seen=print",
        "baud=0, seen=print",
        "baud=9600, seen=None",
        "baud=9600, seen=print, questions=(b'?')",
        "baud=9600, seen=print, questions=('?',)",
        "baud=9600, seen=print, questions=(b'?',) * 65",
    ],
)
def test_what_cannot_be_asked_is_told_with_kind_and_field(tmp_path, said, wording):
    (tmp_path / "crab_recognition.py").write_text(MODULE.format(said))
    with imported_from(tmp_path), pytest.raises(KindError) as caught:
        handshakes(KIND)
    wording(caught.value)


@pytest.mark.parametrize(
    ("answer", "known"), [(Seen(what="a crab"), True), ("a crab", False), (True, False), (None, False)]
)
def test_only_what_was_seen_is_recognised(answer, known):
    handshake = NameHandshake(place="video", seen=lambda _name: answer)
    assert (recognising.by_name("video", "Crab", {"crab": (handshake,)}) is not None) is known
