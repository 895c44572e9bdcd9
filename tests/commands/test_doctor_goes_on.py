"""`lbr doctor` on rows and machines that are as wrong as can be: each check is a finding, and none ends the others."""

import json
import sqlite3
from contextlib import closing, nullcontext
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr import cli, home
from lbr.apps.http import listening
from lbr.apps.web.commands import checks as web_checks
from lbr.bus import keys, session, wire
from lbr.commands import checks
from lbr.commands.finding import Finding
from lbr.database.rows import CapabilityRow
from lbr.errors import BusError
from lbr.messages.motors import MotorsState
from tests.support import databases


def looked_at(settings: str) -> list[Finding]:
    row = CapabilityRow(name="web", kind="web", settings=settings)
    return list(web_checks.ports("lbr", [row]))


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"port": "abc"}, "port"),
        ({"port": None}, "port"),
        ({"port": 70000}, "port"),
        ({"port": -1}, "port"),
        ({"port": 1 << 70}, "port"),
        ({"host": 5, "port": 0}, "host"),
        ({"host": "", "port": 0}, ""),
        ({"host": "no such host", "port": 0}, "no such host"),
        ({"host": "a" * 300, "port": 0}, "aaa"),
        ({"host": "a..b", "port": 0}, "a..b"),
        ({"host": "a\x00b", "port": 0}, "a"),
    ],
)
def test_an_address_that_cannot_be_listened_at_is_a_finding(settings, said, monkeypatch):
    monkeypatch.setattr(home, "running", tuple)
    (found,) = looked_at(json.dumps(settings))
    assert said in found.text
    assert "Unknown error" not in found.text
    assert found.about == "port of 'web'"


@given(
    st.dictionaries(
        st.sampled_from(["host", "port"]),
        st.none() | st.booleans() | st.integers(-9, 9) | st.floats() | st.just([]) | st.just({}) | st.just("0x"),
    )
)
def test_whatever_stands_in_the_row_something_is_said_of_it(settings):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(home, "running", tuple)
        patch.setattr(listening, "listen", lambda _host, _port: [])
        assert len(looked_at(json.dumps(settings))) == 1


@pytest.mark.parametrize(
    "err", [BusError("no router"), OSError(5, "Input/output error"), ValueError("odd"), KeyError("x")]
)
def test_a_check_that_fails_itself_is_a_finding_and_the_next_goes_on(err, monkeypatch):
    def fails():
        yield Finding(about="first", level="good", text="so far")
        raise err

    def clock():
        yield Finding(about="clock", level="good", text="ticks")

    fails.__name__ = "_bus"
    for name in ("_packages", "_robots", "_extras", "_home", "_disk", "_database", "_serial", "_governor", "_running"):
        monkeypatch.setattr(checks, name, lambda: iter(()))
    monkeypatch.setattr(checks, "_bus", fails)
    monkeypatch.setattr(checks, "_clock", clock)
    monkeypatch.setattr(checks.service_checks, "services", lambda: iter(()))
    monkeypatch.setattr(checks.power_checks, "power", lambda: iter(()))
    found = {one.about: one for one in checks.examine()}
    assert (found["bus"].level, found["clock"].level) == ("bad", "good")
    assert str(err) in found["bus"].text


def test_rows_that_are_bad_are_counted_with_the_first_and_what_to_type(tmp_path, monkeypatch):
    monkeypatch.setenv("LBR_HOME", str(tmp_path))
    databases.fresh(tmp_path / "robot.db")
    with closing(sqlite3.connect(tmp_path / "robot.db", isolation_level=None)) as client:
        client.execute("UPDATE capability SET restart = 'never', settings = '{\"port\": 70000}' WHERE kind = 'web'")
        client.execute("UPDATE capability SET enabled = 1 WHERE kind = 'web'")
        client.execute("UPDATE capability SET needs = '[\"nothing\"]' WHERE robot = 'lbr' AND name = 'drive'")
    found = list(checks._database())
    bad = {one.about: one for one in found if one.level == "bad"}
    assert {about: one.do for about, one in bad.items()} == dict.fromkeys(
        ("port of 'web'", "port of 'web_api'", "database"), "lbr db check"
    )
    assert "has 1 bad rows; the first: capability 'lbr/drive'" in bad["database"].text
    assert "`$.port`" in bad["port of 'web'"].text


def test_a_package_that_is_missing_is_named(monkeypatch):
    needs = ["click>=8.1", "no-such-thing[extra]>=2,<3", "other ~= 1", "left-out; extra == 'sim'"]
    monkeypatch.setattr(checks.metadata, "requires", lambda _name: needs)
    (found,) = checks._packages()
    assert (found.level, found.text) == ("bad", "missing: no-such-thing, other")


@pytest.mark.parametrize(("governor", "level"), [("powersave\n", "hint"), ("performance\n", "good"), ("", "good")])
def test_a_governor_that_saves_power_is_a_hint(governor, level, monkeypatch):
    class Place:
        def __init__(self, _path):
            pass

        def exists(self):
            return True

        def read_text(self):
            return governor

    monkeypatch.setattr(checks, "Path", Place)
    (found,) = checks._governor()
    assert found.level == level


def test_the_doctors_findings_are_json_with_an_exit_code(monkeypatch, capsys):
    findings = [Finding(about="a", level="good", text="x"), Finding(about="b", level="bad", text="y", do="z")]
    monkeypatch.setattr(checks, "examine", lambda: iter(findings))
    assert cli.main(["doctor", "--json"]) != 0
    assert [one["about"] for one in json.loads(capsys.readouterr().out)] == ["a", "b"]
    monkeypatch.setattr(checks, "examine", lambda: iter(findings[:1]))
    assert cli.main(["doctor"]) == 0


@pytest.mark.parametrize(("heard", "told"), [(False, ["lbr/motors"]), (True, []), (None, [])])
def test_a_device_that_has_sent_nothing_is_named(tmp_path: Path, monkeypatch, heard, told):
    endpoint = f"unixsock-stream/{tmp_path}/r.sock"
    with session.open_router(session.Router(listen=(endpoint,))), session.open_client([endpoint]) as bus:
        state = wire.Publisher(bus, keys.port("lbr", "motors", "state"), "motors")
        state.put(MotorsState(left=0.0, right=0.0, armed=True, reason="", estop=False, heard=heard))
        monkeypatch.setattr(checks.target, "find", lambda *_: None)
        monkeypatch.setattr(checks.target, "connected", lambda _: nullcontext(bus))
        assert [one.about for one in checks._unheard("lbr")] == told
