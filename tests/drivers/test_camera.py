import json
import re
import time

import pytest

from lbr.drivers.camera import KIND, capability
from lbr.drivers.camera.source import open_source
from lbr.errors import DeviceError
from lbr.messages.camera import SnapshotCommand, SwitchCommand
from lbr.testing import FakeCall
from tests.drivers.camera_peers import ERROR, CameraContext, PiCamera, PictureSocket, Webcam, jpeg
from tests.support import needs
from tests.support.waiting import HANG_S, until

ON = '{"device": "front", "on": true}'


@pytest.fixture
def source(tmp_path):
    source = PictureSocket(tmp_path / "front")
    yield source
    source.close()


@pytest.fixture
def webcam(monkeypatch):
    webcam = Webcam()
    webcam.install(monkeypatch)
    yield webcam
    webcam.close()


@pytest.fixture
def started(tmp_path, webcam, monkeypatch):
    """Start cameras, which wait for their threads however busy the machine is, and close them at the end."""
    for name in ("OFF_S", "ON_S", "CLOSE_S"):
        monkeypatch.setattr(capability, name, HANG_S)
    cameras = []

    def start(settings=ON, address=f"unix:{tmp_path / 'front'}"):
        ctx = CameraContext(KIND.parse(settings), address, tmp_path)
        camera = KIND.load()(ctx)
        cameras.append(camera)
        camera.open()
        camera.step()
        return camera, ctx

    yield start
    for camera in cameras:
        camera.close()


def stepped(camera, condition):
    until(lambda: (camera.step(), condition())[1])


def streaming(camera, ctx, source, count=1):
    """Have the socket send pictures until this many are published."""
    stepped(camera, lambda: source.connected)
    for mark in range(count):
        wanted = len(ctx.frames) + 1
        source.send(jpeg(mark))
        stepped(camera, lambda wanted=wanted: len(ctx.frames) == wanted)


def answer(camera, message):
    call = FakeCall("switch", message)
    camera.command(call)
    stepped(camera, lambda: call.answer is not None)
    return call.answer


def test_a_picture_goes_out_as_it_came_stamped_with_when_it_was_taken(started, source):
    camera, ctx = started()
    streaming(camera, ctx, source)
    ctx.woken.clear()
    taken_s = source.send(jpeg(7), age_s=0.2)
    assert ctx.woken.wait(HANG_S)  # the loop is not to wait for its next tick
    camera.step()
    assert ctx.frames == [jpeg(0), jpeg(7)]
    assert ctx.taken_s[-1] == pytest.approx(taken_s, abs=1e-6)


def test_what_the_row_wants_is_asked_of_the_source(started, source):
    camera, _ = started('{"device": "front", "on": true, "width_px": 320, "fps": 5, "controls": {"brightness": 17}}')
    stepped(camera, lambda: source.connected and source.heard.count(b"\n") == 2)
    wanted, controls = (json.loads(line) for line in source.heard.splitlines())
    assert wanted == {"width": 320, "height": 360, "fps": 5}
    assert controls == {"controls": {"brightness": 17}}


def test_a_camera_without_a_viewer_rests_and_is_awake_at_once_when_one_comes(started, source):
    camera, ctx = started('{"device": "front", "on": true, "fps": 20}')
    ctx.unwatched.add("frame")
    streaming(camera, ctx, source, count=2)
    stepped(camera, lambda: source.connected and source.heard.endswith(b'{"fps":2.0}\n'))
    sent = len(ctx.frames)
    for mark in range(5):
        source.send(jpeg(mark))
        stepped(camera, lambda: not camera._capture._slot)
    assert len(ctx.frames) <= sent + 1, "only two a second are published"
    stepped(camera, lambda: ctx.state.rests)
    ctx.unwatched.clear()
    stepped(camera, lambda: source.connected and source.heard.endswith(b'{"fps":20}\n'))
    streaming(camera, ctx, source, count=3)
    stepped(camera, lambda: not ctx.state.rests)


def test_the_state_tells_what_the_pictures_are_like(started, source):
    camera, ctx = started()
    assert ctx.state.phase == "opening"
    assert ctx.health == []  # no trouble yet
    streaming(camera, ctx, source)
    assert ctx.health[-1] == "ready"
    until(lambda: (streaming(camera, ctx, source), (ctx.state.fps or 0) > 1)[1])
    assert (ctx.state.on, ctx.state.phase) == (True, "streaming")
    assert ctx.state.frames > 2
    assert (ctx.state.width_px, ctx.state.height_px) == (640, 360)


def test_of_several_pictures_only_the_newest_goes_out(started, source):
    camera, ctx = started()
    streaming(camera, ctx, source)
    for mark in (1, 2, 3):
        source.send(jpeg(mark))
    until(lambda: camera._capture.dropped + len(camera._capture._slot) == 3)
    stepped(camera, lambda: ctx.frames[-1] == jpeg(3))
    assert len(ctx.frames) == 2
    assert camera._state().dropped == 2


def test_a_picture_that_is_broken_or_too_old_is_dropped_and_counted(started, source):
    camera, ctx = started()
    streaming(camera, ctx, source)
    for data, age_s in ((jpeg()[:-2], 0.0), (b"noise", 0.0), (jpeg(1), 5.0)):
        source.send(data, age_s=age_s)
    source.send(jpeg(2))
    stepped(camera, lambda: ctx.frames[-1] == jpeg(2))
    assert len(ctx.frames) == 2
    assert camera._state().dropped == 3


def test_a_camera_that_produces_nothing_publishes_nothing_and_is_lost(started, source):
    camera, ctx = started()
    streaming(camera, ctx, source)
    stepped(camera, lambda: ctx.state.phase == "lost")
    assert "no picture has come for 1.0 s" in ctx.state.reason
    assert ctx.health[-1].startswith("no picture has come")
    assert len(ctx.frames) == 1
    assert "frame" not in ctx.answered


def test_an_unplugged_camera_is_lost_and_comes_back_by_itself(started, source):
    camera, ctx = started()
    streaming(camera, ctx, source)
    source.unplug()
    stepped(camera, lambda: ctx.state.phase == "lost")
    assert "'front' at unix:" in ctx.state.reason
    assert "frame" not in ctx.answered
    source.replug()
    streaming(camera, ctx, source)
    assert ctx.state.phase == "streaming"
    assert ctx.health[-1] == "ready"


def test_noise_in_place_of_a_length_makes_it_connect_anew(started, source):
    camera, ctx = started()
    streaming(camera, ctx, source)
    source.send_raw(b"\xff" * 64)
    stepped(camera, lambda: source.clients == 2)
    streaming(camera, ctx, source)


def test_off_closes_the_device_and_leaves_no_picture_behind(started, source):
    camera, ctx = started()
    streaming(camera, ctx, source)
    assert answer(camera, SwitchCommand(on=False)).accepted
    assert not source.connected
    assert (ctx.state.on, ctx.state.phase) == (False, "off")
    assert ctx.health[-1] == "ready"
    assert "frame" not in ctx.answered
    seen = len(ctx.frames)
    camera.step()
    assert len(ctx.frames) == seen


def test_a_camera_that_is_off_at_the_start_opens_nothing(started, source):
    camera, ctx = started('{"device": "front"}')
    camera.step()
    assert (ctx.state.on, ctx.state.phase) == (False, "off")
    assert source.clients == 0


def test_on_is_answered_once_pictures_come(started, source):
    camera, ctx = started('{"device": "front"}')
    call = FakeCall("switch", SwitchCommand(on=True))
    camera.command(call)
    stepped(camera, lambda: source.connected)
    assert call.answer is None
    source.send(jpeg())
    stepped(camera, lambda: call.answer is not None)
    assert call.answer.accepted
    assert ctx.frames == [jpeg()]


def test_on_is_refused_with_the_reason_if_the_device_is_missing_and_the_camera_stays_off(started):
    camera, ctx = started('{"device": "front"}')
    said = answer(camera, SwitchCommand(on=True))
    assert not said.accepted
    assert "device 'front'" in said.reason
    stepped(camera, lambda: ctx.state.phase == "off")
    assert not ctx.state.on


def test_a_lost_camera_can_be_switched_off(started):
    camera, ctx = started()
    stepped(camera, lambda: ctx.state.phase == "lost")
    assert answer(camera, SwitchCommand(on=False)).accepted
    assert ctx.state.phase == "off"


def test_the_last_of_two_switches_counts(started, source):
    camera, ctx = started()
    streaming(camera, ctx, source)
    off, on = FakeCall("switch", SwitchCommand(on=False)), FakeCall("switch", SwitchCommand(on=True), source="somebody")
    camera.command(off)
    camera.command(on)
    assert not off.answer.accepted
    assert "somebody" in off.answer.reason
    stepped(camera, lambda: source.clients == 2)
    source.send(jpeg(9))
    stepped(camera, lambda: on.answer is not None)
    assert on.answer.accepted
    assert ctx.frames[-1] == jpeg(9)


def test_a_camera_that_was_switched_off_stays_off_when_its_process_begins_anew(started, source):
    camera, ctx = started()
    streaming(camera, ctx, source)
    assert answer(camera, SwitchCommand(on=False)).accepted
    again, ctx = started()
    again.step()
    assert (ctx.state.on, ctx.state.phase) == (False, "off")


def test_in_another_run_of_the_robot_the_row_says_whether_it_is_on(started, source, tmp_path):
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "tester-camera_front.switch").write_text("1 1 off\n")
    _, ctx = started()
    assert ctx.state.on


def test_a_snapshot_is_the_newest_picture_in_a_file_for_the_owner_alone(started, source, tmp_path):
    camera, ctx = started()
    streaming(camera, ctx, source)
    said = answer(camera, SnapshotCommand(name="kitchen"))
    path = tmp_path / "pictures" / "kitchen.jpg"
    assert said.path == str(path)
    assert path.read_bytes() == jpeg(0)
    assert path.stat().st_mode & 0o777 == 0o600
    again = answer(camera, SnapshotCommand(name="kitchen"))
    assert not again.accepted
    assert "there already" in again.reason
    assert answer(camera, SnapshotCommand()).path.startswith(str(tmp_path / "pictures" / "camera_front-"))


@pytest.mark.parametrize("name", ["../../x", "/etc/x", "a/b", ".hidden", "a\0b", "ä"])
def test_a_snapshots_name_leads_nowhere_else(started, source, tmp_path, name):
    camera, ctx = started()
    streaming(camera, ctx, source)
    said = answer(camera, SnapshotCommand(name=name))
    assert not said.accepted
    assert "letters, digits" in said.reason
    assert not list(tmp_path.rglob("*.jpg"))


def test_there_is_no_snapshot_of_a_camera_that_is_off(started):
    camera, _ = started('{"device": "front"}')
    assert answer(camera, SnapshotCommand()).reason == "camera_front is off"


@pytest.mark.parametrize(
    ("settings", "address", "words"),
    [
        (ON, "usb:1234", "not one of /dev/videoN"),
        (ON, "csi:front", "the first is csi:0"),
        ('{"device": "front", "on": true, "rotation_deg": 180}', "/dev/video0", "leave out rotation_deg"),
    ],
)
def test_an_address_that_is_none_is_told(started, settings, address, words, monkeypatch):
    PiCamera().install(monkeypatch)
    camera, ctx = started(settings, address)
    stepped(camera, lambda: ctx.state.phase == "lost")
    assert words in ctx.state.reason


def test_of_a_v4l2_buffer_only_the_used_bytes_go_out(started, webcam):
    camera, ctx = started(address="/dev/video0")
    webcam.fill(jpeg(1), junk=b"of an older picture\xff\xd9", age_s=0.1)
    stepped(camera, lambda: ctx.frames == [jpeg(1)])
    assert webcam.asked == [(640, 360, "MJPG"), 15, "clipping False", "stream on"]
    assert time.monotonic() - ctx.taken_s[0] > 0.1


def test_a_v4l2_picture_that_the_driver_calls_broken_is_dropped(started, webcam):
    camera, ctx = started(address="/dev/video0")
    webcam.fill(jpeg(1), flags=ERROR)
    webcam.fill(jpeg(2), flags=0)
    stepped(camera, lambda: ctx.frames == [jpeg(2)])
    assert time.monotonic() - ctx.taken_s[0] < HANG_S
    assert camera._state().dropped == 1


def test_v4l2_controls_are_set_in_the_order_of_the_row(started, webcam):
    settings = '{"device": "front", "on": true, "controls": {"auto_exposure": 1, "brightness": 17}}'
    started(settings, "/dev/video0")
    until(lambda: "stream on" in webcam.asked)
    assert webcam.controls["auto_exposure"] == 1
    assert webcam.controls["brightness"] == 17


@pytest.mark.parametrize(
    ("controls", "words"),
    [
        ('{"glow": 1}', "has no control glow; it has auto_exposure, brightness, power_line_frequency"),
        ('{"brightness": 1}', "does not take 1 for its control brightness: IntegerControl"),
    ],
)
def test_a_v4l2_control_that_cannot_be_set_is_told(started, webcam, controls, words):
    webcam.inactive.add("brightness")
    camera, ctx = started(f'{{"device": "front", "on": true, "controls": {controls}}}', "/dev/video0")
    stepped(camera, lambda: ctx.state.phase == "lost")
    assert words in ctx.state.reason
    assert webcam.opened == 0


def test_a_v4l2_camera_without_jpeg_is_told(started, webcam):
    webcam.pixel_format = "YUYV"
    camera, ctx = started(address="/dev/video0")
    stepped(camera, lambda: ctx.state.phase == "lost")
    assert "sends YUYV and no MJPG" in ctx.state.reason
    assert webcam.opened == 0


def test_an_unplugged_v4l2_camera_is_closed_and_missed(started, webcam):
    camera, ctx = started(address="/dev/video0")
    webcam.fill(jpeg())
    stepped(camera, lambda: ctx.frames)
    webcam.unplug()
    stepped(camera, lambda: "is missing; plug it in" in ctx.state.reason)
    assert webcam.opened == 0


def test_switching_a_v4l2_camera_off_stops_and_closes_it(started, webcam):
    camera, ctx = started(address="/dev/video0")
    webcam.fill(jpeg())
    stepped(camera, lambda: ctx.frames)
    assert answer(camera, SwitchCommand(on=False)).accepted
    assert webcam.asked[-1] == "stream off"
    assert webcam.opened == 0


@pytest.mark.parametrize(
    ("address", "words"),
    [("/dev/video_of_nobody", "is missing; plug it in"), ("/dev/null", "cannot be set up (Inappropriate ioctl")],
)
def test_linuxpy_itself_says_what_no_camera_is(tmp_path, address, words):
    needs.modules("linuxpy")
    ctx = CameraContext(KIND.parse(ON), address, tmp_path)
    with pytest.raises(DeviceError, match=re.escape(words)):
        open_source(ctx.device, ctx.settings)


def test_a_pi_camera_hanging_upside_down_is_turned_and_its_pictures_go_out(started, monkeypatch):
    pi = PiCamera()
    pi.install(monkeypatch)
    camera, ctx = started(
        '{"device": "front", "on": true, "rotation_deg": 180, "controls": {"Brightness": 0.5}}', "csi:1"
    )
    until(lambda: pi.output is not None)
    assert pi.asked[0] == 1
    assert pi.asked[1]["transform"] == {"hflip": True, "vflip": True}
    assert pi.asked[1]["controls"] == {"FrameRate": 15, "Brightness": 0.5}
    pi.output.outputframe(jpeg(4), True, 0)
    stepped(camera, lambda: ctx.frames == [jpeg(4)])
    assert answer(camera, SwitchCommand(on=False)).accepted
    assert pi.asked[-2:] == ["stopped", "closed"]


@pytest.mark.parametrize(
    ("library", "address", "words"),
    [("linuxpy.video", "/dev/video0", "lbr[camera]"), ("picamera2", "csi:0", "python3-picamera2")],
)
def test_a_library_that_is_missing_is_told_with_what_installs_it(started, monkeypatch, library, address, words):
    monkeypatch.setitem(__import__("sys").modules, library, None)
    camera, ctx = started(address=address)
    stepped(camera, lambda: ctx.state.phase == "lost")
    assert words in ctx.state.reason
