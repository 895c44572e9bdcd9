import re
import socket

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.apps.http import names

OWN = socket.gethostname().partition(".")[0].lower()
LOOPBACK = [
    "localhost", "localhost:50000", "LocalHost", "127.0.0.1", "127.0.0.1:50000", "127.8.9.1:1", "[::1]", "[::1]:50000",
    "[0:0::1]:1",
]  # fmt: skip
NETWORK = [
    "192.168.1.7",
    "192.168.1.7:50000",
    "[fd00::7]:1",
    "[fe80::1%eth0]:1",
    OWN.upper(),
    f"{OWN}.local:1",
    names.announced(),
]
NEVER = [
    "", ":", ":50000", "::", "::1", "evil.example", f"{OWN}.evil.example", "127.0.0.1.evil.example", "localhost.evil.example",
    "0.0.0.0", "0.0.0.0:50000", "0.0.0.1", "0", "0x0", "00.0.0.0", "0.0", "[::]", "[::]:50000", "[::0]", "[0:0:0:0:0:0:0:0]",
    "[::ffff:0.0.0.0]", "[::ffff:0:0]", "[::ffff:127.0.0.1]", "[::ffff:192.168.1.7]", "[0::0%lo]", "[::1%lo]", "[::1%25lo]",
    "127.1", "2130706433", "0x7f000001", "0177.0.0.1", "127.0.0.1.", "localhost.", f"{OWN}.", "user@localhost",
    "localhost@evil.example", "user:secret@127.0.0.1", "localhost:50000:1", "localhost:", "localhost:x", "localhost:123456",
    "localhost, evil.example", "evil.example, localhost", " localhost", "localhost ", "http://localhost", "localhost/x",
    "[127.0.0.1]", "[localhost]", "[::1", "::1]", "[]", "loc\u0430lhost", "localhost\0", "local host", "xn--localhost",
]  # fmt: skip


@pytest.mark.parametrize("host", LOOPBACK)
def test_the_loopback_is_asked_by_its_names_from_anywhere(host):
    assert names.is_ours(host, loopback=True)
    assert names.means_loopback(host)


@pytest.mark.parametrize("host", NETWORK)
def test_other_machines_ask_by_address_or_name_and_this_machine_does_not(host):
    assert names.is_ours(host)
    assert not names.is_ours(host, loopback=True)
    assert not names.means_loopback(host)


@pytest.mark.parametrize("host", NEVER)
@pytest.mark.parametrize("loopback", [True, False])
def test_what_is_no_name_of_this_machines_is_none_in_any_spelling(host, loopback):
    assert not names.is_ours(host, loopback=loopback)


def test_a_machine_is_announced_by_one_name_that_tells_it_from_others():
    assert re.fullmatch(r"lbr-[0-9a-f]{4}\.local", names.announced())
    assert names.announced() == names.announced()


def test_names_of_the_row_count_everywhere():
    named = frozenset({"robot.example.org"})
    assert names.is_ours("Robot.Example.org:9146", named)
    assert names.is_ours("robot.example.org", named, loopback=True)
    assert not names.is_ours("robot.example.org.", named)


@given(st.text(max_size=40), st.booleans())
def test_any_text_is_a_name_of_ours_or_not(host, loopback):
    if names.is_ours(host, loopback=loopback):
        assert names.parsed(host) is not None
        assert not host.lower().startswith("0.0.0.0")


@pytest.mark.parametrize(
    ("address", "who"),
    [
        ("127.0.0.1", "this machine"),
        ("127.0.0.9", "this machine"),
        ("::1", "this machine"),
        ("::ffff:192.168.1.7", "192.168.1.7"),
        ("fe80::1%eth0", "fe80::1"),
        ("", ""),
    ],
)
def test_all_addresses_of_the_loopback_are_one_asker(address, who):
    assert names.peer_name(address) == who
