"""What a broker says, and what is said to it: pure, so that it is tried with whatever may come."""

import json
import re
import socket
import ssl
import struct
import threading
from contextlib import suppress
from math import inf

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.apps.mqtt import discovery, documents, report, words
from lbr.apps.mqtt.kind import KIND
from lbr.apps.mqtt.session import Broker, Session, secured
from lbr.apps.mqtt.shadow import ShadowState
from lbr.apps.retry import wait_s
from lbr.capability.context import Received
from lbr.errors import InputError
from lbr.messages.battery import BatteryState
from lbr.messages.drive import DriveCommand
from lbr.messages.leases import StopCommand
from tests.support import mosquitto, needs
from tests.support.robot import free_port
from tests.support.waiting import until

needs.modules("paho")

JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text(max_size=12),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=8), inner, max_size=3),
    max_leaves=12,
)
KEYS = st.sampled_from(["battery", "position", "answer", "x"])
FLAT = st.none() | st.booleans() | st.integers(-3, 3) | st.sampled_from(["", "a"]) | st.lists(st.integers(0, 2))
REPORTS = st.dictionaries(
    KEYS, st.recursive(FLAT, lambda inner: st.dictionaries(KEYS, inner, max_size=3), max_leaves=6)
)
WORDS = {
    "stop": words.StopWord(),
    "dock": words.RunWord(table="dock"),
    "say": words.SayWord(),
    "turn": words.TurnWord(most_deg=90.0),
    "north": words.HeadingWord(heading_deg=0.0),
    "go": words.GoWord(most_cm=50.0),
    "ahead": words.GoWord(distance_cm=30.0),
    "wave": words.PlayWord(motion="wave"),
}


def without_null(value):
    return {k: without_null(v) for k, v in value.items() if v is not None} if isinstance(value, dict) else value


@given(REPORTS, REPORTS)
def test_what_is_told_of_a_change_makes_the_one_report_of_the_other_and_no_change_is_told_of(before, now):
    change = report.difference(without_null(before), now)
    assert without_null(report.merged(without_null(before), change)) == without_null(now)
    assert report.difference(report.merged(without_null(before), change), now) == {}


@given(st.binary(max_size=200) | JSON.map(lambda value: json.dumps(value).encode()))
def test_whatever_bytes_come_they_are_a_document_or_a_sentence(payload):
    with suppress(InputError):
        said = documents.read(payload)
        for read in (documents.document, documents.answer, documents.version_of):
            with suppress(InputError):
                read(said)


@given(JSON, st.sampled_from(["view", "operate", "admin", None]))
def test_whatever_is_asked_is_a_bounded_order_or_a_refusal(raw, role):
    with suppress(InputError):
        bounded(words.order(words.read(raw), WORDS, role))


@given(
    st.sampled_from(sorted(WORDS)),
    st.none() | st.floats() | st.text(max_size=300),
    st.sampled_from(["view", "operate"]),
)
def test_a_word_with_whatever_comes_with_it_is_bounded_and_for_its_role(word, value, role):
    with suppress(InputError):
        order = words.order(words.Ask(word=word, value=value), WORDS, role)
        bounded(order)
        assert role == "operate" or isinstance(order, StopCommand)


def bounded(order):
    """It can be sent as it is, and what drives has an end."""
    msgspec.json.decode(msgspec.json.encode(order), type=type(order))
    if isinstance(order, DriveCommand):
        assert 1.0 <= order.distance_cm <= 50.0


@pytest.mark.parametrize(
    ("raw", "role", "code"),
    [
        ({"word": "estop"}, "admin", "denied"),
        ({"word": "dock"}, None, "token"),
        ({"word": "dock"}, "view", "role"),
        ({"word": "dock", "value": 3}, "operate", "bad_value"),
        ({"word": "go"}, "operate", "bad_value"),
        ({"word": "go", "value": 51}, "operate", "bad_value"),
        ({"word": "go", "value": 0}, "operate", "bad_value"),
        ({"word": "turn", "value": "far"}, "operate", "bad_value"),
        ({"word": "say", "value": "x" * 251}, "operate", "bad_value"),
        ({"word": "dock", "power": 1.0}, "operate", "malformed"),
        ("dock", "operate", "malformed"),
    ],
)
def test_what_a_row_does_not_allow_is_refused_with_its_code(raw, role, code):
    with pytest.raises(InputError) as refused:
        words.order(words.read(raw), WORDS, role)
    assert refused.value.code == code


class Service:
    """What a shadow of ours says and hears, without a broker; `now` is the time."""

    def __init__(self):
        self.now = 100.0
        self.shadow = ShadowState("rob", "", 5.0, "mark")
        self.report = {"battery": {"voltage_v": 12.1}}

    def said(self):
        found = list(self.shadow.publish(self.report, self.now))
        return [(topic.rpartition("shadow/")[2], json.loads(payload)) for topic, payload in found]

    def hears(self, topic, **body):
        return self.shadow.receive(f"{self.shadow.root}/{topic}", json.dumps(body).encode(), self.now)

    def token(self):
        ((topic, body),) = [one for one in self.said() if one[0] == "get"]
        assert topic == "get"
        return body["clientToken"]


def document(version, ask=None, age_s=1):
    desired = {} if ask is None else {"ask": ask, "lamp": "on"}
    stamps = {"desired": {"ask": {"word": {"timestamp": 1000 - age_s}}}} if age_s is not None else {}
    return {"state": {"desired": desired, "reported": {}}, "metadata": stamps, "version": version, "timestamp": 1000}


def test_a_report_is_of_what_changed_under_the_version_that_is_known_and_no_two_are_within_five_seconds():
    service = Service()
    service.hears("get/accepted", **document(7), clientToken=service.token())
    ((topic, body),) = service.said()
    assert (topic, body["state"], body["version"]) == ("update", {"reported": service.report}, 7)
    service.hears("update/accepted", version=8, clientToken=body["clientToken"])
    service.report = {"battery": {"voltage_v": 12.1}, "docked": True}
    service.now += 4.9
    assert service.said() == []
    service.now += 0.1
    ((_topic, body),) = service.said()
    assert (body["state"], body["version"]) == ({"reported": {"docked": True}}, 8)
    service.hears("update/accepted", version=9, clientToken=body["clientToken"])
    service.now += 60.0
    assert service.said() == []


def test_one_who_was_first_is_heard_before_it_is_reported_again():
    service = Service()
    service.hears("get/accepted", **document(7), clientToken=service.token())
    ((_topic, body),) = service.said()
    service.hears("update/rejected", code=409, message="Version conflict", clientToken=body["clientToken"])
    service.now += 6.0
    (got, (topic, again)) = service.said()
    assert (got[0], topic, again["version"]) == ("get", "update", 7)
    service.hears("update/rejected", code=409, clientToken=again["clientToken"])
    service.hears("get/accepted", **document(12), clientToken=got[1]["clientToken"])
    service.now += 6.0
    assert dict(service.said())["update"]["version"] == 12


def test_what_is_desired_is_asked_once_and_by_an_answer_to_us_alone():
    service = Service()
    ask = {"word": "dock", "id": 1}
    token = service.token()
    assert service.hears("get/accepted", **document(3, ask), clientToken="another's") is None
    asked = service.hears("get/accepted", **document(3, ask), clientToken=token)
    assert asked == (ask, 1.0)
    assert service.shadow.done(asked.raw) == ask
    service.hears("update/delta", version=4, state={"ask": ask})
    service.now += 2.0
    assert service.hears("get/accepted", **document(4, ask), clientToken=service.token()) is None
    service.shadow.connected()
    service.now += 2.0
    assert service.hears("get/accepted", **document(4, ask), clientToken=service.token()) is None
    assert service.hears("get/accepted", **document(4, ask | {"id": 2}), clientToken=token) is None


def test_an_older_version_and_an_old_delta_count_for_nothing():
    service = Service()
    service.hears("get/accepted", **document(9), clientToken=service.token())
    service.now += 2.0
    service.hears("update/delta", version=9, state={})
    assert [topic for topic, _ in service.said()] == ["update"]
    service.hears("update/delta", version=10, state={"ask": 1})
    with pytest.raises(InputError, match="its version is 2, and 9 was there before"):
        service.hears("get/accepted", **document(2, {"word": "dock"}), clientToken=service.token())
    assert service.shadow.version == 9


def test_without_times_nobody_knows_for_how_long_it_has_been_desired():
    service = Service()
    asked = service.hears("get/accepted", **document(3, {"word": "dock"}, age_s=None), clientToken=service.token())
    assert asked.age_s is None


@given(
    st.sampled_from(ShadowState("rob", "x", 5.0, "m").topics),
    st.binary(max_size=80) | JSON.map(lambda j: json.dumps(j).encode()),
)
def test_whatever_a_service_says_it_is_a_sentence_at_worst_and_desired_is_never_written(topic, payload):
    shadow = ShadowState("rob", "x", 5.0, "m")
    for now in (0.0, 20.0):
        with suppress(InputError):
            shadow.receive(topic, payload, now)
        for where, body in shadow.publish({"docked": True}, now):
            assert where.endswith("/get") or set(json.loads(body)["state"]) == {"reported"}


def test_waiting_grows_to_a_minute_and_is_never_in_step():
    assert [wait_s(tries, lambda: 1.0) for tries in (0, 1, 2, 20, 10**6)] == [0.5, 1.0, 2.0, 60.0, 60.0]
    assert wait_s(5, lambda: 0.0) == 0.5 * wait_s(5, lambda: 1.0)


def test_what_is_old_or_unknown_is_told_as_null():
    battery = BatteryState(valid=True, voltage_v=12.345, charge=0.5, charging=True)
    heard = {"battery": Received(battery, None, 100.0, "battery")}
    found = report.report(("battery", "docked"), heard.get, ("battery",), 101.0)
    assert found == {
        "battery": {"charge_percent": 50, "voltage_v": 12.3, "level": "unknown", "charging": True},
        "docked": True,
    }
    later = report.report(("battery", "docked", "faults"), heard.get, ("battery",), 104.0)
    assert later == {"battery": None, "docked": None, "faults": ["battery: it reports nothing"]}


def test_home_assistant_gets_a_sensor_for_each_part_and_a_button_or_field_for_each_word():
    said = discovery.document("rob", "", "lbr/rob", KIND.settings().report, WORDS, picture=True, version="1")
    parts = said["cmps"]
    platforms = {key: one["p"] for key, one in parts.items()}
    assert {platforms[f"ask_{word}"] for word in ("stop", "dock", "north", "ahead", "wave")} == {"button"}
    assert (platforms["ask_say"], platforms["ask_turn"], platforms["camera"]) == ("text", "number", "camera")
    assert {"battery", "docked", "position_x", "faults"} <= set(platforms)
    assert (parts["ask_go"]["min"], parts["ask_go"]["max"]) == (-50.0, 50.0)
    assert len({one["unique_id"] for one in parts.values()}) == len(parts)
    assert not any("state_topic" in one for key, one in parts.items() if key.startswith("ask_"))


def test_each_sensor_is_available_while_the_robot_knows_its_value_and_no_template_reads_what_is_not_there():
    said = discovery.document("rob", "", "lbr/rob", KIND.settings().report, {}, picture=False, version="1")
    sensors = {key: one for key, one in said["cmps"].items() if one["state_topic"] == "lbr/rob/state"}
    assert set(sensors) == set(said["cmps"]) - {"answer"}
    for one in sensors.values():
        whole, known = one["availability"]
        assert (one["availability_mode"], whole) == ("all", said["availability"][0])
        assert known["topic"] == one["state_topic"]
        read = known["value_template"].partition("%}")[0]
        assert one["value_template"].startswith(read)
        assert re.fullmatch(r"\{% set v = \(?value_json\.get\('\w+'\)( or \{\}\)\.get\('\w+'\))? ", read)
    assert "None" in sensors["fault"]["value_template"]


def test_faults_are_not_known_where_no_stream_would_tell_them():
    assert report.report(("faults",), {}.get, (), 1.0) == {"faults": None}


@pytest.mark.parametrize(
    ("settings", "complaint"),
    [
        ('{"host": "broker.example", "tls": false}', "clear_text"),
        ('{"certificate": "a.crt"}', "each needs the other"),
        ('{"ca": "../x"}', "ca"),
        ('{"every_s": 1}', "every_s"),
        ('{"words": {"x": {"do": "drive"}}}', "drive"),
        ('{"words": {"x": {"do": "go", "most_cm": 5000}}}', "most_cm"),
        ('{"topic": "a/#"}', "topic"),
    ],
)
def test_a_bad_row_says_what_is_wrong(settings, complaint):
    with pytest.raises(msgspec.ValidationError, match=complaint):
        KIND.parse(settings)


class Liar:
    """A broker that lets everybody in, and then sends what it likes."""

    def __init__(self, lies):
        self.socket = socket.create_server(("127.0.0.1", 0))
        self.port = self.socket.getsockname()[1]
        self._lies = lies
        self.served = 0
        threading.Thread(target=self._serve, daemon=True).start()

    def _serve(self):
        with suppress(OSError):
            while True:
                peer, _ = self.socket.accept()
                self.served += 1
                with peer, suppress(OSError):
                    peer.recv(4096)
                    peer.sendall(b"\x20\x03\x00\x00\x00")  # CONNACK
                    subscribed = peer.recv(4096)
                    peer.sendall(b"\x90\x04" + subscribed[2:4] + b"\x00\x01")  # SUBACK
                    for lie in self._lies:
                        peer.sendall(lie)
                    peer.recv(4096)

    def close(self):
        self.socket.close()


HUGE = b"\x30\xff\xff\xff\x7f" + struct.pack(">H", 1) + b"a"


@pytest.mark.parametrize(
    ("lies", "complaint"),
    [
        ([HUGE, b"x" * 300_000], "it sent 268435455 bytes at once, and 66560 are the most"),
        ([b"\x30\xff\xff\xff\xff\xff\xff"], ""),
        ([b"\x30\x03\xff\xff\x00"], ""),
        ([b"\xf7" * 64], ""),
        ([b"\x30\x05\x00\x02\xff\xfe\x00"], ""),
    ],
)
def test_a_broker_that_talks_nonsense_is_left_and_tried_again(lies, complaint):
    liar = Liar(lies)
    broker = Broker(host="127.0.0.1", port=liar.port, client_id="rob", keepalive_s=20, topics=("a",))
    session, told = Session(broker, lambda: told.add(session.trouble), lambda _: False), set()
    session.start()
    try:
        until(lambda: liar.served >= 2, what="a second try")
        assert any(complaint in one for one in told), told
    finally:
        session.close()
        liar.close()
    assert not session._thread.is_alive()


def test_no_broker_is_trusted_whose_certificate_is_anothers(tmp_path, monkeypatch):
    monkeypatch.setenv("LBR_HOME", str(tmp_path / "home"))
    mosquitto.certificates(tmp_path / "home" / "credentials", "robot")
    for path in (tmp_path / "home" / "credentials", tmp_path / "home"):
        path.chmod(0o700)
    (tmp_path / "home" / "credentials" / "open.key").write_text("x")
    (tmp_path / "home" / "credentials" / "open.key").chmod(0o644)
    assert secured("ca.crt", "robot.crt", "robot.key") is not None
    for files, complaint in [
        (("gone.crt", "", ""), "gone.crt is not there"),
        (("ca.crt", "robot.crt", "open.key"), "open.key"),
        (("ca.crt", "ca.crt", "robot.key"), "TLS cannot be spoken"),
    ]:
        with pytest.raises(InputError, match=complaint):
            secured(*files)


def test_an_authority_of_ones_own_need_not_say_what_its_key_is_for(tmp_path, monkeypatch):
    """As OpenSSL makes it by its usual words; Python 3.13 and newer are strict unless told not to be."""
    folder = tmp_path / "home" / "credentials"
    monkeypatch.setenv("LBR_HOME", str(tmp_path / "home"))
    mosquitto.certificates(folder, "broker", "robot")
    for path in (folder, tmp_path / "home"):
        path.chmod(0o700)
    plain = ssl.create_default_context

    def strict(**files):
        made = plain(**files)
        made.verify_flags |= ssl.VERIFY_X509_STRICT
        return made

    monkeypatch.setattr(ssl, "create_default_context", strict)
    assert secured("", "", "").verify_flags & ssl.VERIFY_X509_STRICT
    broker = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    broker.load_cert_chain(folder / "broker.crt", folder / "broker.key")
    with pytest.raises(ssl.SSLCertVerificationError, match="key usage"):
        shake_hands(strict(cafile=str(folder / "ca.crt")), broker)
    shake_hands(secured("ca.crt", "robot.crt", "robot.key"), broker)


def shake_hands(client, server):
    there, back = ssl.MemoryBIO(), ssl.MemoryBIO()
    ends = [client.wrap_bio(back, there, server_hostname="localhost"), server.wrap_bio(there, back, server_side=True)]
    for _ in range(3):
        for end in tuple(ends):
            with suppress(ssl.SSLWantReadError):
                end.do_handshake()
                ends.remove(end)
    assert not ends


def test_a_broker_that_is_not_there_is_told_of_and_costs_nothing():
    session = Session(
        Broker(host="127.0.0.1", port=free_port(), client_id="rob", keepalive_s=20), lambda: None, lambda _: False
    )
    session.start()
    until(lambda: "refused" in session.trouble, what="why")
    session.close()
    assert not session.connected
    assert session.count == 0
    assert inf > wait_s(3) > 0.0
