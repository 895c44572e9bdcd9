"""A whole robot at a real broker, by TLS both ways: what Home Assistant and a device shadow see of it, and have it do."""

import json
import os
import signal
from itertools import pairwise

import pytest

from lbr.apps.mqtt.kind import KIND
from lbr.messages.camera import JpegFrame
from lbr.testing import FakeContext
from tests.support import mosquitto, needs
from tests.support.commands import here
from tests.support.robot import PATIENT, prepare, running
from tests.support.waiting import STOPS_S, until

needs.modules("paho")
from tests.support.shadow_service import ShadowService  # noqa: E402 - it needs paho

pytestmark = [needs.program("mosquitto", "mosquitto"), pytest.mark.slow_start]

WORDS = {
    "stop": {"do": "stop"},
    "follow_wall": {"do": "run", "table": "follow_wall"},
    "go": {"do": "go", "most_cm": 150},
    "slowly": {"do": "go", "distance_cm": 140, "power": 0.1},
    "wave": {"do": "play", "motion": "wave"},
    "say": {"do": "say"},
    "round": {"do": "turn", "most_deg": 90},
}
TOPIC = "lbr/lbr"
FLOOD = 45
"""Of messages, twice: more at once than wait to be read, and fewer than may be answered without an acknowledgement."""
FIRST, TOO_SOON, SECOND = (b"\xff\xd8%s\xff\xd9" % one for one in (b"first", b"too soon", b"second"))


@pytest.fixture(scope="module")
def broker(tmp_path_factory):
    folder = tmp_path_factory.mktemp("broker")
    mosquitto.certificates(folder, "broker", "robot", "person", "service")
    broker = mosquitto.Mosquitto(folder)
    broker.start()
    yield broker
    broker.kill()


@pytest.fixture(scope="module")
def person(broker):
    person = mosquitto.Person(broker, "person", f"{TOPIC}/#", "homeassistant/#")
    yield person
    person.close()


@pytest.fixture(scope="module")
def service(broker):
    service = ShadowService(broker, "service", "rob")
    yield service
    service.close()


@pytest.fixture(scope="module")
def robot(tmp_path_factory, broker, person, service):
    settings = {
        "host": "localhost",
        "port": broker.port,
        "ca": "ca.crt",
        "certificate": "robot.crt",
        "key": "robot.key",
        "token": "home",
        "words": WORDS,
        "ttl_s": 1.0,
        "shadow": {"thing": "rob"},
        "home_assistant": {"name": "Rob"},
    }
    home = prepare(
        tmp_path_factory.mktemp("mqtt"),
        *("imu", "attitude", "odometry", "battery", "behaviour", "speech"),
        edits=(
            f"UPDATE capability SET enabled = 1, settings = '{json.dumps(settings)}' WHERE robot = 'lbr' AND name = 'mqtt'",
            *PATIENT,
        ),
    )
    credentials = home / "credentials"
    credentials.mkdir(mode=0o700)
    for name in ("ca.crt", "robot.crt", "robot.key"):
        (credentials / name).write_bytes((broker.folder / name).read_bytes())
        (credentials / name).chmod(0o600)
    assert here(home, "token", "add", "home", "--role", "operate").returncode == 0
    with running(home) as robot:
        until(lambda: asked(robot, "mqtt/state").get("version") is not None, what="the broker and the shadow")
        yield robot
    assert all(set(update["state"]) == {"reported"} for update in service.updates)


def asked(robot, key):
    """Return what is answered there; on a busy machine an answer may come only when it is asked for again."""
    return until(lambda: robot.ask(key), what=key)


def drive(robot):
    return asked(robot, "drive/state")


def answers(person, since=0):
    return [json.loads(one) for one in person.on(f"{TOPIC}/answer", since)]


def begin_motion(robot, person):
    """Ask for a slow motion, and again whenever it is refused: a busy machine's encoders or echoes are late."""
    since = None

    def moves():
        nonlocal since
        if drive(robot)["moving"]:
            return True
        if since is None or any(one["state"] in {"refused", "failed"} for one in answers(person, since)):
            since = len(person.heard)
            person.say(f"{TOPIC}/ask/slowly", "PRESS")
        return False

    until(moves, what="motion")


def rests(robot):
    until(lambda: not drive(robot)["moving"] and drive(robot)["holder"] is None, what="standing still")


def test_home_assistant_finds_the_robot_and_hears_how_it_is(robot, person):
    config = until(lambda: person.on("homeassistant/device/lbr_lbr/config"), what="the discovery")[-1]
    found = json.loads(config)
    assert found["dev"]["name"] == "Rob"
    assert {f"ask_{word}" for word in WORDS} <= set(found["cmps"])
    assert person.on(found["availability"][0]["topic"])[-1] == b"online"
    state = until(lambda: person.on(found["cmps"]["battery"]["state_topic"]), what="a state")[-1]
    assert json.loads(state)["motion"]["moving"] is False


def test_the_shadow_is_told_how_it_is(robot, service):
    until(lambda: service.state["reported"].get("battery", {}).get("voltage_v"), what="a report")
    assert service.state["desired"] == {}


def test_what_a_shadow_desires_is_done_once_and_answered_five_seconds_apart_and_stays_desired(robot, service, person):
    since, before = len(person.heard), asked(robot, "odometry/state")["distance_m"]
    desired = {"word": "go", "value": 30, "id": "a1"}
    service.desire(ask=desired, lamp="on")
    assert until(lambda: [one["state"] for one in answers(person, since)][1:], "its end") == ["done"]
    assert asked(robot, "odometry/state")["distance_m"] - before == pytest.approx(0.3, abs=0.08)
    until(lambda: service.state["reported"].get("answer", {}).get("state") == "done", what="the answer")
    assert service.state["desired"] == {"ask": desired, "lamp": "on"}
    assert service.state["reported"]["ask"] == desired
    assert [one["state"] for one in answers(person, since) if one["id"] == desired["id"]] == ["running", "done"]
    gaps = [late - early for early, late in pairwise(service.at)]
    assert min(gaps) > 4.8


@pytest.mark.parametrize(
    ("ask", "age_s", "code"),
    [
        ({"word": "estop", "id": "b1"}, 0, "denied"),
        ({"word": "go", "value": 400, "id": "b2"}, 0, "bad_value"),
        ({"word": "go", "value": 30, "id": "b3"}, 3600, "late"),
        (["go", 30], 0, "malformed"),
    ],
)
def test_what_a_shadow_may_not_desire_is_refused_by_its_topic_and_nothing_moves(
    robot, service, person, ask, age_s, code
):
    since = len(person.heard)
    service.desire(ask=ask, age_s=age_s)
    told = until(lambda: answers(person, since), what="the refusal")[0]
    assert (told["state"], told["code"]) == ("refused", code)
    assert told["reason"].startswith("$aws/things/rob/shadow/get/accepted: ")
    assert not drive(robot)["moving"]


@pytest.mark.parametrize(
    ("topic", "payload", "code"),
    [
        (f"{TOPIC}/ask", b'{"word": "go", ', "malformed"),
        (f"{TOPIC}/ask", b"[" * 2000, "malformed"),
        (f"{TOPIC}/ask", b'{"word": "go", "value": 1e999}', "malformed"),
        (f"{TOPIC}/ask", b"\xff\xfe", "malformed"),
        (f"{TOPIC}/ask", b'{"word": "dock"}', "denied"),
        (f"{TOPIC}/ask/go", b"NaN", "malformed"),
        (f"{TOPIC}/ask/wave", b"PRESS", "not_possible"),
        (f"{TOPIC}/ask/go", b"x" * 60_000, "malformed"),
        ("$aws/things/rob/shadow/update/delta", b"{", "malformed"),
        ("$aws/things/rob/shadow/update/delta", b'{"version": "newest"}', "malformed"),
    ],
)
def test_lies_are_refused_by_their_topic(robot, person, topic, payload, code):
    since, pid = len(person.heard), robot.capability("mqtt")["pid"]
    person.say(topic, payload)
    told = until(lambda: answers(person, since), what="the refusal")[0]
    assert (told["state"], told["code"]) == ("refused", code)
    assert told["reason"].startswith(f"{topic}: ")
    assert told["word"] == topic.removeprefix(f"{TOPIC}/ask/") or topic.endswith(("/ask", "/delta"))
    assert robot.capability("mqtt")["pid"] == pid


def test_a_refusal_says_which_asking_it_answers(robot, person):
    since = len(person.heard)
    person.say(f"{TOPIC}/ask", json.dumps({"word": "go", "value": 1e6, "id": "17"}))
    told = until(lambda: answers(person, since), what="the refusal")[0]
    assert (told["word"], told["id"], told["state"]) == ("go", "17", "refused")


def test_what_the_broker_has_kept_and_what_it_may_not_even_send_does_nothing(robot, person):
    since = len(person.heard)
    person.say(f"{TOPIC}/ask/go", "100", retain=True)  # whoever subscribes anew would have it again
    until(lambda: answers(person, since), what="it being done once, as it is new")
    person.say(f"{TOPIC}/ask/stop", "")
    person.say(f"{TOPIC}/ask/go", "", retain=True)
    rests(robot)
    state = asked(robot, "mqtt/state")
    person.say(f"{TOPIC}/ask", b"x" * 500_000)
    person.say(f"{TOPIC}/ask", b"[]")
    until(lambda: asked(robot, "mqtt/state")["refused"] > state["refused"], what="the one after")
    assert asked(robot, "mqtt/state")["connections"] == state["connections"]


def test_what_comes_with_a_word_is_said_and_turned_by(robot, person):
    since, before = len(person.heard), asked(robot, "attitude/state")["turned_deg"]
    person.say(f"{TOPIC}/ask/say", "Dinner is ready")
    person.say(f"{TOPIC}/ask", json.dumps({"word": "round", "value": 40, "id": 7}))
    until(lambda: "done" in [one["state"] for one in answers(person, since) if one["id"] == 7])
    assert asked(robot, "attitude/state")["turned_deg"] - before == pytest.approx(40.0, abs=6.0)
    assert "done" in [one["state"] for one in answers(person, since) if one["word"] == "say"]
    until(lambda: asked(robot, "speech/state")["spoken"] >= 1, what="the sentence")


def test_a_table_runs_when_asked_and_a_stop_from_there_ends_it(robot, person):
    person.say(f"{TOPIC}/ask/follow_wall", "PRESS")
    until(lambda: asked(robot, "behaviour/state")["phase"] == "running", what="the table")
    person.say(f"{TOPIC}/ask/stop", "PRESS")
    until(lambda: asked(robot, "behaviour/state")["phase"] == "ended", what="its end")
    rests(robot)


def test_a_stop_in_a_flood_of_other_messages_ends_what_moves(robot, person):
    flood = [f"{TOPIC}/ask/nothing"] * FLOOD

    def ended():
        """Return how a motion ended; on a busy machine its lease may lapse before the stop."""
        begin_motion(robot, person)
        for topic in (*flood, f"{TOPIC}/ask/stop", *flood):
            person.client.publish(topic, "PRESS", qos=0)
        rests(robot)
        return asked(robot, "drive/result")

    result = until(lambda: (one := ended())["code"] != "lapsed" and one, what="a motion that is stopped")
    assert result["reason"] == "stopped by mqtt: stopped by 'stop'"


def test_when_the_sender_is_killed_the_robot_stops_by_its_lease_and_is_told_to_be_gone(robot, person):
    since = len(person.heard)
    begin_motion(robot, person)
    os.kill(robot.capability("mqtt")["pid"], signal.SIGKILL)
    until(lambda: drive(robot)["holder"] is None, what="its stop", limit_s=STOPS_S)
    assert not drive(robot)["moving"]
    until(lambda: b"offline" in person.on(f"{TOPIC}/available", since), what="the will")
    until(lambda: person.on(f"{TOPIC}/available", since)[-1] == b"online", what="it again")
    assert not drive(robot)["moving"]


def test_a_broker_that_stands_still_stops_what_it_asked_for_and_what_it_held_back_moves_nothing(robot, broker, person):
    connections = until(lambda: (state := asked(robot, "mqtt/state"))["connected"] and state["connections"])
    begin_motion(robot, person)
    since = len(person.heard)
    broker.freeze()
    try:
        person.client.publish(f"{TOPIC}/ask/slowly", "PRESS", qos=1)
        until(lambda: "it stands still" in robot.capability("mqtt")["reason"], what="the sign of it, 3 s after a word")
        until(lambda: drive(robot)["holder"] is None, what="its stop", limit_s=STOPS_S)
        assert not drive(robot)["moving"]
    finally:
        broker.thaw()
    told = until(lambda: [one for one in answers(person, since) if one["state"] == "refused"], what="the refusal")[-1]
    assert (told["word"], told["code"]) == ("slowly", "late")
    assert f"{TOPIC}/echo" in told["reason"]
    assert asked(robot, "mqtt/state")["connections"] == connections
    begin_motion(robot, person)
    person.say(f"{TOPIC}/ask/stop", "PRESS")
    rests(robot)


def test_a_broker_that_is_killed_stops_what_it_asked_for_and_is_found_again(robot, broker, person):
    before = until(lambda: (state := asked(robot, "mqtt/state"))["connected"] and state, what="the broker")[
        "connections"
    ]
    begin_motion(robot, person)
    broker.kill()
    until(lambda: not drive(robot)["moving"], what="its stop", limit_s=STOPS_S)
    loss = f"the broker localhost:{broker.port}: "
    until(lambda: (one := robot.capability("mqtt"))["phase"] == "degraded" and loss in one["reason"], what="the loss")
    broker.start()
    until(lambda: asked(robot, "mqtt/state")["connections"] > before, what="the broker again")
    until(lambda: robot.capability("mqtt")["phase"] == "ready", what="its health")


@pytest.fixture
def alone(broker, tmp_path, monkeypatch):
    """Return what makes the capability without a robot, at the broker of the test or another one, with its context."""
    monkeypatch.setenv("LBR_HOME", str(tmp_path))
    credentials = tmp_path / "credentials"
    credentials.mkdir(mode=0o700)
    for name in ("ca.crt", "robot.crt", "robot.key"):
        (credentials / name).write_bytes((broker.folder / name).read_bytes())
        (credentials / name).chmod(0o600)

    def make(port, **settings):
        files = {"ca": "ca.crt", "certificate": "robot.crt", "key": "robot.key"}
        settings = {"host": "localhost", "port": port, "topic": f"{TOPIC}/eye", **files, **settings}
        ctx = FakeContext(KIND, KIND.parse(json.dumps(settings)), robot="eye", name="mqtt")
        return KIND.load()(ctx), ctx

    return make


def test_a_robot_that_may_not_hear_its_own_word_says_so_before_anybody_asks_it(broker, alone):
    strict = mosquitto.Mosquitto(broker.folder, rights="topic read #\ntopic write lbr/lbr/eye/available")
    strict.start()
    mqtt, ctx = alone(strict.port, words={"say": {"do": "say"}})
    mqtt.open()
    try:
        until(lambda: (mqtt.step(), ctx.health[-1:] == ["ready"])[1], what="the broker")
        for _ in range(40):
            ctx.now += 0.1
            mqtt.step()
        assert f"nothing comes back on {TOPIC}/eye/echo: " in ctx.health[-1]
    finally:
        mqtt.close()
        strict.kill()


def test_a_refusal_by_a_topic_of_any_length_is_short_enough_to_be_an_event(broker, alone, person):
    mqtt, ctx = alone(broker.port, words={"say": {"do": "say"}})
    mqtt.open()
    try:
        until(lambda: (mqtt.step(), ctx.health[-1:] == ["ready"])[1], what="the broker")
        topic = f"{TOPIC}/eye/ask/" + "w" * 60_000
        person.say(topic, "1")
        refused = until(lambda: (mqtt.step(), [text for kind, text in ctx.events if kind == "refused"])[1], what="it")
        assert len(refused[-1]) < 500
        assert topic.startswith(refused[-1].partition(":")[0])
    finally:
        mqtt.close()


def test_a_picture_is_sent_while_it_is_new_and_as_often_as_the_row_says(broker, person, alone):
    mqtt, ctx = alone(broker.port, home_assistant={"picture_s": 2.0})
    mqtt.open()
    try:
        until(lambda: (mqtt.step(), ctx.health[-1:] == ["ready"])[1], what="the broker")
        for later_s, picture in ((2.0, FIRST), (1.0, TOO_SOON), (1.0, SECOND)):
            ctx.now += later_s
            ctx.arrive("frames", JpegFrame(picture))
            mqtt.step()
        ctx.now += 9.0  # the camera is off
        mqtt.step()
        until(lambda: len(person.on(f"{TOPIC}/eye/picture")) >= 2, what="the pictures")
    finally:
        mqtt.close()
    until(lambda: person.on(f"{TOPIC}/eye/available")[-1:] == [b"offline"], what="its goodbye")
    assert person.on(f"{TOPIC}/eye/picture") == [FIRST, SECOND]


def test_a_token_that_is_revoked_and_a_row_without_a_broker_ask_for_nothing(robot, person):
    since = len(person.heard)
    person.say(f"{TOPIC}/ask/slowly", "PRESS")
    until(lambda: answers(person, since), what="its answer")
    robot.line("stop")
    rests(robot)
    assert here(robot.home, "token", "revoke", "home").returncode == 0
    since = len(person.heard)

    def refused():
        person.say(f"{TOPIC}/ask/slowly", "PRESS")
        return [one for one in answers(person, since) if one["code"] == "token"]

    until(refused, what="the refusal")
    rests(robot)
    assert (
        f"'slowly' was asked for on {TOPIC}/ask/slowly" in here(robot.home, "db", "audit", "-n", "500", "--json").stdout
    )
    robot.edit("UPDATE capability SET settings = '{}' WHERE robot = 'lbr' AND name = 'mqtt'")
    told = until(lambda: "no broker is named" in robot.capability("mqtt")["reason"] and robot.capability("mqtt"))
    assert (told["phase"], told["code"]) == ("degraded", "off")
