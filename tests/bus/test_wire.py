"""Publishing, asking and answering on a real router: bounded, in order, and each refusal with its code."""

import json
import threading

import pytest

from lbr.bus import access, inflow, keys, links, probe, session, stamp, wire
from lbr.bus.access import Credentials, Rights
from lbr.errors import BusError
from lbr.leases import over_session
from lbr.messages.leases import CommandReply
from tests.support.waiting import HANG_S, until


@pytest.fixture(scope="module")
def endpoint(tmp_path_factory):
    return f"unixsock-stream/{tmp_path_factory.mktemp('bus')}/r.sock"


@pytest.fixture(scope="module")
def router(endpoint):
    with session.open_router(session.Router(listen=(endpoint,))) as opened:
        yield opened


@pytest.fixture(scope="module")
def client(router, endpoint):
    with session.open_client([endpoint]) as opened:
        yield opened


@pytest.fixture
def served(router, request):
    """A command key of its own for each test."""
    server = wire.QueryServer(router, f"r/{request.node.name.partition('[')[0]}/go", lambda: None, source="motors")
    yield server
    server.close()


@pytest.mark.parametrize("listen", [wire.Subscription, lambda bus, key: wire.ask(bus, key, {}, source="test")])
def test_what_is_no_key_is_refused_without_a_place_in_the_librarys_source(client, listen):
    with pytest.raises(BusError, match=r"^r/\*x: Invalid Key Expr") as refused:
        listen(client, "r/*x")
    assert ".rs" not in str(refused.value)


def test_a_question_waits_until_it_is_answered_and_is_answered_once(client, served):
    asked = wire.PendingQuery(client, served.key, b'{"n": 1}', timeout_s=5.0, source="test")
    (request,) = until(served.take)
    assert request.answerable
    assert json.loads(request.payload) == {"n": 1}
    assert stamp.read(request.attachment).source == "test"
    request.reply({"accepted": True}, "motors")
    request.reply({"accepted": False}, "motors")
    until(lambda: asked.done)
    assert [json.loads(one.payload) for one in asked.replies] == [{"accepted": True}]
    assert not request.answerable


def test_what_is_only_asked_is_not_told_by_a_put(client, router):
    asked = wire.QueryServer(router, "r/asked/go", lambda: None, puts=False, source="motors")
    told = wire.QueryServer(router, "r/asked/told", lambda: None, source="motors")
    for server in (asked, told):
        wire.put(client, server.key, {}, source="test", urgent=True)
    until(told.take)
    question = wire.PendingQuery(client, asked.key, b'{"n": 1}', timeout_s=5.0, source="test")
    (request,) = until(asked.take)
    assert json.loads(request.payload) == {"n": 1}
    request.reply({"accepted": True}, "motors")
    until(lambda: question.done)
    asked.close()
    told.close()


def test_what_was_closed_is_neither_asked_nor_told_any_more(client, router):
    server = wire.QueryServer(router, "r/closed/go", lambda: None, source="motors")
    server.close()
    assert wire.ask(client, server.key, {}, source="test", timeout_s=0.3) == []
    wire.put(client, server.key, {}, source="test", urgent=True)
    other = wire.QueryServer(router, "r/closed/other", lambda: None, source="motors")
    wire.put(client, other.key, {}, source="test", urgent=True)
    until(other.take)
    other.close()
    assert server.take() == []


def test_commands_queue_in_order_and_no_more_than_fit(client, served):
    asked = [
        wire.PendingQuery(client, served.key, str(n).encode(), timeout_s=5.0, source="test")
        for n in range(wire.MAX_WAITING_COMMANDS + 3)
    ]
    until(lambda: served.dropped == 3)
    taken = served.take()
    assert sorted(int(one.payload) for one in taken) == [int(one.payload) for one in taken]
    assert len(taken) == wire.MAX_WAITING_COMMANDS
    assert served.take() == []
    for request in taken:
        request.reply(CommandReply(accepted=True), "motors")
    until(lambda: all(one.done for one in asked))
    refused = [json.loads(one.replies[0].payload) for one in asked[wire.MAX_WAITING_COMMANDS :]]
    assert {one["code"] for one in refused} == {"busy"}
    assert {one["accepted"] for one in refused} == {False}


def test_a_flood_of_puts_is_cut_off_too_and_none_of_them_is_answered(client, served):
    for n in range(3 * wire.MAX_WAITING_COMMANDS):
        wire.put(client, served.key, n, source="flood", urgent=True)
    until(lambda: served.dropped == 2 * wire.MAX_WAITING_COMMANDS)
    taken = served.take()
    assert [int(one.payload) for one in taken] == list(range(wire.MAX_WAITING_COMMANDS))
    assert not any(one.answerable for one in taken)
    taken[0].reply({"accepted": True}, "motors")


def test_what_quotes_the_lease_is_served_first_and_has_room_of_its_own_in_a_flood(client, served):
    served.first = b"0123abcd"
    for n in range(wire.MAX_WAITING_COMMANDS + 1):
        wire.put(client, served.key, n, source="flood", urgent=True)
    until(lambda: served.dropped == 1)
    for n in range(2):
        wire.put(client, served.key, {"n": n, "lease": "0123abcd"}, source="holder", urgent=True)
    wire.put(client, served.key, {"lease": "another"}, source="other", urgent=True)
    until(lambda: served.dropped == 2)
    taken = [json.loads(request.payload) for request in served.take()]
    assert taken[:3] == [{"n": 0, "lease": "0123abcd"}, {"n": 1, "lease": "0123abcd"}, 0]
    assert len(taken) == wire.MAX_WAITING_COMMANDS + 2


class AtOnce(inflow.Inflow):
    """For which no time passes, however long a busy machine takes to bring what was sent."""

    def admits(self, sender: str, now: float) -> bool:
        return super().admits(sender, 0.0)


def test_a_sender_that_floods_leaves_room_for_another(client, router):
    key = "r/inflow/go"
    served = wire.QueryServer(router, key, lambda: None, source="motors", inflow=AtOnce())
    for n in range(10 * wire.MAX_WAITING_COMMANDS):
        wire.put(client, key, n, source="flood", urgent=True)
    wire.put(client, key, {}, source="other", urgent=True)
    last = until(lambda: next((one for one in reversed(served._waiting) if one.payload == b"{}"), None))
    assert stamp.read(last.attachment).source == "other"
    assert served.dropped
    served.close()


def test_who_looks_around_with_a_wildcard_commands_nobody(client, served):
    assert wire.ask(client, f"{served.key.rpartition('/')[0]}/*", {"n": 1}, source="test", timeout_s=0.3) == []
    assert served.take() == []


def test_nobody_there_answers_nothing_within_the_time(client):
    assert wire.ask(client, "r/nobody/go", {}, source="test", timeout_s=0.3) == []
    assert wire.ask_all(client, ["r/nobody/a", "r/nobody/b"], source="test", timeout_s=0.3) == []


@pytest.mark.parametrize("key", ["", "/r", "r/", "r//x", "r/**/**#"])
def test_a_key_that_is_none_is_an_error_of_the_bus_that_names_it(client, key):
    for asking in (
        lambda: wire.ask(client, key, {}, source="test"),
        lambda: wire.PendingQuery(client, key, b"", timeout_s=1.0, source="test"),
        lambda: wire.put(client, key, {}, source="test"),
        lambda: probe.survey(client, key, source="test"),
    ):
        with pytest.raises(BusError) as found:
            asking()
        assert str(found.value).startswith(f"{key}: ")


def test_several_are_asked_at_once_each_key_once(client, router):
    servers = [wire.ComputedReply(router, f"r/many/{n}", lambda n=n: {"n": n}) for n in range(3)]
    asked = [f"r/many/{n}" for n in (0, 1, 2, 1, 0)]
    found = wire.ask_all(client, asked, source="test", timeout_s=5.0)
    assert sorted(json.loads(one.payload)["n"] for one in found) == [0, 1, 2]
    assert servers


def test_a_document_is_made_once_and_a_computed_one_each_time(client, router):
    made = []
    static = wire.StaticReply(router, "r/doc/static", lambda: made.append(1) or {"n": len(made)})
    computed = wire.ComputedReply(router, "r/doc/computed", lambda: made.append(1) or {"n": len(made)})
    told = [
        json.loads(wire.ask(client, key, None, source="test")[0].payload)["n"]
        for key in ("r/doc/static", "r/doc/static", "r/doc/computed", "r/doc/computed")
    ]
    assert told == [1, 1, 2, 3]
    assert static
    assert computed


def test_a_publisher_answers_with_its_latest_until_it_forgets_or_closes(client, router):
    stream = wire.Publisher(router, "r/imu/sample", "imu", seal=b"k" * 16)
    assert wire.ask(client, stream.key, None, source="test") == []
    for n in range(3):
        stream.put({"n": n})
    (latest,) = wire.ask(client, stream.key, None, source="test")
    assert json.loads(latest.payload) == {"n": 2}
    found = stamp.read(latest.attachment)
    assert (found.source, found.seq) == ("imu", 3)
    assert stamp.genuine(found, latest.payload, b"k" * 16)
    stream.forget()
    assert wire.ask(client, stream.key, None, source="test") == []
    stream.put({"n": 3})
    assert len(wire.ask(client, stream.key, None, source="test")) == 1
    stream.close()
    assert wire.ask(client, stream.key, None, source="test", timeout_s=0.3) == []


def test_a_publisher_of_pictures_knows_whether_there_is_a_subscriber(client, endpoint):
    told = []
    with session.open_client((endpoint,)) as bus:
        stream = wire.Publisher(bus, "r/camera_front/frame", "camera", pictures=True, watching=lambda: told.append(1))
        assert not stream.watched
        one, all_of_them = wire.PolledSubscription(client, stream.key), wire.Subscription(client, "r/camera_$*/frame")
        until(lambda: stream.watched)
        one.close()
        wire.ask(client, stream.key, None, source="test")
        assert stream.watched
        all_of_them.close()
        until(lambda: not stream.watched)
        assert len(told) >= 3
        stream.close()


def test_a_subscription_keeps_the_newest_and_wakes_for_each(client, router):
    woken = []
    heard = wire.Subscription(client, "r/ranges/*", depth=2, wake=lambda: woken.append(1))
    end = wire.Subscription(client, "r/end")
    stream = wire.Publisher(router, "r/ranges/readings", "ranges")
    until(lambda: stream.put({"n": 0}) and heard.take(), what="the first message")
    until(lambda: router.put("r/end", "{}") or end.take(), what="what was before has come")
    heard.take()
    woken.clear()
    for n in range(1, 6):
        stream.put({"n": n})
    until(lambda: len(woken) == 5)
    taken = heard.take()
    assert [json.loads(one.payload)["n"] for one in taken] == [4, 5]
    assert {one.key for one in taken} == {"r/ranges/readings"}
    assert [stamp.read(one.attachment).seq for one in taken] == sorted(stamp.read(one.attachment).seq for one in taken)
    heard.close()
    stream.put({"n": 9})
    assert heard.take() == []


def test_the_bytes_and_the_stamp_of_another_are_passed_on_as_they_are(client, served):
    attachment = stamp.make("phone", 41, b"payload")
    wire.forward(client, served.key, b"payload", attachment)
    (request,) = until(served.take)
    assert (request.payload, request.attachment) == (b"payload", attachment)
    asked = wire.PendingQuery(client, served.key, b"x", timeout_s=5.0, source="lan", attachment=attachment)
    (request,) = until(served.take)
    assert stamp.read(request.attachment).source == "phone"
    request.forward_reply(b'{"from": "elsewhere"}', attachment)
    until(lambda: asked.done)
    assert asked.replies[0].payload == b'{"from": "elsewhere"}'


def test_a_question_by_a_token_is_sealed_with_its_secret(client, served):
    proof = Credentials(user="ann", password="secret")
    wire.PendingQuery(client, served.key, b"payload", timeout_s=5.0, source="far", proof=proof)
    (request,) = until(served.take)
    found = stamp.read(request.attachment)
    assert found.token == "ann"
    assert stamp.genuine(found, request.payload, b"secret")
    assert not stamp.genuine(found, request.payload, b"guess")


def test_presence_is_known_from_the_beginning_and_until_the_session_ends(client, router, endpoint):
    changed = []
    token = wire.alive(router, "r", "motors")
    presence = wire.Presence(client, "r", lambda name, here: changed.append((name, here)))
    until(lambda: presence.names == {"motors"})
    with session.open_client([endpoint]) as other:
        held = [wire.alive(other, "r", "drive"), wire.alive(other, "another", "drive")]
        until(lambda: presence.names == {"motors", "drive"})
        assert held
    until(lambda: presence.names == {"motors"})
    assert changed == [("motors", True), ("drive", True), ("drive", False)]
    token.undeclare()
    until(lambda: not presence.names)
    presence.close()


def test_an_exception_on_the_librarys_thread_is_told_and_not_swallowed(client, router, monkeypatch):
    told = []
    monkeypatch.setattr(wire, "on_callback_error", told.append)

    def broken():
        if not told:
            raise ZeroDivisionError("broken")

    heard = wire.Subscription(client, "r/broken/x", wake=broken)
    until(lambda: router.put("r/broken/x", b"1") or told)
    assert [type(err) for err in told] == [ZeroDivisionError]
    assert heard.take()
    heard.close()


def test_arrivals_are_counted_without_being_decoded(client, router):
    noted = probe.Arrivals(client, "r/flow/**", depth=3)
    stream = wire.Publisher(router, "r/flow/x", "x")
    until(lambda: stream.put({"n": 0}) and noted.count, what="the first arrival")
    before = noted.count
    for _ in range(5):
        stream.put({"n": 1})
    until(lambda: noted.count >= before + 5)
    taken = noted.take()
    assert len(taken) == 3
    assert {(one.key, one.size) for one in taken} == {("r/flow/x", 7)}
    assert [one.arrived_ns for one in taken] == sorted(one.arrived_ns for one in taken)
    noted.close()


def test_a_survey_hears_everybody_behind_a_wildcard(client, router):
    streams = [wire.Publisher(router, f"r{n}/@status", "executive") for n in range(2)]
    for n, stream in enumerate(streams):
        stream.put({"n": n})
    found = probe.survey(client, keys.ANY_STATUS, source="test")
    assert sorted(json.loads(one.payload)["n"] for one in found) == [0, 1]


def test_over_a_session_an_answer_that_is_none_counts_as_no_answer(client, served):
    asking = over_session.OverSession(client, "test", {"move": served.key})
    name = served.key.split("/")[1]
    for payload, expected in ((b'{"accepted": true}', True), (b"rubbish", None), (b'{"accepted": 3}', None)):
        asked = asking.ask("move", {"n": 1}, 5.0)
        assert asked.answers() is None
        (request,) = until(served.take)
        request.forward_reply(payload, b"")
        answer = until(asked.answers)[name]
        assert (answer.accepted if answer is not None else None) is expected


# -- who may what -----------------------------------------------------------------------------------------------------

RIGHTS = {
    "motors": Rights(put=("r/motors/state",), serve=("r/motors/go",), alive=("r/@alive/motors",)),
    "drive": Rights(hear=("r/motors/**",), ask=("r/motors/go",), put=("r/drive/**",), never_put=("r/drive/secret",)),
    "tools": Rights(trusted=True),
}


@pytest.fixture(scope="module")
def guarded(tmp_path_factory):
    place = f"unixsock-stream/{tmp_path_factory.mktemp('guarded')}/r.sock"
    users = {name: f"{name}-password" for name in RIGHTS}
    with session.open_router(session.Router(listen=(place,), robot="r", users=users, rights=RIGHTS)):
        yield place


def enter(place, name):
    return session.open_client([place], Credentials(user=name, password=f"{name}-password"))


@pytest.mark.parametrize(
    "proof", [None, Credentials(user="drive", password="guess"), Credentials(user="nobody", password="drive-password")]
)
def test_who_cannot_prove_a_name_does_not_come_in(guarded, proof):
    with pytest.raises(BusError, match="cannot reach a robot at unixsock-stream/"):
        session.open_client([guarded], proof, timeout_s=0.3)


def test_what_may_be_put_is_heard_and_all_else_is_dropped_where_it_comes_in(guarded):
    with enter(guarded, "tools") as tools, enter(guarded, "drive") as drive:
        heard = wire.Subscription(tools, "r/**", depth=64)
        until(lambda: wire.put(drive, "r/drive/state", 0, source="drive") or heard.take(), what="what is allowed")
        for key in ("r/motors/setpoint", "r/drive/secret", "r/@estop", "other/drive/state"):
            wire.put(drive, key, 1, source="drive", urgent=True)
        wire.put(drive, "r/drive/end", 2, source="drive", urgent=True)
        found = {}

        def ended():
            found.update({one.key: one.payload for one in heard.take()})
            return "r/drive/end" in found

        until(ended)
        assert set(found) <= {"r/drive/state", "r/drive/end"}


def test_who_may_not_serve_a_command_is_not_asked_and_who_may_not_ask_is_not_answered(guarded):
    with enter(guarded, "motors") as motors, enter(guarded, "drive") as drive:
        answers = wire.ComputedReply(motors, "r/motors/go", lambda: {"accepted": True})
        until(lambda: wire.ask(drive, "r/motors/go", {}, source="drive", timeout_s=0.5), what="what is wired")
        impostor = wire.ComputedReply(drive, "r/motors/go", lambda: {"accepted": False})
        with enter(guarded, "tools") as tools:
            for _ in range(5):
                (reply,) = wire.ask(tools, "r/motors/go", {}, source="tools", timeout_s=HANG_S)
                assert json.loads(reply.payload) == {"accepted": True}
        assert wire.ask(motors, "r/drive/go", {}, source="motors", timeout_s=0.2) == []
        assert answers
        assert impostor


def test_nobody_shows_the_presence_of_another(guarded):
    with enter(guarded, "tools") as tools, enter(guarded, "motors") as motors, enter(guarded, "drive") as drive:
        presence = wire.Presence(tools, "r")
        tokens = [wire.alive(drive, "r", "motors"), wire.alive(drive, "r", "drive")]
        tokens.append(wire.alive(motors, "r", "motors"))
        until(lambda: presence.names == {"motors"})
        tokens.pop().undeclare()
        until(lambda: not presence.names, what="the impostor's token counts for nothing")


def test_the_file_of_users_is_gone_once_it_was_read():
    with access.Dictionary({"ann": "one", "bob": "two"}) as dictionary:
        with open(dictionary.path) as file:  # noqa: PTH123 - a descriptor's name
            assert file.read() == "ann:one\nbob:two\n"
        path = dictionary.path
    with pytest.raises(OSError, match="No such file"):
        open(path).close()  # noqa: PTH123


def test_who_comes_and_goes_is_told_with_the_sessions_id(endpoint, router):
    woken = threading.Event()
    noted = links.Links(router, ("unixsock-stream",), woken.set)
    noted.take()
    with session.open_client([endpoint]) as other:
        name = str(other.zid())
        came = until(lambda: [one for one in noted.take() if one.session_id == name])
        assert [one.connected for one in came] == [True]
    went = until(lambda: [one for one in noted.take() if one.session_id == name])
    assert [one.connected for one in went] == [False]
    assert woken.is_set()


def test_links_of_other_kinds_are_not_noted(endpoint, router):
    noted = links.Links(router, ("tls",))
    with session.open_client([endpoint]):
        pass
    assert noted.take() == []


def test_an_endpoint_that_is_taken_or_not_there_is_named(endpoint, router, tmp_path):
    with pytest.raises(BusError, match=r"cannot listen on tcp/127\.0\.0\.1:1") as found:
        session.open_router(session.Router(listen=("tcp/127.0.0.1:1", "tcp/256.0.0.1:1")))
    assert " at /" not in str(found.value)
    with pytest.raises(BusError, match=f"cannot reach a robot at unixsock-stream/{tmp_path}"):
        session.open_client([f"unixsock-stream/{tmp_path}/none.sock"], timeout_s=0.2)
