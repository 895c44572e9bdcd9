"""The running world as a driver and a bus client meet it: real ttys, real time."""

import json
import sys
import threading
import time
from pathlib import Path

import msgspec
import pytest
import serial

from lbr.capability import twins
from lbr.capability.context import Device
from lbr.simulation.cameras.host import CameraHost
from lbr.simulation.capability import WheeledPhysics, World
from lbr.simulation.engine import Engine
from lbr.simulation.kind import KIND
from lbr.simulation.loop import WorldLoop
from lbr.simulation.requests import FaultRequest, PictureRequest, PlaceRequest, PlugRequest, RemoveRequest
from lbr.simulation.settings import WorldSettings
from tests.simulation.world_bench import Bench, Client
from tests.support import programs
from tests.support.waiting import HANG_S, STOPS_S, until


@pytest.fixture
def bench(tmp_path):
    made = Bench(tmp_path)
    made.world.open()
    yield made
    made.world.close()


@pytest.fixture
def motors(bench):
    client = Client(bench.motors_path)
    yield client
    client.tty.close()


def test_a_motor_command_drives_the_robot_ahead(bench, motors):
    bench.world.step()
    ahead_m = bench.ctx.said("pose")[0].x_m

    def has_moved():
        assert motors.ask("!M -500 500") == b"+\r"
        pose = bench.ctx.said("pose")[-1]
        return pose.x_m > ahead_m + 0.1 and abs(pose.y_m) < 0.02

    assert bench.until(has_moved)
    assert bench.ctx.said("pose")[-1].left == bench.ctx.said("pose")[-1].right == 0.5
    counts = motors.ask("?C")
    left, right = (int(count) for count in counts[2:-1].split(b":"))
    assert left < -10
    assert right > 10


def test_commands_are_answered_promptly(motors):
    times = []
    for _ in range(200):
        start = time.perf_counter()
        assert motors.ask("?FF") == b"FF=0\r"
        times.append(time.perf_counter() - start)
    assert sorted(times)[20] < 0.01, "but for those that a busy machine holds up"
    assert min(times) > 0.0009, "no faster than the bytes"


def test_the_trace_tells_lines_and_the_watchdogs_stop(bench, motors):
    motors.ask("^RWD 150")
    motors.ask("!M -300 300")
    assert bench.until(lambda: bench.trace()[-1][-1] == "watchdog")
    line, start, stop = bench.trace()
    assert line[1:] == ["line", "!M", "-300", "300"]
    assert start[1:] == ["0.3", "0.3", "command"]
    assert stop[1:] == ["0", "0", "watchdog"]
    took_s = (int(stop[0]) - int(start[0])) / 1e9
    assert took_s >= 0.150
    assert took_s < STOPS_S


def test_the_emergency_stop_is_in_the_trace_and_closing_too(bench, motors):
    motors.ask("!M -300 300")
    motors.ask("!EX")
    bench.world.close()
    causes = [entry[3] for entry in bench.trace() if entry[1] != "line"]
    assert causes == ["command", "emergency_stop", "close"]
    assert not bench.motors_path.is_symlink()


def test_pulled_motors_run_on_until_the_watchdog_and_come_back(bench, motors):
    motors.ask("!M -300 300")
    bench.fault("motors", "unplug")
    assert bench.until(lambda: not bench.motors_path.is_symlink())
    with pytest.raises(serial.SerialException):
        motors.tty.read(1)
    assert bench.until(lambda: bench.trace()[-1][-1] == "watchdog")
    assert [entry[1:] for entry in bench.trace()[2:]] == [["0.3", "0.3", "unplug"], ["0", "0", "watchdog"]]
    bench.fault("motors", "replug")
    assert bench.until(bench.motors_path.is_symlink)
    again = Client(bench.motors_path)
    assert again.ask("~RWD") == b"RWD=1000\r"
    again.tty.close()


def test_a_controller_that_stops_reading_answers_later(bench, motors):
    bench.fault("motors", "stop_reading")
    motors.tty.timeout = 0.1
    assert bench.until(lambda: motors.ask("?FF") == b"")
    bench.fault("motors", "stop_reading", False)
    motors.tty.timeout = HANG_S
    assert motors.tty.read_until(b"\r") == b"FF=0\r"


def test_the_board_reports_the_walls_and_what_is_pinned(bench):
    with serial.Serial(str(bench.ranges_path), 115200, timeout=HANG_S, exclusive=True) as tty:
        tty.write(b"g\n")
        assert tty.readline() == b"received: g\n"
        assert tty.readline() == b"received: \n"
        assert tty.readline() == b"\n"
        seen = json.loads(tty.readline())["Ranges"]
        assert abs(seen["Forward"] - 173) < 6
        assert seen["Back"] == 765
        bench.fault("ranges", "range_back_m", 0.5)
        assert bench.until(lambda: json.loads(tty.readline())["Ranges"]["Back"] == 50)


def test_pose_comes_at_its_rate_and_the_scene_at_once(bench):
    assert bench.until(lambda: len(bench.ctx.said("pose")) >= 11)
    first, last = bench.ctx.said("pose")[0], bench.ctx.said("pose")[10]
    assert last.time_s - first.time_s > 0.35
    assert [wall.name for wall in bench.ctx.said("scene")[0].walls] == ["wall"]


def test_a_picture_is_saved_where_asked(bench, tmp_path):
    path = tmp_path / "room.png"
    call = bench.ask("picture", PictureRequest(path=str(path), width_px=300, height_px=300))
    assert bench.until(lambda: call.answer is not None)
    assert call.answer.path == str(path)
    assert path.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("name", "message", "reason"),
    [
        ("fault", FaultRequest(device="legs", name="unplug"), "there are: motors, ranges"),
        ("fault", FaultRequest(device="motors", name="explode"), "allowed here: unplug, silent"),
        ("fault", FaultRequest(device="motors", name="drop", value=7.0), "fault 'drop'"),
        ("picture", PictureRequest(path="room.png"), "absolute"),
        ("place", PlaceRequest(x_m=0.1, y_m=0.0), "where the robot is"),
        ("remove", RemoveRequest(name="ghost"), "nothing called 'ghost'"),
    ],
)
def test_what_cannot_be_done_is_refused_with_a_reason(bench, name, message, reason):
    assert reason in bench.ask(name, message).refused


def test_a_thing_that_is_placed_is_seen_until_it_is_removed(bench):
    call = bench.ask("place", PlaceRequest(x_m=1.2, y_m=0.0))
    assert call.answer.things == ("obstacle",)
    assert bench.until(lambda: (bench.world._physics.ranges_m["forward"] or 9.0) < 1.2)
    assert bench.until(lambda: [wall.name for wall in bench.ctx.said("scene")[-1].walls] == ["wall", "obstacle"])
    assert bench.ctx.events[-1] == ("world_changed", "'obstacle' stands in the world")
    assert bench.ask("remove", RemoveRequest()).answer.things == ()
    assert bench.until(lambda: (bench.world._physics.ranges_m["forward"] or 0.0) > 1.2)


def test_what_ends_the_worlds_thread_ends_the_capability(bench, monkeypatch):
    def fall(*_):
        raise ZeroDivisionError("physics")

    monkeypatch.setattr("lbr.simulation.engine.Engine.drive", fall)
    with pytest.raises(ZeroDivisionError, match="physics"):
        bench.until(lambda: False)


def test_a_device_without_a_twin_is_named(tmp_path, wording):
    bench = Bench(tmp_path)
    bench.ctx.devices = (*bench.ctx.devices, Device("arm", "servo_bus", str(tmp_path / "arm"), {}))
    bench.world.open()
    bench.world.close()
    assert bench.ctx.health == []
    wording(*bench.ctx.told("no_twin"))


def test_a_device_that_has_a_twin_but_is_elsewhere_is_named(tmp_path):
    bench = Bench(tmp_path)
    bench.ctx.devices = (*bench.ctx.devices, Device("arm", "dynamixel", "usb:1a86:55d3", {}))
    bench.world.open()
    bench.world.close()
    assert "no emulated twin for arm (dynamixel at usb:1a86:55d3)" in bench.ctx.health[0]


def test_a_twin_that_breaks_is_refused_in_words_and_the_others_are_there(tmp_path, monkeypatch):
    bench = Bench(tmp_path)

    def broken(*_):
        raise ZeroDivisionError("no axle")

    monkeypatch.setattr("lbr.simulation.devices.riox.twin.RioxTwin.__init__", broken)
    bench.ctx.devices = (*bench.ctx.devices, Device("ahrs", "riox", str(tmp_path / "ahrs"), {}))
    bench.world.open()
    here = [Path(device.address).exists() for device in bench.ctx.devices if device.name != "ahrs"]
    bench.world.close()
    assert all(here)
    assert "device 'ahrs' (riox) is not emulated: ZeroDivisionError: no axle" in bench.ctx.health


def test_every_type_of_device_can_be_unplugged_and_one_without_a_twin_needs_none(tmp_path):
    bench = Bench(tmp_path)
    bench.ctx.devices = (
        *(Device(kind, kind, str(tmp_path / kind), {}) for kind in twins.names()),
        Device("speaker", "speaker", str(tmp_path / "speaker"), {}),
    )
    bench.world.open()
    paths = [tmp_path / kind for kind in twins.names()]
    try:
        assert all(path.exists() for path in paths)
        for kind in twins.names():
            bench.fault(kind, "unplug")
        assert bench.until(lambda: not any(path.is_symlink() or path.exists() for path in paths))
        for kind in twins.names():
            bench.fault(kind, "replug")
        assert bench.until(lambda: all(path.exists() for path in paths))
    finally:
        bench.world.close()
    assert bench.ctx.health == []
    assert not any(path.is_symlink() or path.exists() for path in paths)


def test_a_row_that_is_wrong_is_named(tmp_path):
    bench = Bench(tmp_path)
    bench.ctx.devices = (Device("motors", "roboteq", str(bench.motors_path), {"left_channel": 3}),)
    with pytest.raises(ValueError, match=r"device 'motors' \(roboteq\).*left_channel"):
        bench.world.open()
    bench.world.close()


def test_it_opens_again_after_closing(bench):
    bench.world.close()
    bench.world.open()
    client = Client(bench.motors_path)
    assert client.ask("?FF") == b"FF=0\r"
    client.tty.close()


def test_the_kind_is_light_and_leads_to_the_world():
    code = "import sys, lbr.simulation.kind as s; s.KIND.parse('{}'); print([m for m in ('mujoco', 'numpy', 'PIL') if m in sys.modules])"
    result = programs.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert result.stdout.strip() == "[]"
    assert KIND.load() is World


@pytest.mark.parametrize("value", [b"true", b"0.5", b'"left,back"', b'["left"]', b"null"])
def test_a_fault_travels_as_json(value):
    request = msgspec.json.decode(
        b'{"device": "ranges", "name": "missing", "value": ' + value + b"}", type=FaultRequest
    )
    assert msgspec.json.encode(request.value) == value


@pytest.mark.parametrize("place", ["", "~nobody-of-this-name/trace", "/tmp/a\0"])
def test_a_trace_that_cannot_be_written_is_named(tmp_path, place):
    bench = Bench(tmp_path, trace=place or str(tmp_path))
    with pytest.raises(ValueError, match="setting `trace`: cannot write"):
        bench.world.open()
    bench.world.close()


def plugged(bench, tmp_path, name, type_, address="", **settings):
    place = tmp_path / "run" / "lbr-devices" / name
    return bench.ask(
        "plug", PlugRequest(device=name, type=type_, address=address or str(place), settings=settings)
    ), place


def test_a_device_is_plugged_in_while_time_runs_and_what_is_there_goes_on(bench, tmp_path):
    bench.ctx.home = str(tmp_path)
    call, place = plugged(bench, tmp_path, "ahrs", "riox")
    assert call.answer.accepted, call.refused
    assert bench.until(place.exists)
    bench.fault("ahrs", "unplug")
    assert bench.until(lambda: not place.exists())
    assert bench.motors_path.exists()
    assert bench.ctx.told("plugged_in") == ["device 'ahrs' (riox) is emulated, too"]


def test_a_device_without_a_twin_that_comes_later_is_told_in_one_line(bench, tmp_path, wording):
    call, _ = plugged(bench, tmp_path, "arm", "servo_bus", "/dev/arm")
    assert call.answer.accepted, call.refused
    wording(*bench.ctx.told("no_twin"))


@pytest.mark.parametrize(
    ("name", "type_", "address", "settings"),
    [
        ("second", "roboteq", "", {}),
        ("ranges", "riox", "", {}),
        ("ahrs", "riox", "/tmp/elsewhere", {}),
        ("ahrs", "riox", "", {"colour": 1}),
    ],
)
def test_a_device_that_cannot_be_plugged_in_now_is_refused_and_nothing_is_changed(
    bench, tmp_path, name, type_, address, settings, wording
):
    bench.ctx.home = str(tmp_path)
    call, place = plugged(bench, tmp_path, name, type_, address, **settings)
    wording(call.refused)
    assert not place.exists()
    assert bench.ctx.told("plugged_in") == []


class Streaming:
    """A unit that tells by itself what it feels, 100 times a second."""

    name = "streaming"

    def __init__(self):
        self.reading, self.told, self.due = None, [], time.monotonic()

    def watched(self):
        return None

    def next_due(self):
        return self.due

    def service(self, now):
        if now >= self.due:
            self.due = now + 0.01
            self.told.append(self.reading)

    def sense(self, sensed):
        pass

    def feel(self, reading, now):
        self.reading = reading

    def close(self):
        pass


def test_what_streams_by_itself_tells_something_new_each_time_also_at_rest():
    engine, twin = Engine(WorldSettings(walls=())), Streaming()
    engine.drive({}, 1.0)
    assert engine.resting
    loop = WorldLoop(WheeledPhysics(engine, (twin,), CameraHost(b"", 0)), (twin,), time.monotonic)
    loop.open()
    try:
        until(lambda: len(twin.told) > 40, what="forty readings")
    finally:
        loop.close()
    assert loop.failure is None
    assert engine.resting
    assert len({reading.gyro_rps for reading in twin.told[5:40]}) > 30


class Stepping:
    """Physics whose steps last; while one does, the world is closed by a thread that finds everything at rest."""

    timestep_s = 0.001

    def __init__(self):
        self.entered, self.over = threading.Event(), threading.Event()

    def advance(self, now, dt_s):
        self.entered.set()
        self.over.wait(HANG_S)

    def resting(self, now):
        return False

    def at_rest(self, now):
        threading.Timer(0.05, self.over.set).start()
        return True

    def imu(self):
        return None

    def look(self, now):
        return None

    def moved_by(self, twin):
        return True


def test_what_came_due_in_the_last_step_of_a_world_is_done_before_its_devices_are_gone():
    physics, twin, served = Stepping(), Streaming(), []
    twin.service = lambda now: served.append((physics.over.is_set(), now))
    loop = WorldLoop(physics, (twin,), time.monotonic)
    loop.open()
    assert physics.entered.wait(HANG_S)
    assert not served[-1][0]
    loop.close()
    assert loop.failure is None
    assert served[-1][0]
