"""`lbr devices`: ten kinds of device on ports, recognised by harmless questions alone; and what is no device at all."""

import errno
import fcntl
import grp
import json
import os
import pty
import select
import sqlite3
import subprocess
import sys
import threading
import time
import tty
from collections import Counter
from contextlib import ExitStack, closing, contextmanager, suppress
from pathlib import Path

import pytest

from lbr.commands import attached, proposing, recognised
from lbr.commands.devices import Looking
from lbr.database import store
from lbr.database.rows import CapabilityRow, DeviceRow, RobotRow, RobotRows
from lbr.testing.device import plugged
from tests.support import databases, packages, programs, tap
from tests.support.commands import here
from tests.support.tap import tapped
from tests.support.waiting import until

OUTSIDE = ("roboclaw", "so101")
SERIAL = {
    "roboteq": {},
    "riox": {},
    "ultrasonic_ring": {"board": "arduino"},
    "ld06": {},
    "dynamixel": {},
    "uxa90": {},
    "feetech": {},
    "roboclaw": {},
}
ON_I2C = ("mpu9150", "pico")
WITHIN_S = 2.0
"""In which a kind is to be recognised, however many others are asked at the same time."""


@pytest.fixture(scope="module")
def outside(tmp_path_factory):
    """The packages of two drivers outside lbr, for this process and for the command."""
    with packages.beside(tmp_path_factory.mktemp("outside"), *OUTSIDE) as path:
        yield path


@pytest.fixture(scope="module")
def home(tmp_path_factory, outside):
    return databases.in_home(tmp_path_factory.mktemp("home")).parent


def said(words, home, path="", **options):
    env = {**os.environ, "LBR_HOME": str(home), "PYTHONPATH": path}
    return programs.run(
        [sys.executable, "-m", "lbr.start", *words], env=env, capture_output=True, text=True, timeout=60, **options
    )


def looked(words, home, path=""):
    """Look for devices: in this process, unless it is to find other packages by its path."""
    words = ["devices", "--json", *words]
    done = said(words, home, path) if path else here(home, *words)
    assert done.stdout, done.stderr
    return json.loads(done.stdout)


def recognised_as(types, look):
    """Look until these types are told: a device that a busy machine holds up answers when nobody listens any more."""

    def found():
        seen = look()
        return seen if [one["type"] for one in seen["devices"]] == types else None

    return until(found, what=f"{types}")


def test_ten_kinds_are_recognised_in_two_seconds_and_hear_nothing_but_harmless_questions(tmp_path, home, outside):
    before = (home / "robot.db").read_bytes()
    with ExitStack() as stack:
        devices, heard = {}, {}
        for type_, settings in SERIAL.items():
            devices[type_], heard[type_] = stack.enter_context(tapped(type_, tmp_path, settings=settings))
        for type_ in ON_I2C:
            devices[type_], heard[type_] = stack.enter_context(tapped(type_, tmp_path, scheme="unix:"))
        ports = [one.device.address for one in devices.values()]
        found = looked([word for port in ports for word in ("--port", port)], home, outside)
    known = {one["address"].partition(":0x")[0]: one for one in found["devices"]}
    told = {type_: known[one.device.address]["type"] for type_, one in devices.items()}
    took = {type_: known[one.device.address]["took_s"] for type_, one in devices.items()}
    print(f"{sum(map(str.__eq__, told, told.values()))} of {len(told)} kinds; seconds: {took}")
    assert told == {type_: type_ for type_ in devices}
    assert max(took.values()) < WITHIN_S * (1.0 + os.getloadavg()[0])
    for type_, pieces in heard.items():
        (tap.assert_read_only if type_ in ON_I2C else tap.assert_asked_only)(type_, pieces)
    assert b"".join(heard["ld06"]) == b""
    assert not any(servo.torque for servo in devices["feetech"].twin.servos.values())
    assert devices["roboteq"].twin.wheels(time.monotonic()) == (0.0, 0.0)
    assert (home / "robot.db").read_bytes() == before


@contextmanager
def other_end(folder, name, says=b"", *, every_s=0.0, hang_up=False):
    """A tty whose other end says something again and again, or nothing, or goes away once it is asked."""
    master, slave = pty.openpty()
    tty.setraw(slave)
    path = folder / name
    path.symlink_to(os.ttyname(slave))
    over = threading.Event()
    os.set_blocking(master, False)
    ends = [master, slave]

    def serve():
        while not over.is_set():
            ready, _, _ = select.select([master], [], [], every_s or 0.02)
            if ready and os.read(master, 4096) and hang_up:
                path.unlink()
                while ends:
                    os.close(ends.pop())
                return
            if says:
                with suppress(BlockingIOError):
                    os.write(master, says)

    thread = threading.Thread(target=serve, daemon=True)
    thread.start()
    try:
        yield str(path)
    finally:
        over.set()
        thread.join(5)
        for one in ends:
            os.close(one)


HANGING = """
from threading import Event
from msgspec import Struct
from lbr.capability.kind import Kind, OnDevice
from lbr.capability.recognition import SerialHandshake

class Settings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    device: str

KIND = Kind(
    name="crab", summary="a crab", family="driver", entry="crab:Crab", settings=Settings,
    device=OnDevice("crab", recognised="crab:HANDSHAKE"),
)
HANDSHAKE = SerialHandshake(baud=115_200, seen=lambda _heard: Event().wait(), questions=(b"a?",))
"""


def test_a_package_whose_recognition_never_returns_is_named_and_keeps_out_no_other(tmp_path, home, outside):
    site = tmp_path / "site"
    packages.package(site, "crab", brings={"kinds": {"crab": "crab:KIND"}}, files={"crab.py": HANGING})
    with tapped("roboteq", tmp_path, settings=SERIAL["roboteq"]) as (device, _heard):
        port = device.device.address
        path = f"{site}{os.pathsep}{outside}"
        found = recognised_as(["roboteq"], lambda: looked(["--port", port, "--wait", "5"], home, path))
    assert [one for one in found["hints"] if one.startswith("crab.<lambda> has not returned within 1 s")]


def test_what_floods_babbles_is_silent_goes_away_or_is_held_is_told_in_words_and_in_time(tmp_path, home):
    with ExitStack() as stack:

        def end(*words, **options):
            return stack.enter_context(other_end(tmp_path, *words, **options))

        says = {
            end("flood", b"\xff\xff\x01\xa5" * 4000, every_s=0.0005): "that no driver here knows",
            end("babble", b"Boot v1.2\r\nready>\r\n", every_s=0.02): "that no driver here knows",
            end("silent"): "answers no question",
            end("leaves", hang_up=True): "went away",
            str(tmp_path / "absent"): "is missing",
        }
        busy = end("busy")
        taken = stack.enter_context(Path(busy).open("rb", buffering=0))
        fcntl.flock(taken, fcntl.LOCK_EX | fcntl.LOCK_NB)
        says[busy] = f"in use: held by {Path('/proc/self/comm').read_text().strip()} (pid {os.getpid()}): not opened"
        found = looked([word for port in says for word in ("--port", port)], home)
    told = {one["address"]: one for one in found["devices"]}
    for port, text in says.items():
        assert text in told[port]["text"], told[port]
        assert told[port]["took_s"] < 2 * WITHIN_S * (1.0 + os.getloadavg()[0])
        assert not told[port]["type"]
    assert told[busy]["held"]
    assert found["proposals"] == []


def test_a_proposal_is_written_only_when_asked_and_can_be_taken_back(tmp_path, home, outside):
    def devices():
        return json.loads(said(["db", "export", str(tmp_path / "rows"), "--json"], home, outside).stdout)["revision"]

    with plugged("roboteq", tmp_path, name="wheels") as one, plugged("ld06", tmp_path, name="lidar") as other:
        ports = ["--port", one.device.address, "--port", other.device.address]
        before = devices()
        shown = said(["devices", *ports, "--robot", "lbr"], home, outside)
        assert "device 'motor_controller' waits for one at" in shown.stdout
        assert "usb-Roboteq_Motor_Controller-if00 -> /" in shown.stdout
        assert "capability 'lbr/ld06' added" in shown.stdout
        assert "channel 'lbr/ld06.scan/drive.scans' added" in shown.stdout
        assert "nothing is written yet" in shown.stdout
        assert devices() == before
        written = looked([*ports, "--robot", "lbr", "--write"], home, outside)
        assert written["written"], written
        assert devices() > before
        again = looked([*ports, "--robot", "lbr"], home, outside)
        assert {one["row"] for one in again["devices"]} == {"motor_controller", "ld06"}
        assert again["proposals"] == []
    assert said(["db", "check", "--robot", "lbr"], home, outside).returncode == 0
    assert "took what is plugged in" in said(["db", "history", "-n", "1"], home, outside).stdout
    assert said(["db", "undo"], home, outside).returncode == 0
    assert said(["db", "diff"], home, outside).stdout.strip() == "the rows are as shipped"


def test_listening_writes_no_byte_and_knows_what_talks_by_itself(tmp_path, home):
    with tapped("ld06", tmp_path) as (lidar, _), tapped("roboteq", tmp_path) as (wheels, heard):
        ports = ["--port", lidar.device.address, "--port", wheels.device.address]
        recognised_as(["ld06", ""], lambda: json.loads(said(["devices", "--json", "--listen", *ports], home).stdout))
    assert b"".join(heard) == b""


def test_two_alike_are_told_apart_by_serial_number_and_those_without_by_their_place(tmp_path):
    by_id, by_path = tmp_path / "serial/by-id", tmp_path / "serial/by-path"
    for folder in (by_id, by_path):
        folder.mkdir(parents=True)
    for number in (0, 1):
        node = tmp_path / f"ttyUSB{number}"
        node.touch()
        (by_path / f"usb-0:{number}").symlink_to(node)
    (by_id / "usb-FTDI_A1").symlink_to(tmp_path / "ttyUSB0")
    (by_id / "usb-CH340").symlink_to(tmp_path / "ttyUSB1")
    names = [Path(one.address).name for one in attached.ends(tmp_path, tmp_path)]
    assert names == ["usb-FTDI_A1", "usb-CH340"]
    twice = Counter({"1a86:7523": 2, "0403:6001": 1})
    at = [by_path / "usb-0:1"]
    assert attached.stable([by_id / "usb-CH340"], twice, "1a86:7523", at, "") == str(at[0])
    assert attached.stable([by_id / "usb-FTDI_A1"], twice, "0403:6001", at, "") == str(by_id / "usb-FTDI_A1")


def test_cameras_and_receivers_are_known_by_the_kernels_names_and_not_opened(tmp_path):
    camera, spare, receiver = (
        tmp_path / "class" / one for one in ("video4linux/video0", "video4linux/video1", "lirc/lirc0")
    )
    for folder, index in ((camera, "0"), (spare, "1")):
        folder.mkdir(parents=True)
        (folder / "name").write_text("HD Webcam\n")
        (folder / "index").write_text(index)
    (receiver / "device/input7").mkdir(parents=True)
    (receiver / "device/input7/name").write_text("gpio_ir_recv")
    _, known, _ = recognised.known_kinds(tmp_path)
    found = recognised.ask_all(attached.ends(tmp_path / "dev", tmp_path), known, {}, wait_s=1.0)
    assert [(one.type, one.what) for one in found] == [
        ("camera", "camera, HD Webcam"),
        ("infrared", "infrared receiver, gpio_ir_recv"),
    ]


def gamepad_in(tmp_path, node, name, uniq=""):
    """Have the kernel know a gamepad: its node, and what it says of it."""
    place = tmp_path / "class/input" / node / "device"
    (place / "capabilities").mkdir(parents=True)
    for file, text in (
        ("name", name),
        ("uniq", uniq),
        ("capabilities/abs", "3003f"),
        ("capabilities/key", "7cdb000000000000 0 0 0 0"),
    ):
        (place / file).write_text(f"{text}\n")
    (tmp_path / "input").mkdir(exist_ok=True)
    (tmp_path / "input" / node).touch()


def test_gamepads_are_known_by_their_keys_by_cable_and_by_radio_and_what_waits_for_one_is_switched_on(tmp_path):
    gamepad_in(tmp_path, "event4", "Example Pad")
    gamepad_in(tmp_path, "event5", "Wireless Controller", "aa:bb:cc:00:11:22")
    names = tmp_path / "input/by-id"
    names.mkdir()
    (names / "usb-Example_Pad-event-joystick").symlink_to("../event4")
    (tmp_path / "input/event1").touch()
    (names / "usb-Keyboard-event-kbd").symlink_to("../event1")
    kinds, known, _ = recognised.known_kinds(tmp_path)
    found = recognised.ask_all(attached.ends(tmp_path, tmp_path), known, {}, wait_s=1.0)
    assert [(one.type, one.what, one.address) for one in found] == [
        ("gamepad", "gamepad, Example Pad", str(names / "usb-Example_Pad-event-joystick")),
        ("gamepad", "gamepad, Wireless Controller", "input:aa:bb:cc:00:11:22"),
        ("", "", str(names / "usb-Keyboard-event-kbd")),
    ]
    off = [
        CapabilityRow(name="teleop", kind="gamepad_teleop", enabled=False),
        CapabilityRow(name="foxglove", kind="foxglove", enabled=False),
    ]
    rows = RobotRows(robot=RobotRow(name="two"), capabilities=tuple(off))
    _, (offer,) = proposing.propose(rows, kinds, found[1:], {one.path for one in found})
    assert offer.text == (
        "add it as device 'gamepad', with the capability 'gamepad' of kind 'gamepad'; switch on teleop, for which it is"
    )
    assert [(one.table, one.after) for one in offer.changes] == [
        ("device", {"name": "gamepad", "type": "gamepad", "address": "input:aa:bb:cc:00:11:22"}),
        ("capability", {"name": "gamepad", "kind": "gamepad", "settings": {"device": "gamepad"}}),
        ("capability", {"name": "teleop", "enabled": True}),
    ]
    held = recognised.held_by("two", [DeviceRow(name="pad", type="gamepad", address="/dev/null")])
    assert [*held] == ["/dev/null"]


def test_the_proposal_of_a_gamepad_is_written_over_the_shipped_rows(tmp_path):
    databases.in_home(tmp_path)
    kinds, _, _ = recognised.known_kinds(tmp_path)
    pad = recognised.Attached(
        place="gamepad", address="input:Pad", path="/dev/input/event4", type="gamepad", what="pad"
    )
    looking = Looking("lbr", tmp_path / "robot.db", "", wait_s=1.0, ask=True)
    with store.Database.open(tmp_path / "robot.db") as database:
        _, offers = proposing.propose(database.load("lbr"), kinds, [pad], {pad.path})
    became = looking.write("lbr", offers)
    assert not became.problems
    with store.Database.open(tmp_path / "robot.db") as database:
        on = {row.name for row in database.load("lbr").capabilities if row.enabled}
    assert {"gamepad", "teleop"} <= on


@pytest.mark.parametrize(
    ("type_", "gone", "is_so"),
    [
        ("gamepad", (), "SELECT enabled = 1 FROM capability WHERE robot = 'lbr' AND name = 'teleop'"),
        (
            "ld06",
            ("DELETE FROM range_sensor WHERE robot = 'lbr'",),
            "SELECT count(*) = 1 FROM channel WHERE robot = 'lbr' AND target = 'drive.scans'",
        ),
        (
            "roboteq",
            (
                "DELETE FROM channel WHERE robot = 'lbr' AND 'motors' IN (substr(source, 1, 6), substr(target, 1, 6))",
                "DELETE FROM capability WHERE robot = 'lbr' AND name = 'motors'",
                "DELETE FROM device WHERE robot = 'lbr' AND type = 'roboteq'",
                "UPDATE capability SET needs = '[]' WHERE robot = 'lbr' AND name = 'drive'",
            ),
            "SELECT count(*) = 1 FROM channel WHERE robot = 'lbr' AND source = 'drive.setpoint'",
        ),
    ],
)
def test_two_alike_that_are_new_are_written_together_and_only_the_first_is_wired(tmp_path, type_, gone, is_so):
    databases.in_home(tmp_path)
    with closing(sqlite3.connect(tmp_path / "robot.db")) as database, database:
        for sql in gone:
            database.execute(sql)
    two = [
        recognised.Attached(place="serial", address=at, path=at, type=type_, what=type_)
        for at in ("/dev/ttyA", "/dev/ttyB")
    ]
    looking = Looking("lbr", tmp_path / "robot.db", "", wait_s=1.0, ask=True)
    with store.Database.open(tmp_path / "robot.db") as database:
        _, offers = proposing.propose(database.load("lbr"), looking.kinds, two, {one.path for one in two})
    assert not looking.write("lbr", offers).problems
    with closing(sqlite3.connect(tmp_path / "robot.db")) as database:
        assert database.execute(is_so).fetchone() == (1,)
        kept = database.execute("SELECT name FROM device WHERE robot = 'lbr' AND type = ?", (type_,)).fetchall()
    assert kept == [(type_,), (f"{type_}_2",)]


def test_what_nothing_would_hear_is_proposed_in_these_words(tmp_path, wording):
    kinds, _, _ = recognised.known_kinds(tmp_path)
    riox = recognised.Attached(place="serial", address="/dev/ttyA", path="/dev/ttyA", type="riox", what="RIOX")
    _, (offer,) = proposing.propose(RobotRows(robot=RobotRow(name="two")), kinds, [riox], {riox.path})
    wording(offer.text)


def test_of_many_alike_each_has_a_name_of_its_own(tmp_path):
    kinds, _, _ = recognised.known_kinds(tmp_path)
    many = [
        recognised.Attached(place="serial", address=f"/dev/tty{n}", path=f"/dev/tty{n}", type="ld06", what="a lidar")
        for n in range(200)
    ]
    _, offers = proposing.propose(RobotRows(robot=RobotRow(name="two")), kinds, many, set())
    assert len({one.after["name"] for offer in offers for one in offer.changes if one.table == "device"}) == 200


def test_watching_tells_what_comes_and_what_goes(tmp_path, home):
    port = tmp_path / "riox"
    env = {**os.environ, "LBR_HOME": str(home), "PYTHONUNBUFFERED": "1"}
    words = [sys.executable, "-m", "lbr.start", "devices", "--watch", "--json", "--port", str(port)]
    with programs.start(words, env=env, stdout=subprocess.PIPE, text=True) as watching:
        try:
            first = json.loads(watching.stdout.readline())
            assert "is missing" in first["devices"][0]["text"]

            def came_and_gone():
                with plugged("riox", tmp_path, name="riox"):
                    came = json.loads(watching.stdout.readline())["came"]
                assert json.loads(watching.stdout.readline())["gone"]["address"] == str(port)
                return came

            recognised_as(["riox"], came_and_gone)
        finally:
            watching.kill()


def test_what_a_running_robot_holds_is_not_opened_and_hears_nothing(tmp_path, wording):
    kinds, known, _ = recognised.known_kinds(tmp_path)
    assert "roboteq" in kinds
    with tapped("roboteq", tmp_path) as (wheels, heard), tapped("mpu9150", tmp_path, scheme="unix:") as (unit, asked):
        rows = [
            DeviceRow(name="motors", type="roboteq", address=wheels.device.address),
            DeviceRow(name="imu", type="mpu9150", address=f"{unit.device.address}:0x68"),
        ]
        ends = [attached.named(one.device.address) for one in (wheels, unit)]
        found = recognised.ask_all(ends, known, recognised.held_by("lbr", rows), wait_s=1.0)
    assert all(one.held for one in found[:2])
    wording(found[0].text, found[1].text)
    assert b"".join(heard) == b""
    assert not any(request[3:4] == b"\x68" or request[1:2] == b"\x68" for request in asked)


def test_two_of_a_type_for_one_row_are_not_guessed_and_one_may_be_named(tmp_path):
    kinds, _, _ = recognised.known_kinds(tmp_path)
    waiting = DeviceRow(name="motors", type="roboteq", address="/dev/serial/by-id/absent")
    rows = RobotRows(robot=RobotRow(name="two"), devices=(waiting,))
    pair = [
        recognised.Attached(place="serial", address=at, path=at, type="roboteq", what="a controller")
        for at in ("/dev/ttyA", "/dev/ttyB")
    ]
    _, proposals = proposing.propose(rows, kinds, pair, {one.path for one in pair})
    assert [one.changes for one in proposals] == [[], []]
    assert "'motors' waits for one: say which" in proposals[0].text
    _, (chosen,) = proposing.propose(rows, kinds, pair[1:], {one.path for one in pair}, "motors")
    assert [one.after for one in chosen.changes] == [{"name": "motors", "address": "/dev/ttyB"}]


def test_without_the_rights_the_group_to_join_is_said(tmp_path, monkeypatch):
    _, known, _ = recognised.known_kinds(tmp_path)
    node = tmp_path / "ttyUSB0"
    node.touch()

    def refused(*_, **__):
        raise PermissionError(errno.EACCES, "Permission denied")

    monkeypatch.setattr("lbr.drivers.serial_line.serial.Serial", refused)
    monkeypatch.setattr(os, "access", lambda *_: False)
    (found,) = recognised.ask_all([attached.named(str(node))], known, {}, wait_s=1.0)
    assert f"sudo usermod -aG {grp.getgrgid(node.stat().st_gid).gr_name} $USER" in found.text
