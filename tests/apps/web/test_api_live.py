"""The live socket: the newest of what a page wants, events, and a hand that is off the moment the page is."""

import contextlib
import json
import socket
import subprocess
import sys
import time
from contextlib import contextmanager
from itertools import count

import pytest
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

from lbr.apps.http import serving
from lbr.apps.web import viewing
from lbr.apps.web.api import holds
from lbr.apps.web.api.link_age import FULL_S, OLDEST_S
from lbr.apps.web.api.patience import SILENT_S
from lbr.apps.web.page import files
from lbr.messages.system import Event
from tests.apps.web.api_stage import STANDS, status
from tests.apps.web.test_api import USERS, api
from tests.apps.web.test_web_access import FINGERPRINT, SECRET
from tests.apps.web.web_stage import UPGRADE, ending
from tests.support import programs
from tests.support.waiting import HANG_S, until

FORWARD = {"to": "drive/command", "message": {"power": 0.3}, "n": 1}


@pytest.fixture(scope="module")
def module():
    with api(users=USERS) as served:
        yield served


@pytest.fixture
def served(module):
    lent = module.bus.lent
    until(lambda: not (module.web._api.holds._hands or module.connections), what="nobody of the test before")
    lent.refusal = lent.ended = None
    lent.holder = ""
    for happened in (lent.moves, lent.halts):
        happened.clear()
    return module


@pytest.fixture
def patient(served, monkeypatch):
    """The server and the base wait: a hand is off for another reason than that a busy machine held its page up."""
    monkeypatch.setattr(holds, "SILENT_S", HANG_S)
    monkeypatch.setattr(served.bus.lent, "TTL_S", HANG_S)


class Page:
    """A page's socket: what it says, and what it was told."""

    def __init__(self, socket) -> None:
        self.socket = socket
        self.t = None

    def say(self, **message) -> None:
        self.socket.send(json.dumps(message))

    def frame(self, within_s=HANG_S):
        told = json.loads(self.socket.recv(timeout=within_s))
        assert self.t is None or told["t"] >= self.t
        self.t = told["t"]
        return told

    def until(self, wanted, within_s=HANG_S):
        end = time.monotonic() + within_s
        while time.monotonic() < end:
            frame = self.frame(within_s)
            if found := wanted(frame):
                return found
        raise AssertionError(f"not told within {within_s} s")

    def hold(self, **wanted):
        return self.until(
            lambda frame: (hold := frame.get("hold")) and all(hold[k] == v for k, v in wanted.items()) and hold
        )


@contextmanager
def page(served, token="", **options):
    offered = ["lbr.live", f"bearer.{token}.{SECRET}.{FINGERPRINT}"] if token else ["lbr.live"]
    with connect(f"ws://127.0.0.1:{served.port}/api/live", subprotocols=offered, **options) as socket:
        assert socket.subprotocol == "lbr.live"
        yield Page(socket)


def test_a_page_gets_the_newest_of_what_it_wants_and_how_old_it_is(served):
    with page(served) as one:
        one.say(hear=["drive/state", "light/state"], rate_hz=50)
        until(lambda: f"{served.stage.robot}/light/state" in served.bus.feeds)
        for number in range(5):
            served.bus.say("drive/state", STANDS | {"power": number})
        found = one.until(
            lambda frame: (
                (told := frame.get("streams", {}).get("drive/state")) and told["message"]["power"] == 4 and told
            )
        )
        assert 0 <= found["age_ms"] < HANG_S * 1000
        served.bus.say("light/state", {"on": True})
        assert one.until(lambda frame: frame.get("streams"))["light/state"]["message"] == {"on": True}


def test_what_was_said_before_the_page_came_is_told_too():
    with api() as fresh:
        fresh.bus.answers[f"{fresh.stage.robot}/drive/state"] = lambda _said: STANDS
        with page(fresh) as one:
            one.say(hear=["drive/state"])
            assert one.until(lambda frame: frame.get("streams"))["drive/state"]["message"] == STANDS


@pytest.mark.parametrize(
    "key", ["drive/command", "drive/stop", "camera_front/frame", "nothing/state", "**", "@console", "@alive/drive"]
)
def test_commands_pictures_and_what_is_not_there_are_not_even_listened_to(served, key):
    with page(served) as one:
        before = set(served.bus.feeds)
        one.say(hear=[key, "drive/state"])
        until(lambda: f"{served.stage.robot}/drive/state" in served.bus.feeds)
        one.say(hear=[])
        assert not [found for found in set(served.bus.feeds) - before if not found.endswith("drive/state")]


def test_events_come_in_order_and_each_once(served):
    with page(served) as one:
        one.say(hear=["@event"], rate_hz=10)
        until(lambda: f"{served.stage.robot}/@event" in served.bus.feeds)
        one.frame()
        for number in range(10):
            served.bus.say("@event", Event(kind="test", subject="drive", text=str(number)))
        told = []
        while len(told) < 10:
            told += [event["text"] for event in one.frame().get("events", ())]
        assert told == [str(number) for number in range(10)]


def test_a_page_has_the_time_to_quote_also_when_nothing_happens(served):
    with page(served) as one:
        one.frame()

        def pause_ms():
            before, frame = one.t, one.frame()
            assert set(frame) == {"t"}
            return frame["t"] - before

        until(lambda: pause_ms() < OLDEST_S * 1000, what="a time that may be quoted")


def test_rows_that_change_under_an_open_page_are_heard_as_soon_as_they_are_there():
    with api() as served, page(served) as one:
        one.say(hear=["new/state"])
        one.frame()
        drive = served.bus.robot.capabilities[0]
        new = type(drive)(name="new", kind="x", family="app", summary="", outputs={"state": {}}, commands={})
        served.bus.robot = type(served.bus.robot)(
            robot=served.stage.robot, simulated=True, revision=8, capabilities=(new,)
        )
        served.bus.say("@status", status(8))
        until(lambda: f"{served.stage.robot}/new/state" in served.bus.feeds)
        served.bus.say("new/state", {"a": 1})
        assert one.until(lambda frame: frame.get("streams"))["new/state"]["message"] == {"a": 1}


def test_motion_is_held_in_the_name_of_its_page_while_it_says_so(served):
    with page(served, "ann") as one:
        numbers = count(1)

        def outlives_a_silence():
            """Hold it for longer than without a word; a hand that a busy machine held up begins again."""
            n, begun = next(numbers), time.monotonic()
            one.say(release=True)
            one.say(hold=FORWARD | {"n": n})
            while time.monotonic() - begun < 3 * SILENT_S:
                one.say(keep=n)
                one.frame()
            return served.bus.lent.moving

        until(outlives_a_silence, what="motion that goes on")
        assert {source for _, source, _ in served.bus.lent.moves} == {"web:ann"}
        one.say(release=True)
        until(lambda: not served.bus.lent.moving, what="its end")


def test_who_may_only_look_moves_nothing_and_may_stop(served):
    with page(served, "eve") as one:
        one.say(hold=FORWARD)
        told = one.hold(n=1, holds=False)
        assert told["code"] == "role"
        assert not served.bus.lent.moves
        assert served.ask("POST", "/stop").status == 200


def test_who_has_it_is_told_by_name(served, patient):
    with page(served, "ann") as one, page(served) as other:
        one.say(hold=FORWARD)
        one.hold(holds=True)
        one.say(keep=1)
        other.say(hold=FORWARD)
        told = other.hold(holds=False)
        assert (told["code"], told["holder"]) == ("held", "web:ann")


@pytest.mark.parametrize("how", ["closes", "is cut", "is silent", "says rubbish", "is late", "wants what is not held"])
def test_the_hand_is_off_the_moment_the_page_is(served, request, how):
    if how != "is silent":
        request.getfixturevalue("patient")
    with page(served, "ann") as one:
        one.say(hold=FORWARD)
        one.hold(holds=True)
        if how == "closes":
            one.socket.close()
        elif how == "is cut":
            one.socket.socket.shutdown(socket.SHUT_RDWR)
        elif how == "says rubbish":
            one.socket.send('{"keep": NaN}')
        elif how == "is late":
            one.say(hold=FORWARD | {"n": 2}, t=one.t - 2000)
        elif how == "wants what is not held":
            one.say(hold={"to": "light/switch", "message": {}, "n": 2})
        until(lambda: served.bus.lent.halts, what="a stop")
    assert not served.bus.lent.moving


def test_a_page_that_is_killed_is_off_at_once(served, patient):
    script = (
        "import json, sys, time\n"
        "from websockets.sync.client import connect\n"
        f"with connect('ws://127.0.0.1:{served.port}/api/live') as socket:\n"
        f"    socket.send(json.dumps({{'hold': {FORWARD!r}}}))\n"
        "    while True:\n"
        "        print(socket.recv(), flush=True)\n"
        "        socket.send('{\"keep\": 1}')\n"
    )
    client = programs.start([sys.executable, "-c", script], stdout=subprocess.PIPE)
    try:
        until(lambda: served.bus.lent.moving)
    finally:
        client.kill()
        client.communicate()
    until(lambda: served.bus.lent.halts, what="a stop")


@pytest.mark.parametrize(
    ("age_ms", "held"), [(0, True), (400, True), (600, False), (60_000, False), (-60_000, False), (1e300, False)]
)
def test_what_a_network_held_back_begins_nothing(served, age_ms, held):
    with page(served) as one:
        numbers = count(1)

        def answer():
            n = next(numbers)
            one.say(hold=FORWARD | {"n": n}, t=one.frame()["t"] - age_ms)
            return one.hold(n=n)

        # On a busy machine what is in time may be late as well.
        told = until(lambda: (found := answer())["holds"] >= held and found, what="an answer")
        assert (told["holds"], told["code"]) == (held, "" if held else "late")


@pytest.mark.parametrize(("age_ms", "slowed"), [(0, False), (300, True)])
def test_a_hand_whose_words_are_old_is_slowed_and_told_how_old_they_are(served, age_ms, slowed):
    said, links = iter(range(1, 10_000)), []

    def slows(frame):
        """Return whether the base moves at the speed that is due, and the page has the report, a frame later."""
        one.say(hold=FORWARD | {"n": next(said)}, t=frame["t"] - age_ms)
        links.extend([frame["link"]] if "link" in frame else [])
        moves = [move["power"] for _, _, move in served.bus.lent.moves if "power" in move]
        if not (links and moves):
            return False
        reported = (links[-1]["speed"] < 1, links[-1]["age_ms"] > FULL_S * 1000)
        return (moves[-1] < FORWARD["message"]["power"], *reported) == (slowed, slowed, slowed)

    with page(served) as one:
        one.until(slows)


def test_rubbish_is_told_and_the_socket_goes_on(served):
    with page(served) as one:
        for said in (
            "",
            "{",
            "NaN",
            "[]",
            '{"keep": NaN}',
            "[" * 6_000,
            '{"hold": 1}',
            b"\xff\x00",
            '{"rate_hz": 1e999}',
        ):
            one.socket.send(said)
            told = one.until(lambda frame: frame.get("error"))
            assert told["code"] == "malformed"
            assert told["reason"]
        one.say(hold=FORWARD)
        one.hold(holds=True)


def test_a_page_that_floods_is_closed_and_moves_nothing(served):
    with page(served) as one:
        one.say(hold=FORWARD)
        with contextlib.suppress(ConnectionClosed):
            for _ in range(600):
                one.say(keep=1)
        assert ending(one.socket)[0] == viewing.TALKS
    until(lambda: not served.bus.lent.moving)


def test_a_page_that_says_too_much_at_once_is_closed(served):
    with page(served) as one:
        with contextlib.suppress(ConnectionClosed):
            for _ in range(10):
                one.say(hear=[], padding="x" * 12_000)
        assert ending(one.socket)[0] is None  # it is cut


def test_a_message_that_is_too_large_closes_its_socket(served):
    with page(served) as one:
        one.socket.send("x" * 20_000)
        assert ending(one.socket)[0] == 1009


def test_who_reads_nothing_loses_its_hand_all_the_same_and_is_cut(served, monkeypatch):
    monkeypatch.setattr(viewing, "STALLED_S", 0.5)
    with connect(f"ws://127.0.0.1:{served.port}/api/live", max_queue=1, close_timeout=0.1) as slow:
        slow.send(json.dumps({"hear": ["light/state"], "rate_hz": 50}))
        slow.send(json.dumps({"hold": FORWARD}))
        until(lambda: served.bus.lent.moves, what="it moves")

        def filled() -> bool:
            served.bus.say("light/state", {"x": "y" * 200_000})
            return served.connections == 0

        until(filled, what="the socket of who reads nothing is cut")
        until(lambda: served.bus.lent.halts, what="a stop")
        assert not served.bus.lent.moving
        assert served.ask("GET", "/state").status == 200


def test_sockets_of_both_kinds_are_counted_together(served):
    with contextlib.ExitStack() as open_:
        for number in range(viewing.MOST_OF_ONE):
            path = "/api/live" if number % 2 else "/ws"
            open_.enter_context(connect(f"ws://127.0.0.1:{served.port}{path}"))
        for path in ("/api/live", "/ws"):
            with pytest.raises(InvalidStatus) as refused:
                open_.enter_context(connect(f"ws://127.0.0.1:{served.port}{path}"))
            assert refused.value.response.status_code == 503


def test_the_end_of_the_server_lets_go_and_says_so():
    with contextlib.ExitStack() as ends_later:
        with api() as served:
            one = ends_later.enter_context(connect(f"ws://127.0.0.1:{served.port}/api/live"))
            one.send(json.dumps({"hold": FORWARD}))
            until(lambda: served.bus.lent.moves)
        assert served.bus.lent.halts
        assert served.bus.closed
        assert ending(one)[0] in {None, 1001}


def test_a_page_hears_first_which_page_the_robot_has():
    with api(users=USERS, faces=("page",)) as served, page(served) as one:
        one.say(hear=["@status"])
        assert one.frame()["page"] == files.build()


def test_a_page_that_reads_and_answers_no_ping_is_cut_and_nothing_crashes(monkeypatch, capfd):
    monkeypatch.setattr(serving, "PING_S", 0.05)
    monkeypatch.setattr(serving, "PONG_S", 0.05)
    with api(users=USERS) as served, socket.create_connection(("127.0.0.1", served.port), timeout=HANG_S) as sleeping:
        sleeping.sendall(UPGRADE % b"/api/live" + b"Sec-WebSocket-Protocol: lbr.live\r\n\r\n")
        assert sleeping.recv(65536).startswith(b"HTTP/1.1 101")
        until(lambda: not served.connections, what="its place is free")
        assert served.ask("GET", "/state").status == 200
    assert capfd.readouterr().err == ""
