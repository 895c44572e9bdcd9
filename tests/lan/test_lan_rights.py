"""What each role can do at the door with nothing but Zenoh, and what nobody can."""

import json
from functools import partial

import pytest
import zenoh

from lbr.bus import access, keys, session, wire
from lbr.errors import BusError
from tests.support.door import COMMAND, TURN, Door, answer, told
from tests.support.waiting import STOPS_S, until


def settle(door: Door) -> None:
    """Whatever was sent before has been decided once this is answered."""
    with door.client("phone") as bus:
        told(bus, "lbr/drive/stop", {})


@pytest.fixture(autouse=True)
def at_rest(door: Door):
    yield
    door.rest()
    found = door.robot.status()["estop"]
    assert not found["engaged"], found


def test_a_motion_from_afar_begins_when_its_lease_is_quoted_and_lapses(door: Door):
    with door.client("phone") as bus:
        until(lambda: (answer(bus, COMMAND, TURN) or {"accepted": False})["accepted"], what="an offer")
        assert not door.moving()
        door.turn(bus)
        until(lambda: not door.moving(), limit_s=STOPS_S, what="it lapsed")


@pytest.mark.parametrize("message", [TURN, {**TURN, "take_over": True}, {"power": 0}])
def test_a_viewer_cannot_drive_by_query_or_put(door: Door, message):
    with door.client("eye") as bus:
        assert answer(bus, "lbr/drive/command", message) is None
        wire.put(bus, "lbr/drive/command", message, source="afar")
        for role in ("operate", "admin"):
            assert answer(bus, keys.console("lbr", role), None) is None
        assert answer(bus, "lbr/@estop/reset", {}) is None
        settle(door)
    assert not door.moving()


def test_who_looks_hears_what_the_robot_says_and_declares_nothing_else_to_it(door: Door):
    with door.client("eye") as bus:
        every, one, stray = (
            wire.Subscription(bus, f"lbr/{key}", depth=512) for key in ("**", "motors/setpoint", "x/y")
        )
        heard: set[str] = set()

        def hears(key: str) -> bool:
            door.robot.put("x/y", {"stray": True})
            door.robot.put("motors/setpoint", {})
            heard.update(raw.key for raw in every.take())
            return key in heard

        for key in ("lbr/motors/state", "lbr/drive/state", "lbr/ranges/readings"):
            until(partial(hears, key), what=key)
        until(one.take, what="setpoints, by their name")
        assert not stray.take()
        assert "lbr/x/y" not in heard


def test_a_viewer_can_stop_who_drives(door: Door):
    with door.client("eye") as bus:
        door.turn(door.robot.bus, "here")
        assert told(bus, "lbr/drive/stop", {})["accepted"]
    until(lambda: not door.moving(), limit_s=STOPS_S, what="it stopped")


def test_a_viewer_can_press_the_emergency_stop_and_not_reset_it(door: Door):
    with door.client("eye") as bus:
        pressed = json.dumps({"engaged": True, "reason": "a ladder"})
        until(lambda: bus.put("lbr/@estop", pressed) or door.robot.status()["estop"]["engaged"], what="it latched")
        assert answer(bus, "lbr/@estop/reset", {}) is None
    assert door.robot.status()["estop"]["engaged"]
    with door.client("phone") as bus:
        until(lambda: told(bus, "lbr/@estop/reset", {})["accepted"], what="acknowledged and released")


def test_the_status_knows_of_a_stop_and_of_its_reset_once_they_are_answered(door: Door):
    for _ in range(12):
        door.robot.press()
        assert door.robot.status()["estop"]["engaged"]
        until(lambda: door.robot.line("reset")["code"] == 0, what="acknowledged and released")
        assert not door.robot.status()["estop"]["engaged"]


def test_only_an_administrator_has_what_changes_the_machine(door: Door):
    message = {"path": str(door.away / "map.png")}
    for name, allowed in (("eye", False), ("phone", False), ("boss", True)):
        with door.client(name) as bus:
            for key, asked in (("lbr/world/picture", message), ("lbr/@console/admin", None)):
                found = told(bus, key, asked) if allowed else answer(bus, key, asked)
                assert (found is not None) == allowed


@pytest.mark.parametrize("name", ["eye", "phone", "boss"])
def test_nobody_can_write_what_a_capability_says(door: Door, name):
    here = {key: wire.Subscription(door.robot.bus, f"lbr/{key}", depth=512) for key in ("**", "@event", "@status")}
    with door.client(name) as bus:
        for key in ("motors/setpoint", "motors/state", "ranges/readings", "drive/state", "drive/result", "lan/x"):
            wire.put(bus, f"lbr/{key}", {"left": 1.0, "right": 1.0, "forged": True}, source="motors")
        for key in ("@event", "@status", "@estop/release/motors", "@estop/ack/motors", "@alive/motors", "@schema/a/b"):
            bus.put(f"lbr/{key}", '{"forged": true}')
        assert answer(bus, "lbr/@estop/release/motors", {"engaged": False}) is None
        settle(door)
    heard = [raw for feed in here.values() for raw in feed.take()]
    assert heard
    assert not [raw for raw in heard if b"forged" in raw.payload]
    assert not door.moving()


@pytest.mark.parametrize("name", ["phone", "boss"])
def test_nobody_can_pretend_to_be_a_capability(door: Door, name):
    came = wire.Presence(door.robot.bus, "lbr")
    until(lambda: "motors" in came.names, what="those who are there")
    asked: list[str] = []
    with door.client(name) as bus:
        token = bus.liveliness().declare_token("lbr/@alive/ghost")
        for key in ("drive/command", "drive/stop", "@console", "@status", "@estop/reset", "motors/state"):
            bus.declare_queryable(f"lbr/{key}", lambda query: asked.append(str(query.key_expr)), complete=True)
        settle(door)
        assert door.robot.ask("drive/stop", {})["accepted"]
        assert door.robot.line("s")["code"] == 0
        assert door.robot.status()["robot"] == "lbr"
        with door.client("eye") as other:
            assert told(other, "lbr/drive/stop", {})["accepted"]
            assert told(other, "lbr/@status")["robot"] == "lbr"
        token.undeclare()
    assert "ghost" not in came.names
    assert not asked
    came.close()


def test_what_others_here_send_is_not_sent_again(door: Door):
    heard = wire.Subscription(door.robot.bus, "lbr/drive/command", depth=64)
    door.robot.put("drive/command", {"power": 0})
    settle(door)
    assert len(heard.take()) == 1
    heard.close()


@pytest.mark.parametrize("name", ["eye", "boss"])
def test_what_one_token_commands_no_other_hears(door: Door, name):
    """A lease is good for each client that quotes it."""
    with door.client("phone") as bus, door.client(name) as other:
        feeds = [wire.Subscription(other, f"lbr/{key}", depth=512) for key in ("**", "drive/command", "*/command")]
        open_to_all = [wire.Subscription(other, f"lbr/{key}", depth=512) for key in ("drive/state", "motors/setpoint")]
        lease = door.turn(bus)
        wire.put(bus, COMMAND, {**TURN, "lease": lease}, source="afar")
        for feed in open_to_all:
            until(feed.take, what="what may be heard is heard")
        settle(door)
        raws = [raw for feed in feeds for raw in feed.take()]
        heard = [raw.key for raw in raws]
    assert {"lbr/drive/state", "lbr/motors/setpoint"} <= set(heard)
    assert "lbr/drive/command" not in heard
    assert not [raw.key for raw in raws if lease.encode() in raw.payload]


def test_the_insides_of_the_routers_are_closed(door: Door):
    with door.client("boss") as bus:
        assert not list(bus.get("@/**", timeout=0.5, allowed_destination=zenoh.Locality.REMOTE))
        assert not list(bus.get("lbr/@alive/**", timeout=0.5))


@pytest.mark.parametrize("mode", ["peer", "router"])
@pytest.mark.parametrize("name", ["", "eye"])
def test_a_peer_or_router_gets_no_more_than_a_client(door: Door, mode, name):
    settings = door.settings(door.tokens["eye"])
    settings["mode"] = mode
    settings["scouting"] = {"multicast": {"enabled": False}, "gossip": {"enabled": True}}
    settings["listen"] = {"endpoints": []}
    settings["connect"] |= {"exit_on_failure": False, "timeout_ms": 0}
    if not name:
        del settings["transport"]["auth"]
    with zenoh.open(zenoh.Config.from_json5(json.dumps(settings))) as bus:
        until(lambda: not name or answer(bus, "lbr/@status") is not None, what="whoever has a token sees")
        assert answer(bus, "lbr/drive/command", TURN, timeout_s=0.3) is None
        wire.put(bus, "lbr/motors/setpoint", {"left": 1.0, "right": 1.0}, source="drive")
        if not name:
            assert answer(bus, "lbr/@status", timeout_s=0.3) is None
        settle(door)
    assert not door.moving()


def test_without_the_right_password_nobody_is_let_in(door: Door):
    for credentials in (
        None,
        access.Credentials(user="phone", password="x"),
        access.Credentials(user="@relay", password=""),
    ):
        with pytest.raises(BusError, match="Unable to connect"):
            session.open_client([door.endpoint], credentials, certificate=door.certificate, timeout_s=0.0)


def test_what_is_too_large_or_too_much_is_refused_aloud_and_delays_no_stop(door: Door):
    with door.client("phone") as bus, door.client("eye") as other:
        assert not told(bus, COMMAND, {**TURN, "lease": "x" * 60_000})["accepted"]
        assert answer(bus, COMMAND, {**TURN, "lease": "x" * 100_000}, timeout_s=0.3) is None

        def flooded():
            """A link that a busy machine loses takes its answers along."""
            asked = [
                wire.PendingQuery(bus, COMMAND, b'{"power": 0}', timeout_s=2.0, source="flood") for _ in range(300)
            ]
            assert told(other, "lbr/drive/stop", {})["accepted"]
            until(lambda: all(question.done for question in asked))
            return asked if all(question.replies for question in asked) else None

        answers = [json.loads(question.replies[0].payload) for question in until(flooded, what="each is answered")]
    assert any("from other machines" in one.get("reason", "") for one in answers)


def test_a_name_from_afar_is_never_that_of_somebody_here(door: Door):
    with door.client("phone") as bus:

        def refused():
            door.turn(door.robot.bus, "console")
            found = bus.get("lbr/@console", payload="/r/0.3/0", timeout=2.0, attachment=stamp("console"))
            results = [json.loads(reply.ok.payload.to_bytes()) for reply in found]
            return any(result["code"] == 1 and "held by console" in result["text"] for result in results)

        until(refused, what="it is held by the console")


def stamp(source: str) -> str:
    return json.dumps({"source": source, "seq": 1, "mono_ns": 0, "wall_ns": 0})
