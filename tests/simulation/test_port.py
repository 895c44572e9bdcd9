"""The pseudo-terminal that stands in for a device's tty, as pyserial sees it."""

import select

import pytest
import serial

from lbr.errors import DeviceError
from lbr.simulation.port import PtyPort
from tests.support.waiting import HANG_S, until


@pytest.fixture
def port(tmp_path):
    with PtyPort(tmp_path / "ports" / "motors") as made:
        yield made


def open_client(port):
    return serial.Serial(str(port.path), 115200, timeout=HANG_S, write_timeout=HANG_S, exclusive=True)


def heard(port, count):
    data = b""
    while len(data) < count and select.select([port], [], [], HANG_S)[0]:
        data += port.read()
    return data


def test_bytes_pass_unchanged_both_ways(port):
    every = bytes(range(256))
    with open_client(port) as client:
        client.write(every)
        assert heard(port, 256) == every
        port.write(every)
        assert client.read(256) == every


def test_pieces_of_many_bytes_survive(port):
    piece = bytes(range(250)) * 12
    with open_client(port) as client:
        assert port.write(piece) == len(piece)
        assert client.read(len(piece)) == piece
        client.write(piece)
        assert heard(port, len(piece)) == piece


def test_nothing_to_read_is_no_bytes(port):
    assert port.read() == b""


def test_clients_come_and_go(port):
    for word in (b"one", b"two"):
        with open_client(port) as client:
            client.write(word)
            assert heard(port, 3) == word
    assert port.read() == b""


def test_a_client_that_does_not_read_never_blocks_the_device(port):
    until(
        lambda: port.write(b"x" * 1000) == port.write(b"x") == 0, what="the tty is full: the kernel fills it bit by bit"
    )
    with open_client(port) as client:
        port.write(b"fresh")
        assert client.read(5) == b"fresh", "opening discards what came before"


def test_unplugging_ends_a_client_and_the_name(port):
    with open_client(port) as client:
        port.unplug()
        with pytest.raises(serial.SerialException):
            client.read(1)
    assert not port.path.is_symlink()
    assert not port.plugged
    with pytest.raises(serial.SerialException):
        open_client(port)


def test_an_unplugged_port_takes_and_gives_nothing(port):
    port.unplug()
    assert port.read() == b""
    assert port.write(b"x") == 0
    with pytest.raises(DeviceError, match="unplugged"):
        port.fileno()


def test_plugged_in_again_it_has_the_same_name(port):
    port.unplug()
    port.plug()
    with open_client(port) as client:
        port.write(b"back")
        assert client.read(4) == b"back"


def test_a_stale_link_is_replaced(tmp_path):
    (tmp_path / "motors").symlink_to("/dev/pts/nowhere")
    with PtyPort(tmp_path / "motors") as port, open_client(port) as client:
        port.write(b"ok")
        assert client.read(2) == b"ok"


def test_a_real_file_is_never_replaced(tmp_path):
    (tmp_path / "motors").write_text("precious")
    with pytest.raises(DeviceError, match="something else is there"):
        PtyPort(tmp_path / "motors").plug()
    assert (tmp_path / "motors").read_text() == "precious"


def test_anothers_link_is_left_alone(port):
    port.path.unlink()
    port.path.symlink_to("/dev/null")
    port.unplug()
    assert port.path.is_symlink()
