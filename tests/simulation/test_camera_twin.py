"""Emulated cameras: what they show, on the socket that a driver reads and with every fault."""

import os
import socket
import subprocess
import sys
import threading
import time

import pytest

from lbr.capability.context import Device
from lbr.errors import InputError, LbrError
from lbr.simulation.cameras import studio as studios
from lbr.simulation.cameras.host import CameraHost
from lbr.simulation.cameras.orders import Drawing
from lbr.simulation.cameras.studio import Studio
from lbr.simulation.cameras.view import SharedView
from lbr.simulation.devices.camera import CameraFaults
from lbr.simulation.engine import Engine
from lbr.simulation.messages import WorldBox
from lbr.simulation.physics import unpacked
from lbr.simulation.requests import PlaceRequest, RemoveRequest
from lbr.simulation.settings import WorldSettings
from tests.simulation.camera_bench import Film, like, picture
from tests.simulation.world_bench import Bench
from tests.support.waiting import until

SOUND = CameraFaults()
RED, SKY = (204, 64, 51), (184, 207, 229)


class Set(Bench):
    """A world with two cameras, run by a thread as its process would."""

    def __init__(self, folder):
        super().__init__(folder, walls=())
        self.folder = folder
        names = ("camera_front", "camera_rear")
        self.ctx.devices = tuple(Device(name, "camera", f"unix:{folder / name}", {}) for name in names)
        self.over = threading.Event()
        self.thread = threading.Thread(target=self._step)

    def _step(self):
        while not self.over.wait(0.01):
            self.world.step()

    def film(self, name="camera_front", **wanted):
        return Film(self.folder / name, **({"width": 64, "height": 48, "fps": 30} | wanted))


@pytest.fixture(scope="module")
def stage(tmp_path_factory):
    made = Set(tmp_path_factory.mktemp("stage"))
    made.world.open()
    made.thread.start()
    yield made
    made.over.set()
    made.thread.join()
    made.world.close()


@pytest.fixture
def mended(stage):
    """Whatever a test breaks is whole again after it."""
    yield stage
    for name in CameraFaults.__struct_fields__:
        stage.fault("camera_front", name, None)


def test_pictures_come_with_the_size_asked_for_and_the_time_they_were_taken(stage):
    with stage.film(width=160, height=90, fps=60) as film:
        before, stamps = time.monotonic_ns(), []
        for _ in range(5):
            jpeg, taken_ns = film.frame()
            assert picture(jpeg).size == (160, 90)
            stamps.append(taken_ns)
        assert stamps == sorted(set(stamps)), "each is a later one"
        assert before < stamps[-1] <= time.monotonic_ns()
    assert ("cameras_drawn" in {kind for kind, _ in stage.ctx.events}) == (not stage.ctx.health)


def test_front_and_rear_look_their_own_ways(stage):
    stage.ask("place", PlaceRequest(x_m=1.5, y_m=0.0, width_m=2.0, height_m=2.0))
    try:
        with stage.film() as front, stage.film("camera_rear") as rear:
            while not like(picture(front.frame()[0]).getpixel((32, 24)), RED):
                pass
            assert not like(picture(rear.frame()[0]).getpixel((32, 24)), RED)
    finally:
        stage.ask("remove", RemoveRequest())


def test_a_later_line_changes_the_size_and_controls_are_taken(stage):
    with stage.film() as film:
        assert picture(film.frame()[0]).size == (64, 48)
        film.ask(controls={"brightness": 17})
        film.ask(width=32, height=32)
        while picture(film.frame()[0]).size != (32, 32):
            pass


@pytest.mark.parametrize("line", [b"hello\n", b'{"width": -1}\n', b'{"fps": 0}\n', b"[]\n", b"x" * 5000])
def test_nonsense_ends_that_connection_alone(stage, line):
    with stage.film() as other, Film(stage.folder / "camera_front") as film:
        film.connection.sendall(line)
        assert film.frame() is None
        assert other.frame()


def test_who_asks_for_nothing_gets_nothing(stage):
    with Film(stage.folder / "camera_front") as film, stage.film() as other:
        for _ in range(3):
            other.frame()
        film.connection.settimeout(0.01)
        with pytest.raises(TimeoutError):
            film.connection.recv(1)


def test_who_is_slow_misses_pictures_and_finds_none_that_waited(stage):
    with stage.film(fps=60) as slow, stage.film(fps=60) as quick:
        slow.frame()
        for _ in range(20):
            _, newest_ns = quick.frame()
        waited = [slow.frame()[1] for _ in range(2)]
        assert waited[1] >= newest_ns, "one was under way, the next is new"


def test_black_frozen_and_garbage_show(mended):
    with mended.film() as film:
        mended.fault("camera_front", "black")
        while max(picture(film.frame()[0]).getpixel((32, 5))) > 10:
            pass
        mended.fault("camera_front", "black", None)
        mended.fault("camera_front", "frozen")
        while (jpeg := film.frame())[0] != (following := film.frame())[0]:
            pass
        assert following[1] > jpeg[1], "the same, but new"
        mended.fault("camera_front", "garbage")
        while film.frame()[0][:2] == b"\xff\xd8":
            pass


def test_a_slow_camera_shows_two_pictures_a_second_and_a_stalled_one_none(mended):
    with mended.film() as film, mended.film("camera_rear") as other:
        mended.fault("camera_front", "slow")
        for _ in range(8):
            other.frame()
        (_, first), (_, second) = film.frame(), film.frame()
        while second - first < 400_000_000:
            first, second = second, film.frame()[1]
        mended.fault("camera_front", "stalled")
        for _ in range(8):
            other.frame()
        film.connection.settimeout(0.05)
        with pytest.raises(TimeoutError):
            list(iter(lambda: film.connection.recv(65536), b""))


def test_unplugged_it_is_gone_and_replugged_it_shows_again(mended):
    with mended.film() as film, mended.film("camera_rear") as other:
        film.frame()
        mended.fault("camera_front", "unplug")
        while film.frame():
            pass
        while (mended.folder / "camera_front").exists():
            mended.over.wait(0.001)
        assert other.frame(), "the other one goes on"
    mended.fault("camera_front", "replug")
    while not (mended.folder / "camera_front").exists():
        mended.over.wait(0.001)
    with mended.film() as film:
        assert film.frame()


def test_a_drawing_process_that_dies_is_replaced_when_somebody_watches(stage):
    with stage.film() as film:
        film.frame()
        stage.world._cameras._process.kill()
        while film.frame():
            pass

    def shows():
        with stage.film() as film:
            return film.frame()

    until(shows, what="a picture again")


# What draws, without a socket.


def drawn(use_gl, thing=None):
    settings = WorldSettings(walls=(), dock=None)
    engine = Engine(settings)
    if thing:
        engine.place(thing)
    engine.step(0.0, 0.0, 0.008)
    view = SharedView(len(engine.view()))
    view.write(engine.view(), 7)
    studio = Studio(unpacked(engine.packed()), view, use_gl=use_gl)
    assert studio.newest_ns() == 7
    shown = picture(studio.picture("camera", "front", (160, 120), SOUND))
    name = studio.renderer
    studio.close()
    view.close()
    return name, shown


LEFT_OF_IT = WorldBox(name="thing", x_m=1.5, y_m=0.45, length_m=0.2, width_m=0.3, height_m=0.9)


@pytest.mark.parametrize("use_gl", [True, False])
def test_a_thing_to_the_left_is_on_the_left_and_the_sky_above(use_gl):
    name, shown = drawn(use_gl, LEFT_OF_IT)
    if use_gl and name == "rays":
        pytest.skip("this machine draws no OpenGL without a screen")
    red = [at for at in range(160) if like(shown.getpixel((at, 80)), RED)]
    assert red
    assert max(red) < 80
    assert like(shown.getpixel((80, 2)), SKY)
    assert not like(shown.getpixel((120, 110)), SKY)


def test_the_renderer_is_given_back_a_minute_after_the_last_look_and_begun_again_by_the_next():
    engine = Engine(WorldSettings(walls=(), dock=None))
    view = SharedView(len(engine.view()))
    view.write(engine.view(), 7)
    studio = Studio(unpacked(engine.packed()), view, use_gl=True)
    studio.newest_ns()
    first = studio.picture("camera", "front", (160, 120), SOUND)
    held = []
    for now, watched in ((0.0, True), (59.0, True), (118.0, False), (119.0, False)):
        studio.rest(now, watched=watched)
        held.append(studio.holds_renderer)
    assert held == [True, True, True, False]
    assert studio.picture("camera", "front", (160, 120), SOUND) == first, "nothing has moved"
    assert not studio.holds_renderer
    rear = studio.picture("camera", "rear", (160, 120), SOUND)
    studio.rest(500.0, watched=False)
    assert studio.holds_renderer
    assert picture(rear).size == (160, 120)
    studio.close()
    view.close()


def test_without_pillow_it_says_what_to_install(monkeypatch):
    def missing(name):
        raise ImportError(f"No module named '{name}'")

    monkeypatch.setattr(studios.importlib, "import_module", missing)
    view = SharedView(8)
    with pytest.raises(LbrError, match="extra 'sim'"):
        Studio(None, view, use_gl=False)
    view.close()


def test_a_view_is_whole_or_not_there():
    view = SharedView(4)
    assert view.read() is None
    view.write(b"abcd", 5)
    other = SharedView(4, os.dup(view.descriptor))
    assert other.read() == (5, b"abcd")
    view._memory[-1:] = b"x"
    assert other.read() is None, "half of another one"
    view.close()
    other.close()


def start(code):
    """A drawing process that does something else."""
    real = subprocess.Popen
    return lambda arguments, **options: real([sys.executable, "-I", "-S", "-c", code, arguments[-1]], **options)


def watched(monkeypatch, code, *, ended=False):
    """What a host says whose process does that, and whether it would try OpenGL again."""
    begin = start(code)

    def begun(*words, **options):
        process = begin(*words, **options)
        if ended:
            process.wait()
        return process

    monkeypatch.setattr(subprocess, "Popen", begun)
    host, said = CameraHost(b"", 8, clock=lambda: 0.0), []
    ours, theirs = socket.socketpair()
    host.watch("camera", "front", theirs)
    said += host.serve()
    while host.running:
        said += host.serve()
    ours.settimeout(2)
    assert ours.recv(1) == b"", "who watched is told by the end of the connection"
    ours.close()
    host.close()
    return said, host._use_gl


def test_graphics_that_take_the_process_down_are_not_asked_again(monkeypatch):
    assert watched(monkeypatch, "import os; os.kill(os.getpid(), 11)") == ([], False)


@pytest.mark.parametrize("ended", [False, True])
def test_a_process_that_cannot_draw_says_why(monkeypatch, ended):
    code = """import socket, sys
socket.socket(fileno=int(sys.argv[1])).send(b'{"renderer": "", "note": "no Pillow"}')"""
    assert watched(monkeypatch, code, ended=ended) == ([Drawing("", "no Pillow")], True)


def test_what_lies_in_the_current_directory_is_not_run(monkeypatch, tmp_path):
    (tmp_path / "msgspec.py").write_text("raise SystemExit('not this one')")
    monkeypatch.chdir(tmp_path)
    host, said = CameraHost(Engine(WorldSettings(walls=())).packed(), 8), []
    ours, theirs = socket.socketpair()
    host.watch("camera", "front", theirs)
    until(lambda: said.extend(host.serve()) or said)
    host.close()
    ours.close()
    assert [told.renderer != "" for told in said] == [True]


def test_a_mount_that_is_not_there_is_named(tmp_path):
    bench = Bench(tmp_path)
    bench.ctx.devices = (Device("eye", "camera", f"unix:{tmp_path / 'eye'}", {"mount": "top"}),)
    with pytest.raises(InputError, match=r"device 'eye'.*mount 'top'.*front, rear"):
        bench.world.open()
    bench.world.close()
