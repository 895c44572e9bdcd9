from typing import Any

import pytest

from lbr.apps.cameras.kind import KIND
from lbr.messages.camera import CameraState, SelectCommand
from lbr.messages.leases import CommandReply
from lbr.testing import FakeCall, FakeContext


class Bus(FakeContext):
    """The cameras on the other side: each does as told, or answers what `says` has for it."""

    def __init__(self, *cameras: str) -> None:
        super().__init__(KIND, name="cameras")
        self.now = 0.0
        self.cameras = cameras
        self.says: dict[str, CommandReply | None] = {}
        self.silent = False

    def targets(self, request: str) -> tuple[str, ...]:
        assert request == "switch"
        return self.cameras

    def answer(self, request: str, message: Any) -> dict[str, CommandReply | None] | None:
        return (
            None if self.silent else {name: self.says.get(name, CommandReply(accepted=True)) for name in self.cameras}
        )

    @property
    def switched(self) -> list[tuple[str, bool]]:
        """Which camera was told what."""
        return [(name, asked.message.on) for asked in self.asked for name in self.cameras if name in asked.only]

    def state(self, name: str, *, on: bool) -> None:
        state = CameraState(on=on, phase="streaming" if on else "off", device="/dev/video0")
        self.arrive("states", state, source=name)


@pytest.fixture
def bus():
    return Bus("camera_front", "camera_rear", "periscope")


@pytest.fixture
def cameras(bus):
    return KIND.load()(bus)


def select(cameras, name):
    call = FakeCall("select", SelectCommand(name=name))
    cameras.command(call)
    return call.answer


def test_the_others_go_off_before_the_named_one_comes_on(cameras, bus):
    assert select(cameras, "rear").accepted
    assert bus.switched == [("camera_front", False), ("periscope", False), ("camera_rear", True)]


def test_off_switches_all_off(cameras, bus):
    assert select(cameras, "off").accepted
    assert bus.switched == [(name, False) for name in bus.cameras]


def test_a_camera_named_otherwise_has_its_whole_name(cameras, bus):
    assert select(cameras, "periscope").accepted
    assert bus.switched[-1] == ("periscope", True)


def test_a_single_camera_can_be_selected(bus):
    bus.cameras = ("camera_front",)
    assert select(KIND.load()(bus), "front").accepted
    assert bus.switched == [("camera_front", True)]


def test_an_unknown_name_is_refused_with_those_there_are(cameras, bus):
    said = select(cameras, "side")
    assert not said.accepted
    assert said.reason == "there is no camera 'side'; there are front, rear, periscope, off"
    assert bus.switched == []


def test_whoever_asked_is_told_which_camera_failed(cameras, bus):
    bus.says = {
        "camera_front": CommandReply(accepted=False, reason="not closed yet"),
        "camera_rear": None,
    }
    said = select(cameras, "rear")
    assert not said.accepted
    assert said.reason == "front: not closed yet; rear: no answer"
    assert bus.switched[-1] == ("camera_rear", True)


def test_one_selection_after_the_other_and_not_without_end(cameras, bus):
    bus.silent = True
    calls = [
        FakeCall("select", SelectCommand(name="front")),
        *(FakeCall("select", SelectCommand(name="rear")) for _ in range(9)),
    ]
    for call in calls:
        cameras.command(call)
    assert [call.answer is not None for call in calls] == [False] * 9 + [True]
    assert "still being switched" in calls[-1].answer.reason
    assert bus.switched == [("camera_rear", False), ("periscope", False)]
    bus.silent = False
    bus.asked[-1].given = bus.answer("switch", None)
    cameras.step()
    assert all(call.answer.accepted for call in calls[:-1])
    assert bus.switched[-1] == ("camera_rear", True)


def test_the_state_tells_which_is_on_at_once_and_every_second(cameras, bus):
    cameras.step()
    assert bus.said("state") == [], "a camera that lives has not told its state"
    for name in bus.cameras:
        bus.state(name, on=False)
    cameras.step()
    assert bus.said("state")[-1].selected == "off"
    bus.state("camera_front", on=True)
    cameras.step()
    assert bus.said("state")[-1].selected == "front"
    assert bus.said("state")[-1].cameras["rear"].phase == "off"
    cameras.step()
    assert len(bus.said("state")) == 2
    bus.now = 1.1
    cameras.step()
    assert len(bus.said("state")) == 3


def test_a_camera_whose_process_is_gone_is_not_on(cameras, bus):
    bus.now = 1.1
    bus.state("camera_front", on=True)
    cameras.step()
    bus.gone |= set(bus.cameras)
    cameras.step()
    assert bus.said("state")[-1].selected == "off"
    assert bus.said("state")[-1].cameras == {}
