"""The running world of a UXA-90: its main board on a real tty, its head's camera on a real socket, in real time."""

import queue
import threading
import time

import msgspec
import numpy as np
import pytest
import serial
from PIL import Image

from lbr.capability.context import Device
from lbr.simulation.balls import Ball
from lbr.simulation.humanoid import KIND
from lbr.simulation.humanoid.capability import HumanoidWorld
from lbr.simulation.requests import BallRequest, HandRequest, PickUpRequest, PictureRequest
from lbr.testing import FakeCall
from tests.models.uxa90.robot import humanoid, joints, settings
from tests.simulation.camera_bench import Film, orange
from tests.simulation.world_bench import WorldContext
from tests.support.waiting import HANG_S

BUTTON = bytes.fromhex("ff ff aa 55 aa 55 37 ba 14 00 00 00 00 01")
NOD = 14


class Stage:
    """A world, run by a thread as its process would."""

    def __init__(self, folder):
        self.line, self.eye = folder / "main_board", folder / "head_camera"
        nod = {"frames": [{"duration_s": 0.2, "counts": {"24": 150}}]}
        devices = (
            Device("main_board", "uxa90", str(self.line), {"programmes": {str(NOD): nod}}),
            Device("head_camera", "camera", f"unix:{self.eye}", {}),
        )
        self.ctx = WorldContext(settings(), devices, kind=KIND)
        self.ctx.robot, self.ctx.home, self.ctx.given = "uxa90", str(folder), joints()
        self.world = HumanoidWorld(self.ctx)
        self.over = threading.Event()
        self.calls = queue.SimpleQueue()
        self.thread = threading.Thread(target=self._step)

    def _step(self):
        while not self.over.wait(0.01):
            while not self.calls.empty():
                call, taken = self.calls.get()
                self.world.command(call)
                taken.set()
            self.world.step()

    def ask(self, name, message):
        """Have its thread take a command between two steps, as its process would."""
        call, taken = FakeCall(name, message), threading.Event()
        self.calls.put((call, taken))
        assert self.until(taken.is_set)
        return call

    def until(self, condition):
        end, pause = time.monotonic() + HANG_S, threading.Event()
        while not condition() and time.monotonic() < end:
            pause.wait(0.01)
        return condition()


@pytest.fixture(scope="module")
def stage(tmp_path_factory):
    made = Stage(tmp_path_factory.mktemp("stage"))
    made.world.open()
    made.thread.start()
    yield made
    made.over.set()
    made.thread.join()
    made.world.close()


@pytest.mark.parametrize(("path", "reach"), [("rest", (0.0, 0.0)), ("to_and_fro", (0.4, 0.0)), ("circle", (0.4, 0.4))])
def test_a_ball_keeps_to_its_path(path, reach):
    engine = humanoid(balls={"ball": Ball(path=path, reach_m=0.4, period_s=2.0)})
    body, seen = engine.data.body("ball ball"), []
    for _ in range(50):
        engine.step({}, 0.04)
        seen.append(engine.data.mocap_pos[engine.body.model.body_mocapid[body.id]] - (1.0, 0.0, 0.9))
    assert np.abs(seen).max(axis=0) == pytest.approx((0.0, *reach), abs=0.01)


def test_the_cameras_socket_shows_what_its_head_sees(stage):
    assert "ball" in stage.ask("ball", BallRequest(name="moon")).refused
    assert stage.ask("ball", BallRequest(x_m=1.0, y_m=0.0, z_m=0.6)).answer.accepted
    assert stage.ask("hand", HandRequest(joint="head_pitch", angle_deg=0.0)).answer.accepted, "limp, it sinks in 30 s"
    with Film(stage.eye, width=160, height=120, fps=30) as film:
        while orange(film.frame()[0]) is None:
            pass
    assert stage.ask("hand", HandRequest(gone=True)).answer.accepted


def test_a_button_of_the_remote_control_moves_it_and_a_picture_shows_it(stage, tmp_path):
    assert stage.ctx.health == []
    assert stage.until(lambda: stage.ctx.said("pose"))
    assert not stage.ctx.said("pose")[-1].stands
    with serial.Serial(str(stage.line), 115_200, timeout=HANG_S, exclusive=True) as tty:
        tty.write(BUTTON + bytes((NOD, NOD)))
        assert tty.read(8) == BUTTON[:8], "it answers when the motion is over"
    assert stage.until(lambda: stage.ctx.said("pose")[-1].joints["head_pitch"] == pytest.approx(0.43, abs=0.06))
    assert stage.ctx.said("pose")[-1].supply_v == pytest.approx(18.5, abs=1.0)
    path = tmp_path / "it.png"
    call = stage.ask("picture", PictureRequest(path=str(path), width_px=600, height_px=400))
    assert stage.until(lambda: call.answer is not None)
    with Image.open(path) as drawn:
        robot = (np.asarray(drawn.convert("RGB"))[60:350] != (250, 250, 247)).any(axis=2)
        assert 0.02 < robot.mean() < 0.5
    assert "if it has torque" in stage.ask("pick_up", PickUpRequest()).answer.reason
    assert stage.until(lambda: stage.ctx.said("pose")[-1].held), "its head has torque"


def test_who_stands_up_sits_down_or_falls_is_told_of(tmp_path):
    world = Stage(tmp_path).world
    sitting = humanoid().pose()
    standing = msgspec.structs.replace(sitting, stands=True)
    lying = msgspec.structs.replace(sitting, upright=False, pitch_rad=1.5)
    for pose in (sitting, standing, standing, sitting, standing, lying):
        world._tell(pose)
    assert [kind for kind, _ in world.ctx.events] == ["stands", "sits", "stands", "fallen"]
    assert "pitched 86 degrees; pick_up puts it as it began" in world.ctx.events[-1][1]
