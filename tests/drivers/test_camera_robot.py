"""Two cameras and their selection as processes of a robot, with pictures on sockets."""

import tempfile
import threading
from pathlib import Path

import pytest

from lbr.bus import wire
from tests.drivers.camera_peers import PictureSocket, jpeg
from tests.support.commands import here
from tests.support.robot import prepare, running
from tests.support.waiting import until

NAMES = ("front", "rear")


@pytest.fixture(scope="module")
def place():
    with tempfile.TemporaryDirectory(prefix="lbr-") as place:
        yield Path(place)


@pytest.fixture(scope="module")
def sources(place):
    """Send a picture to whoever is connected, twenty times a second."""
    sources = {name: PictureSocket(place / name) for name in NAMES}
    over = threading.Event()

    def send() -> None:
        while not over.wait(0.05):
            for number, source in enumerate(sources.values()):
                if source.connected:
                    try:
                        source.send(jpeg(number))
                    except (OSError, AssertionError):
                        continue  # it hung up in between

    thread = threading.Thread(target=send)
    thread.start()
    yield sources
    over.set()
    thread.join()
    for source in sources.values():
        source.close()


@pytest.fixture(scope="module")
def robot(place, sources):
    edits = (
        "UPDATE capability SET enabled = 0 WHERE name NOT GLOB 'camera*'",
        *(f"UPDATE device SET address = 'unix:{place / name}' WHERE name = '{name}_camera'" for name in NAMES),
    )
    home = prepare(place / "h", *(f"camera_{name}" for name in NAMES), "cameras", edits=edits)
    with running(home, profile="lbr") as robot:
        yield robot


def picture(robot, name):
    answers = wire.ask(robot.bus, f"lbr/camera_{name}/frame", None, source="test", timeout_s=2.0)
    return answers[0].payload if answers else None


def chosen(robot, name):
    """Select a camera, again where a busy machine held up one that was to be switched off or on."""
    until(lambda: robot.line(f"/camera/{name}")["code"] == 0, what=f"camera {name}")


def test_the_selected_camera_is_open_and_nothing_is_left_of_the_other(robot, sources):
    until(lambda: picture(robot, "front") == jpeg(0), what="a picture")
    assert not sources["rear"].connected
    chosen(robot, "rear")
    assert not sources["front"].connected
    assert picture(robot, "front") is None
    until(lambda: picture(robot, "rear") == jpeg(1), what="a picture")
    until(lambda: robot.ask("cameras/state")["selected"] == "rear", what="its state")
    chosen(robot, "off")
    assert not sources["rear"].connected
    assert picture(robot, "rear") is None


def test_a_picture_is_echoed_as_what_it_is_and_saved(robot):
    chosen(robot, "front")
    until(lambda: picture(robot, "front"), what="a picture")
    assert here(robot.home, "topic", "echo", "camera_front/frame", "--once").stdout.startswith("JPEG, 640x360, ")
    said = robot.line("/snapshot/front/kitchen")
    assert said["code"] == 0, said
    assert (robot.home / "pictures" / "kitchen.jpg").read_bytes() == jpeg(0)


def test_a_camera_that_fails_is_named(robot, sources):
    sources["rear"].unplug()
    why = "rear: device 'rear_camera' at unix:"
    until(lambda: (said := robot.line("/camera/rear"))["code"] == 1 and why in said["text"], what=why)
    until(lambda: robot.ask("camera_rear/state")["on"] is False, what="it is off again")
