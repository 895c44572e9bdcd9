import os
import socket
import struct
from pathlib import Path

import pytest

from lbr.apps.http import peers
from tests.support.waiting import until

HEAD = "  sl  local_address rem_address   st tx_queue rx_queue tr tm->when retrnsmt   uid  timeout inode\n"
ENDS = ("127.0.0.1", 40000), ("127.0.0.1", 50000)
OTHER = 1234


def table(path: Path, *rows: tuple[str, str, str, int, int]) -> Path:
    lines = (
        f"   {at}: {local} {remote} {state} 00000000:00000000 00:00000000 00000000 {uid:5d}        0 {inode} 1 0 20 4 30 10 -1\n"
        for at, (local, remote, state, uid, inode) in enumerate(rows)
    )
    path.write_text(HEAD + "".join(lines))
    return path


@pytest.mark.parametrize(
    ("row", "uid"),
    [
        (("0100007F:9C40", "0100007F:C350", "01", OTHER, 77), OTHER),
        (("0100007F:C350", "0100007F:9C40", "01", OTHER, 77), None),  # our own end
        (("0100007F:9C40", "0100007F:C350", "05", 0, 0), None),  # nobody holds it: the kernel says 0, which is root
        (("0100007F:9C40", "0100007F:C350", "01", 0, 0), None),
        (("0100007F:9C40", "0100007F:C350", "06", 0, 0), None),
        (("0100007F:9C41", "0100007F:C350", "01", OTHER, 77), None),
    ],
)
def test_the_user_of_the_other_end_is_who_holds_it_now(tmp_path, row, uid):
    assert peers.uid_of(*ENDS, [tmp_path / "none", table(tmp_path / "tcp", row)]) == uid


def test_an_ipv4_end_may_be_held_by_an_ipv6_socket(tmp_path):
    mapped = "0000000000000000FFFF00000100007F"
    rows = table(tmp_path / "tcp6", (f"{mapped}:9C40", f"{mapped}:C350", "01", OTHER, 7))
    assert peers.uid_of(("::ffff:127.0.0.1", 40000), ("::ffff:127.0.0.1", 50000), [rows]) == OTHER
    assert peers.uid_of(*ENDS, [rows]) == OTHER


@pytest.mark.parametrize(("family", "host"), [(socket.AF_INET, "127.0.0.1"), (socket.AF_INET6, "::1")])
def test_a_connection_of_our_own_is_its_owners_until_it_is_closed(family, host):
    try:
        server = socket.create_server((host, 0), family=family)
    except OSError:
        pytest.skip("no such loopback here")
    with server, socket.create_connection(server.getsockname()[:2]) as client:
        ends = client.getsockname()[:2], server.getsockname()[:2]
        until(lambda: peers.is_own(peers.whose(*ends)), what="a table that is read while it changes may lack a line")
        client.close()
        assert not peers.is_own(peers.whose(*ends))


def test_another_machine_is_nobodys_here_and_what_the_kernel_does_not_know_is_nothing(tmp_path):
    rows = table(tmp_path / "tcp", ("0100007F:9C40", "0100007F:C350", "01", OTHER, 77))
    assert peers.whose(*ENDS, [rows]) == f"user {OTHER}"
    assert peers.whose(("127.0.0.1", 40001), ENDS[1], [rows]) is None
    assert peers.whose(("::ffff:127.0.0.1", 40000), ENDS[1], [rows]) == f"user {OTHER}"
    assert peers.whose(("192.0.2.7", 40000), ENDS[1], [rows]) == ""
    assert peers.whose(("2001:db8::7", 40000), ENDS[1], [rows]) == ""
    assert peers.whose(("", 40000), ENDS[1], [rows]) is None
    unmapped = table(tmp_path / "other", ("0100007F:9C40", "0100007F:C350", "01", peers.NOBODY, 77))
    assert peers.whose(*ENDS, [unmapped]) is None


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can be somebody else")
def test_another_users_connection_is_not_the_owners():
    with socket.create_server(("127.0.0.1", 0)) as server:
        os.seteuid(OTHER)
        try:
            other = socket.create_connection(server.getsockname())
        finally:
            os.seteuid(0)
        with other:
            ends = other.getsockname(), server.getsockname()
            assert peers.uid_of(*ends) == OTHER
            assert not peers.is_own(peers.whose(*ends))


def test_a_connection_that_was_cut_is_told_from_the_next_one_with_its_ports():
    with socket.create_server(("127.0.0.1", 0)) as server:
        first = socket.create_connection(server.getsockname())
        ends = first.getsockname(), server.getsockname()
        accepted, _ = server.accept()
        with accepted:
            assert peers.is_held(accepted)
            first.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
            first.close()
            with socket.create_connection(ends[1], source_address=ends[0]):
                until(
                    lambda: peers.is_own(peers.whose(*ends)),
                    what="the kernel goes by the ports, which are another's now",
                )
                assert not peers.is_held(accepted)
