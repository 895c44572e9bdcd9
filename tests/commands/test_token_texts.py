"""What `lbr token` makes of times and addresses: an end that is a date, and endpoints that others can type."""

import datetime as dt
import re
import socket
from types import SimpleNamespace

import psutil
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr import cli
from lbr.commands import token
from lbr.errors import InputError
from tests.support import databases

NOW = dt.datetime(2026, 1, 1, tzinfo=dt.UTC)
SECONDS = {"m": 60, "h": 3600, "d": 86400, "w": 604800}


@given(st.integers(1, 999_999), st.sampled_from("mhdw"))
def test_an_end_is_that_long_from_now_or_refused_in_a_sentence(number, unit):
    before = dt.datetime.now(dt.UTC)
    wanted = dt.timedelta(seconds=number * SECONDS[unit])
    if wanted > dt.datetime.max.replace(tzinfo=dt.UTC) - before:
        with pytest.raises(InputError, match=f"'{number}{unit}' from now"):
            token.end_in(f"{number}{unit}")
        return
    ends = token.end_in(f"{number}{unit}")
    assert abs(ends - before - wanted) < dt.timedelta(seconds=5)


@given(st.text(max_size=9))
def test_what_is_no_time_is_refused_with_how_to_write_one(text):
    if re.fullmatch(r"[1-9][0-9]{0,5}[mhdw]", text):
        return
    with pytest.raises(InputError, match="90m, 12h, 30d or 8w"):
        token.end_in(text)


@pytest.mark.parametrize("text", ["0d", "-1d", "1.5h", "12", "d", "1 d", "1d\n", "1000000m", "\u0661d", "1D"])
def test_a_time_that_is_not_quite_one_is_refused(text):
    with pytest.raises(InputError, match="is not a time from now"):
        token.end_in(text)


@pytest.fixture
def cards(monkeypatch):
    """The addresses of this machine's cards."""

    def have(*addresses: str) -> None:
        cards = {str(n): [SimpleNamespace(family=socket.AF_INET, address=one)] for n, one in enumerate(addresses)}
        cards["six"] = [SimpleNamespace(family=socket.AF_INET6, address="fe80::1")]
        monkeypatch.setattr(psutil, "net_if_addrs", lambda: cards)

    return have


def test_who_listens_everywhere_is_found_at_each_address(cards):
    cards("127.0.0.1", "192.168.1.7", "10.0.0.2")
    for everywhere in ("0.0.0.0", "[::]"):
        assert token.endpoints_of((f"tls/{everywhere}:7447",)) == ["tls/192.168.1.7:7447", "tls/10.0.0.2:7447"]
    assert token.endpoints_of(()) == ["tls/192.168.1.7:7447", "tls/10.0.0.2:7447"]
    cards("127.0.0.1")
    assert token.endpoints_of(("tls/0.0.0.0:1",)) == ["tls/127.0.0.1:1"]


def test_who_listens_at_one_address_is_found_there(cards):
    cards("192.168.1.7")
    listened = ("tls/robot.local:7447", "tcp/[fe80::2]:80")
    assert token.endpoints_of(listened) == list(listened)


def test_a_token_is_valid_until_it_ends_or_is_taken_away():
    def row(**fields: object):
        return SimpleNamespace(
            **{"revoked_at": None, "expires_at": None, "has_expired": lambda _now: False} | fields,
        )

    assert (token.state_of(row()), token.until_of(row())) == ("valid", "")
    ended = row(expires_at="2026-01-01", has_expired=lambda _now: True)
    assert (token.state_of(ended), token.until_of(ended)) == ("expired", ", until 2026-01-01")
    gone = row(revoked_at="2026-02-02", expires_at="2026-01-01", has_expired=lambda _now: True)
    assert (token.state_of(gone), token.until_of(gone)) == ("revoked", ", until 2026-02-02")


@pytest.fixture
def lbr(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("LBR_HOME", str(tmp_path))
    databases.fresh(tmp_path / "robot.db")

    def run(*words: str) -> tuple[int, str, str]:
        code = cli.main(["token", *words])
        return code, *capsys.readouterr()

    return run


@pytest.mark.parametrize("ends", ["999999w", "600000w"])
def test_an_end_beyond_all_dates_makes_no_token(lbr, ends):
    code, out, err = lbr("add", "ann", "--expires", ends)
    assert (code, out) == (2, "")
    assert ends in err
    assert lbr("list", "--json")[1] == "[]\n"


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (("--for", "web", "--role", "host"), "a host comes in by the bus"),
        (("--for", "web", "--file", "phone.json5"), "--file comes in by the bus"),
        (("--file", "{home}/robot.db"), "robot.db exists already; name another file"),
        (("--file", "{home}/none/phone.json5"), "none/phone.json5 cannot be written (No such file or directory)"),
    ],
)
def test_what_goes_together_in_no_token_is_refused_before_one_is_made(lbr, tmp_path, words, why):
    code, out, err = lbr("add", "ann", *(word.format(home=tmp_path) for word in words))
    assert (code, out) == (2, "")
    assert why in err
    assert lbr("list")[1] == ""
