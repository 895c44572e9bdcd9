from types import SimpleNamespace
from typing import Any

import pytest

from lbr.apps.cameras import KIND
from lbr.capability.context import Received
from lbr.messages.camera import CameraState, SelectCommand
from lbr.messages.leases import CommandReply
from tests.support.replies import refusal


class Bus:
    """The cameras on the other side: each does as told, or answers what `says` has for it."""

    name = "cameras"

    def __init__(self, *cameras: str) -> None:
        self.cameras = cameras
        self.living = set(cameras)
        self.asked: list[tuple[str, bool]] = []
        self.says: dict[str, CommandReply | None] = {}
        self.published: list[Any] = []
        self.inbox: list[Received] = []
        self.silent = False
        self.now = 0.0

    def clock(self) -> float:
        return self.now

    def targets(self, request: str) -> tuple[str, ...]:
        assert request == "switch"
        return self.cameras

    def alive(self, capability: str) -> bool:
        return capability in self.living

    def take(self, port: str) -> list[Received]:
        taken, self.inbox = self.inbox, []
        return taken

    def ask(self, request: str, message: Any, timeout_s: float, *, only: Any = None) -> Any:
        self.asked += [(name, message.on) for name in self.cameras if name in only]
        answers = {name: self.says.get(name, CommandReply(accepted=True)) for name in self.cameras if name in only}
        return SimpleNamespace(answers=lambda: None if self.silent else answers)

    def publish(self, output: str, message: Any) -> None:
        self.published.append(message)

    def state(self, name: str, *, on: bool) -> None:
        state = CameraState(on=on, phase="streaming" if on else "off", device="/dev/video0")
        self.inbox.append(Received(state, None, self.now, name))


class Call:
    def __init__(self, name: str) -> None:
        self.message = SelectCommand(name=name)
        self.name = "select"
        self.answer: CommandReply | None = None

    def reply(self, answer: CommandReply) -> None:
        assert self.answer is None
        self.answer = answer

    def refuse(self, reason: str, code: str = "refused") -> None:
        self.reply(refusal(reason, code))


@pytest.fixture
def bus():
    return Bus("camera_front", "camera_rear", "periscope")


@pytest.fixture
def cameras(bus):
    return KIND.load()(bus)


def select(cameras, name):
    call = Call(name)
    cameras.command(call)
    return call.answer


def test_the_others_go_off_before_the_named_one_comes_on(cameras, bus):
    assert select(cameras, "rear").accepted
    assert bus.asked == [("camera_front", False), ("periscope", False), ("camera_rear", True)]


def test_off_switches_all_off(cameras, bus):
    assert select(cameras, "off").accepted
    assert bus.asked == [(name, False) for name in bus.cameras]


def test_a_camera_named_otherwise_has_its_whole_name(cameras, bus):
    assert select(cameras, "periscope").accepted
    assert bus.asked[-1] == ("periscope", True)


def test_a_single_camera_can_be_selected(bus):
    bus.cameras = ("camera_front",)
    assert select(KIND.load()(bus), "front").accepted
    assert bus.asked == [("camera_front", True)]


def test_an_unknown_name_is_refused_with_those_there_are(cameras, bus):
    said = select(cameras, "side")
    assert not said.accepted
    assert said.reason == "there is no camera 'side'; there are front, rear, periscope, off"
    assert bus.asked == []


def test_whoever_asked_is_told_which_camera_failed(cameras, bus):
    bus.says = {
        "camera_front": CommandReply(accepted=False, reason="its device is not closed yet"),
        "camera_rear": None,
    }
    said = select(cameras, "rear")
    assert not said.accepted
    assert said.reason == "front: its device is not closed yet; rear: no answer"
    assert bus.asked[-1] == ("camera_rear", True)


def test_one_selection_after_the_other_and_not_without_end(cameras, bus):
    bus.silent = True
    calls = [Call("front"), *(Call("rear") for _ in range(9))]
    for call in calls:
        cameras.command(call)
    assert [call.answer is not None for call in calls] == [False] * 9 + [True]
    assert "still being switched" in calls[-1].answer.reason
    assert bus.asked == [("camera_rear", False), ("periscope", False)]
    bus.silent = False
    cameras.step()
    assert all(call.answer.accepted for call in calls[:-1])
    assert bus.asked[-1] == ("camera_rear", True)


def test_the_state_tells_which_is_on_at_once_and_every_second(cameras, bus):
    cameras.step()
    assert bus.published[-1].selected == "off"
    bus.state("camera_front", on=True)
    bus.state("camera_rear", on=False)
    cameras.step()
    assert bus.published[-1].selected == "front"
    assert bus.published[-1].cameras["rear"].phase == "off"
    cameras.step()
    assert len(bus.published) == 2
    bus.now = 1.1
    cameras.step()
    assert len(bus.published) == 3


def test_a_camera_whose_process_is_gone_is_not_on(cameras, bus):
    bus.state("camera_front", on=True)
    cameras.step()
    bus.living = set()
    cameras.step()
    assert bus.published[-1].selected == "off"
    assert bus.published[-1].cameras == {}
