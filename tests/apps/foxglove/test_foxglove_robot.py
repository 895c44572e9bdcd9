"""A whole robot at the Foxglove bridge: what a client sees and asks, who may, and what a dead client leaves moving."""

import json
import os
import signal
import socket
import ssl
import struct
import subprocess
import sys
import threading
import time
import urllib.request
from contextlib import ExitStack, closing

import pytest
from websockets.exceptions import ConnectionClosed, InvalidStatus, InvalidURI
from websockets.sync.client import connect

from lbr.apps.foxglove import schemas
from lbr.apps.web import addresses
from tests.support import programs
from tests.support.commands import here
from tests.support.robot import LEASE_S, PATIENT, free_port, prepare, running
from tests.support.waiting import HANG_S, STOPS_S, until

pytestmark = [pytest.mark.slow_start]

PROTOCOL = "foxglove.websocket.v1"
RESTS_S = 1.4
PAGE = "https://app.foxglove.dev"
TWIST = {"op": "advertise", "channels": [{"id": 1, "topic": "/cmd_vel", "encoding": "json", "schemaName": "Twist"}]}
DRIVER = """
import json, struct, sys, time
from contextlib import suppress
from websockets.sync.client import connect
with connect(sys.argv[1], subprotocols=["foxglove.websocket.v1"]) as ws:
    ws.send(sys.argv[2])
    while True:
        ws.send(struct.pack("<BI", 1, 1) + json.dumps({"linear": {"x": 0.2}, "angular": {"z": 0.0}}).encode())
        with suppress(TimeoutError):
            told = ws.recv(timeout=0.05)
            if '"motion"' in str(told):
                print(told, file=sys.stderr)
                time.sleep(float(sys.argv[3]))
"""


def pushes(url, **how):
    """A stick of another process, let go once its motion is refused, and pushed again."""
    return programs.start([sys.executable, "-c", DRIVER, url, json.dumps(TWIST), str(RESTS_S)], **how)


class Foxglove:
    """A client of the protocol, as Foxglove is one."""

    def __init__(self, url, **options):
        options.setdefault("proxy", None)
        self._stack = ExitStack()
        self.socket = self._stack.enter_context(connect(url, subprotocols=[PROTOCOL], max_size=None, **options))
        self.channels, self.services, self.statuses, self.heard, self.answers = {}, {}, [], {}, {}
        self.info = None
        self.calls = 0

    def close(self):
        self._stack.close()

    def say(self, **message):
        self.socket.send(json.dumps(message))

    def hear(self, seconds=0.2):
        """Take one message."""
        try:
            said = self.socket.recv(timeout=seconds)
        except TimeoutError:
            return
        if isinstance(said, bytes):
            if said[0] == 1:
                self.heard.setdefault(struct.unpack_from("<I", said, 1)[0], []).append(said[13:])
            else:
                _, _, call, length = struct.unpack_from("<BIII", said)
                self.answers[call] = json.loads(said[13 + length :])
            return
        told = json.loads(said)
        match told["op"]:
            case "serverInfo":
                self.info = told
            case "advertise":
                self.channels |= {one["topic"]: one for one in told["channels"]}
            case "advertiseServices":
                self.services |= {one["name"]: one for one in told["services"]}
            case "status":
                self.statuses.append(told["message"])
            case "serviceCallFailure":
                self.answers[told["callId"]] = told["message"]

    def until(self, ready, what):
        def look():
            self.hear()
            return ready()

        return until(look, what=what)

    def subscribe(self, topic):
        self.until(lambda: topic in self.channels, topic)
        number = self.channels[topic]["id"]
        self.say(op="subscribe", subscriptions=[{"id": number, "channelId": number}])
        return number

    def newest(self, topic):
        number = self.subscribe(topic)
        before = len(self.heard.get(number, ()))
        self.until(lambda: len(self.heard.get(number, ())) > before, topic)
        return json.loads(self.heard[number][-1])

    def call(self, name, **fields):
        self.until(lambda: name in self.services, name)
        self.calls += 1
        head = struct.pack("<BIII", 2, self.services[name]["id"], self.calls, 4)
        self.socket.send(head + b"json" + json.dumps(fields).encode())
        call = self.calls
        self.until(lambda: call in self.answers, f"the answer of {name}")
        return self.answers[call]

    def push(self, x, z=0.0):
        self.socket.send(struct.pack("<BI", 1, 1) + json.dumps({"linear": {"x": x}, "angular": {"z": z}}).encode())


@pytest.fixture(scope="module")
def port():
    return free_port()


@pytest.fixture(scope="module")
def robot(tmp_path_factory, port):
    home = prepare(
        tmp_path_factory.mktemp("foxglove"),
        *("imu", "attitude", "odometry", "camera_front", "cameras"),
        edits=(
            f"UPDATE capability SET enabled = 1, settings = json_object('port', {port}) WHERE name = 'foxglove'",
            *PATIENT,
        ),
    )
    token = here(home, "token", "add", "viewer", "--role", "operate", "--for", "web")
    assert token.returncode == 0, token.stderr
    with running(home) as robot:
        robot.token = token.stdout.split()[-1]
        until(lambda: (state := robot.ask("foxglove/state")) and state["listening"], what="the bridge")
        yield robot


@pytest.fixture
def url(robot, port):
    until(lambda: drive(robot)["holder"] is None, what="standing still")
    until(lambda: (robot.ask("motors/state") or {}).get("armed"), what="motors that would turn")
    return f"ws://127.0.0.1:{port}/"


@pytest.fixture
def client(url):
    with closing(Foxglove(url)) as client:
        yield client


def drive(robot):
    return until(lambda: robot.ask("drive/state"), what="drive/state")


def moves(robot):
    return drive(robot)["moving"]


def stands(robot):
    """Wait until it stands and nobody drives: a rule may stop a motion for a moment while its lease lives."""

    def looks():
        state = drive(robot)
        return state["holder"] is None and state["left"] == state["right"] == 0.0

    until(looks, limit_s=STOPS_S, what="standing still")


def rests(robot):
    return (robot.ask("camera_front/state") or {}).get("rests")


def happened(robot, words):
    return any(words in one["text"] for one in robot.events())


def test_it_shows_streams_by_their_schema_the_body_and_cameras_only_while_they_are_looked_at(client, robot):
    state = client.newest("drive/state")
    schema = json.loads(client.channels["drive/state"]["schema"])
    assert client.channels["drive/state"]["schemaName"] == schema["title"] == "DriveState"
    assert set(state) <= set(schema["properties"])
    drawn = client.newest("@model")
    frames = {one["frame_id"] for one in drawn["entities"]}
    placed = {one["child_frame_id"] for one in client.newest("@tf")["transforms"]}
    assert frames
    assert frames <= placed
    assert client.newest("odometry/state/pose")["frame_id"] == "odom"
    assert client.newest("ranges/readings/rays")["entities"]
    assert until(lambda: rests(robot), what="a camera that nobody looks at")
    image = client.newest("camera_front/frame")
    assert image["format"] == "jpeg"
    assert set(image) == set(schemas.SCHEMAS["foxglove.CompressedImage"]["properties"])
    client.until(lambda: happened(robot, "watches camera_front, in"), "the event of its looking")
    number = client.channels["camera_front/frame"]["id"]
    client.say(op="unsubscribe", subscriptionIds=[number])
    client.until(lambda: rests(robot), "the camera's rest")
    client.until(lambda: happened(robot, "watches camera_front no more"), "the event of its end")


def test_words_are_services_and_answer_as_the_console_does(client):
    assert "drive" in client.call("/help")["text"].lower()
    assert "takes" in client.call("/t", heading="3", wrong=1)
    assert isinstance(client.call("/go", **dict.fromkeys(fields(client, "/go"), "99999")), str)
    assert client.call("/stop")["code"] == 0
    client.socket.send(struct.pack("<BIII", 2, 4_000_000, 77, 4) + b"json{}")
    client.until(lambda: 77 in client.answers, "the refusal")
    assert client.answers[77] == "there is no service 4000000"


def fields(client, name):
    client.until(lambda: name in client.services, name)
    return json.loads(client.services[name]["requestSchema"])["required"]


def test_a_goal_of_a_word_goes_on_while_its_client_is_there_and_ends_with_it(url, robot):
    client = Foxglove(url)
    until(lambda: (robot.ask("attitude/state") or {}).get("valid"), what="the attitude that a turn goes by")
    angle = dict.fromkeys(fields(client, "/t"), "350")

    def outlives_a_lease():
        """Turn; beside other work an attitude is late, or a lease lapses, and it is to be asked for again."""
        if not isinstance(client.call("/t", **angle), dict):
            return False
        begun = time.monotonic()
        client.until(lambda: time.monotonic() - begun > LEASE_S + 0.3, "a lease's life")
        return moves(robot)

    until(outlives_a_lease, what="a turn that goes on")
    client.socket.socket.close()
    stands(robot)


class Publishing(threading.Thread):
    """Publishes a Twist again and again."""

    def __init__(self, client, robot):
        super().__init__()
        self._over, self._rests = threading.Event(), threading.Event()
        self.client, self.robot = client, robot
        self.start()

    def run(self):
        while not self._over.wait(0.05):
            if not self._rests.is_set():
                self.client.push(0.2)

    def drives(self):
        """Return who drives while it moves; where a motion lapsed, let the stick rest before it is pushed again."""
        self.client.hear(0.05)
        if any("[" in one for one in self.client.statuses):
            self.client.statuses.clear()
            self._rests.set()
            self._over.wait(RESTS_S)
            self._rests.clear()
        state = drive(self.robot)
        return state["moving"] and state["holder"]

    def close(self):
        self._over.set()
        self.join()


def test_who_publishes_a_twist_drives_until_it_is_not_published_on(client, robot):
    client.say(**TWIST)
    with closing(Publishing(client, robot)) as stick:
        assert until(stick.drives, what="driving").startswith("web:")
    stands(robot)


def test_a_stop_ends_what_is_published_and_why_it_stands_is_told(client, robot, url):
    client.say(**TWIST)
    with closing(Foxglove(url)) as other, closing(Publishing(client, robot)) as stick:
        until(stick.drives, what="driving")
        assert other.call("/stop")["code"] == 0
        until(lambda: not moves(robot), what="standing still")
        client.until(lambda: any("[" in one for one in client.statuses), "why it stands")
        assert not moves(robot)


def test_a_stop_counts_although_its_client_leaves_with_its_last_byte(client, robot, url):
    client.say(**TWIST)

    def pushed(ready):
        client.push(0.2)
        client.hear(0.05)
        return ready()

    for _ in range(5):
        rests = time.monotonic()
        until(lambda rests=rests: time.monotonic() - rests > RESTS_S, what="a rest after the last stop")
        other = Foxglove(url)
        other.until(lambda other=other: "/stop" in other.services, "its services")
        until(lambda: pushed(lambda: moves(robot)), what="driving")
        with other.socket.protocol_mutex:
            other.socket.protocol.send_binary(struct.pack("<BIII", 2, other.services["/stop"]["id"], 1, 4) + b"json{}")
            other.socket.protocol.send_close(1000)
            other.socket.socket.sendall(b"".join(other.socket.protocol.data_to_send()))
        other.socket.socket.shutdown(socket.SHUT_RDWR)
        until(lambda: pushed(lambda: not moves(robot)), limit_s=STOPS_S, what="standing still")
        other.close()
        seen = time.monotonic()
        client.until(lambda seen=seen: time.monotonic() - seen > 0.5, "a stick at rest")


@pytest.mark.parametrize("end", [signal.SIGKILL, signal.SIGSTOP])
def test_a_killed_or_frozen_client_leaves_nothing_moving(url, robot, end):
    program = pushes(url)
    try:
        until(lambda: moves(robot), what="driving")
        os.kill(program.pid, end)
        stands(robot)
    finally:
        program.kill()
        program.wait()


def test_a_page_acts_by_its_token_alone_and_other_pages_do_not_come_in(url, robot):
    with pytest.raises(InvalidStatus) as refused:
        Foxglove(url, origin="https://evil.example")
    assert refused.value.response.status_code == 403
    with pytest.raises(InvalidStatus) as refused:
        Foxglove(f"{url}?token=viewer.wrong.wrong", origin=PAGE)
    assert refused.value.response.status_code == 401
    with closing(Foxglove(url, origin=PAGE)) as looks:
        assert looks.newest("drive/state")["moving"] is False
        assert looks.info["capabilities"] == ["services"]
        assert "role" in looks.call("/t", **dict.fromkeys(fields(looks, "/t"), "90"))
        looks.say(**TWIST)
        until(lambda: looks.push(0.3) or looks.hear(0.05) or any("role" in one for one in looks.statuses))
        assert looks.call("/stop")["code"] == 0
    with closing(Foxglove(f"{url}?token={robot.token}", origin=PAGE)) as operates:
        operates.until(lambda: operates.info, "the greeting")
        assert "clientPublish" in operates.info["capabilities"]
        assert operates.call("/say", **dict.fromkeys(fields(operates, "/say"), "hello")) is not None
    assert not moves(robot)


def test_rubbish_is_refused_in_words_and_ends_motion_and_nothing_else(client, robot, url):
    client.say(**TWIST)
    for said in (
        b"", b"\x01", b"\x02\0\0", b"\xff" * 40, b"\x01" + struct.pack("<I", 99) + b"{}",
        b"\x01" + struct.pack("<I", 1) + b"[" * 5000, b"\x01" + struct.pack("<I", 1) + b'{"linear": 3}',
        struct.pack("<BIII", 2, 1, 1, 2**31) + b"json", "{", "null", '{"op": 3}', '{"op": "subscribe"}',
        '{"op": "fetchAsset", "uri": "x"}', '{"op": "subscribe", "subscriptions": [{"id": -1, "channelId": 1}]}',
        '{"op": "subscribe", "subscriptions": [{"id": 1, "channelId": 4000000}]}', "[" * 10000,
    ):  # fmt: skip
        client.socket.send(said)
    client.until(lambda: "there is no channel 4000000" in client.statuses, "the last refusal")
    client.until(lambda: len(client.statuses) >= 14, "a sentence for each")
    assert client.newest("drive/state")["moving"] is False
    with closing(Foxglove(url)) as idle:  # reads nothing, and holds up nobody
        idle.until(lambda: "camera_front/frame" in idle.channels, "the channels")
        idle.subscribe("camera_front/frame")
        for _ in range(3):
            client.newest("drive/state")
    assert robot.capability("foxglove")["restarts"] == 0


def flood(client):
    for _ in range(5000):
        client.say(op="unsubscribe", subscriptionIds=[1])
        client.hear(0)
    client.until(lambda: False, "the end of the connection")


def test_too_much_is_cut_and_the_next_client_is_served(url):
    with closing(Foxglove(url)) as loud, pytest.raises(ConnectionClosed):
        flood(loud)
    with closing(Foxglove(url)) as next_:
        assert next_.newest("drive/state")


def test_its_layout_names_only_what_there_is(client, url):
    with urllib.request.urlopen(url.replace("ws", "http", 1) + "layout.json", timeout=HANG_S) as answer:
        layout = json.load(answer)
    client.until(lambda: client.channels and client.services, "the channels")
    panels = layout["configById"]
    assert {name.partition("!")[0] for name in panels} >= {"3D", "Image", "RosOut", "Plot", "Teleop", "CallService"}
    named = [topic for one in panels.values() for topic in one.get("topics", {})]
    named += [one["imageMode"]["imageTopic"] for one in panels.values() if "imageMode" in one]
    named += [path["value"].partition(".")[0] for one in panels.values() for path in one.get("paths", ())]
    named += [one["topicToRender"] for one in panels.values() if "topicToRender" in one]
    assert named
    assert set(named) <= set(client.channels)
    assert {one["serviceName"] for one in panels.values() if "serviceName" in one} <= set(client.services)

    def leaves(part):
        return {part} if isinstance(part, str) else leaves(part["first"]) | leaves(part["second"])

    assert leaves(layout["layout"]) == set(panels)


def test_a_killed_bridge_leaves_nothing_moving_and_comes_back(url, robot):
    program = pushes(url, stderr=subprocess.DEVNULL)
    try:
        until(lambda: moves(robot), what="driving")
        os.kill(robot.capability("foxglove")["pid"], signal.SIGKILL)
        stands(robot)
        until(lambda: robot.capability("foxglove")["phase"] == "ready", what="the bridge")
        assert not moves(robot)
    finally:
        program.kill()
        program.wait()


def test_other_machines_come_in_by_tls_and_a_token_alone(robot, port):
    """The last one: its row begins anew."""
    address = next((one for one in addresses.of_machine() if "." in one and not one.startswith("127.")), None)
    if address is None:
        pytest.skip("this machine has no network")
    robot.edit("UPDATE capability SET settings = json_set(settings, '$.host', '0.0.0.0') WHERE name = 'foxglove'")
    until(
        lambda: (state := robot.ask("foxglove/state")) and any(one.startswith("wss://") for one in state["urls"]),
        what="listening anew",
    )
    trust = ssl.create_default_context()
    trust.check_hostname, trust.verify_mode = False, ssl.CERT_NONE
    with pytest.raises(InvalidStatus) as refused:
        Foxglove(f"wss://{address}:{port}/", ssl=trust)
    assert refused.value.response.status_code == 401
    with pytest.raises(InvalidURI):  # it is led to https
        Foxglove(f"ws://{address}:{port}/")
    with closing(Foxglove(f"wss://{address}:{port}/?token={robot.token}", ssl=trust)) as operates:
        assert operates.newest("drive/state")["moving"] is False
        before = robot.capability("foxglove")["pid"]
        assert here(robot.home, "token", "revoke", "viewer").returncode == 0
        with pytest.raises(ConnectionClosed):
            operates.until(lambda: False, "its end")
        assert robot.capability("foxglove")["pid"] == before
