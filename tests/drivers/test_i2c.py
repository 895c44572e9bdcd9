import errno
import io
import os
from contextlib import closing

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.capability.context import Device
from lbr.drivers.i2c import UNANSWERED, locate, open_bus, unanswered
from lbr.drivers.i2c_bus import Read, Write, encode_transaction
from lbr.drivers.i2c_socket import SocketBus
from lbr.errors import DeviceError
from tests.drivers.i2c_peer import Server, device, read_request
from tests.support.waiting import HANG_S

addresses = st.integers(0, 127)
writes = st.builds(Write, addresses, st.binary(max_size=40))
reads = st.builds(Read, addresses, st.integers(0, 0xFFFF))


@pytest.fixture
def peer(tmp_path):
    server = Server(tmp_path / "bus", lambda messages: b"\0" + bytes(range(7, 7 + messages[-1][1])))
    yield server
    server.finish()


@pytest.fixture
def bus(peer, tmp_path):
    bus = SocketBus(str(tmp_path / "bus"), deadline_s=HANG_S)
    yield bus
    bus.close()


def row(address):
    return Device("imu", "mpu9150", address, {})


@pytest.mark.parametrize(
    ("address", "place"),
    [
        ("i2c:1:0x68", (1, "", 0x68)),
        ("i2c:22:0X0c", (22, "", 0x0C)),
        ("i2c:0:104", (0, "", 104)),
        ("unix:/run/bus", (-1, "/run/bus", 0x42)),
        ("unix:/run/bus:0x69", (-1, "/run/bus", 0x69)),
        ("unix:/run/a:b", (-1, "/run/a:b", 0x42)),
    ],
)
def test_an_address_says_which_bus_and_which_device(address, place):
    assert locate(row(address), 0x42) == place


@pytest.mark.parametrize("address", ["", "i2c:", "i2c:1", "i2c:1:", "i2c:one:0x68", "i2c:1:68h", "/dev/i2c-1", "unix:"])
def test_any_other_address_is_refused_with_what_is_allowed(address):
    with pytest.raises(
        DeviceError, match=r"device 'imu': address '.*' is not one of i2c:BUS:ADDRESS .*correct the device"
    ):
        locate(row(address), 0x68)


@pytest.mark.parametrize("address", ["i2c:1:0x07", "i2c:1:0x78", "unix:/run/bus:0x1000"])
def test_an_address_no_device_can_have_is_refused(address):
    with pytest.raises(DeviceError, match="i2c addresses are 0x08 to 0x77"):
        locate(row(address), 0x68)


def test_a_bus_that_is_not_there_says_what_to_do():
    with pytest.raises(DeviceError, match=r"'imu' at i2c:99:0x68: /dev/i2c-99 is missing; switch i2c on .*lbr doctor"):
        open_bus(row("i2c:99:0x68"), 0x68)


def test_a_socket_that_nobody_serves_or_that_is_no_path_is_told(tmp_path):
    for path in (tmp_path / "bus", tmp_path / ("x" * 200)):
        with pytest.raises(DeviceError, match=r"device 'imu': no process serves .* \(.+\); start what stands"):
            open_bus(device(path), 0x68)


def test_reads_and_writes_are_single_transactions(bus, peer):
    assert bus.read_byte_data(0x68, 0x75) == 7
    assert bus.read_word_data(0x68, 0x10) == 0x0807
    assert bus.read_i2c_block_data(0x68, 0x3B, 3) == [7, 8, 9]
    peer.answer = lambda _messages: b"\0"
    bus.write_byte_data(0x68, 0x6B, 0x80)
    bus.write_i2c_block_data(0x68, 0x19, [1, 2, 3])
    assert peer.log == [
        [(0x68, b"\x75"), (0x68, 1)],
        [(0x68, b"\x10"), (0x68, 2)],
        [(0x68, b"\x3b"), (0x68, 3)],
        [(0x68, b"\x6b\x80")],
        [(0x68, b"\x19\x01\x02\x03")],
    ]


@pytest.mark.parametrize("length", [0, 33])
def test_a_block_is_as_long_as_smbus_allows(bus, length):
    with pytest.raises(ValueError, match="1 to 32"):
        bus.read_i2c_block_data(0x68, 0, length)


def test_an_absent_device_has_the_errno_of_a_pi_and_the_bus_goes_on(bus, peer):
    usual, peer.answer = peer.answer, lambda _messages: b"\x79"
    with pytest.raises(OSError, match="Remote I/O") as err:
        bus.read_byte_data(0x50, 0)
    assert err.value.errno == errno.EREMOTEIO == 121
    peer.answer = usual
    assert bus.read_byte_data(0x68, 0) == 7


@pytest.mark.parametrize(
    "answer", [None, b"", b"\0", b"\0abc"], ids=["nothing", "no bytes", "no data", "half of the data"]
)
def test_a_peer_that_stalls_costs_its_deadline_and_the_next_call_connects_anew(peer, tmp_path, answer):
    usual, peer.answer = peer.answer, lambda _messages: answer
    with closing(SocketBus(str(tmp_path / "bus"), deadline_s=0.1)) as bus:
        with pytest.raises(OSError, match="timed out") as err:
            bus.read_i2c_block_data(0x68, 0x3B, 14)
        assert err.value.errno == errno.ETIMEDOUT
        peer.answer, bus._deadline_s = usual, HANG_S
        assert bus.read_byte_data(0x68, 0x75) == 7


@pytest.mark.parametrize("answer", [b"\0" + bytes(15), b"\0" + bytes(40), b"\x79\0", b"\x79" + bytes(20)])
def test_a_peer_out_of_step_is_left(bus, peer, answer):
    usual, peer.answer = peer.answer, lambda _messages: answer
    with pytest.raises(OSError, match="No such device"):
        bus.read_i2c_block_data(0x68, 0x3B, 14)
    peer.answer = usual
    assert bus.read_byte_data(0x68, 0x75) == 7


def test_a_peer_that_leaves_is_a_device_that_is_gone_until_it_is_back(tmp_path, monkeypatch):
    monkeypatch.setattr(SocketBus.__init__, "__defaults__", (None, HANG_S))
    for again in (False, True):
        server = Server(tmp_path / "bus", lambda _messages: b"\0\x07")
        if not again:
            bus, _ = open_bus(device(tmp_path / "bus"), 0x68)
        assert bus.read_byte_data(0x68, 0) == 7
        server.finish()
        (tmp_path / "bus").unlink()
        for _ in range(2):
            with pytest.raises(OSError, match="No such device") as err:
                bus.read_byte_data(0x68, 0)
            assert err.value.errno == errno.ENODEV
    bus.close()


@pytest.mark.parametrize("number", sorted(UNANSWERED))
def test_every_way_not_to_answer_reads_alike(number):
    told = str(unanswered(row("i2c:1:0x68"), 0x68, OSError(number, os.strerror(number))))
    assert told.startswith("device 'imu' at i2c:1:0x68: it does not answer at 0x68 (")
    assert "'i2cdetect -y 1'" in told


def test_another_error_is_told_as_it_is():
    told = str(unanswered(row("unix:/b"), 0x0C, OSError(errno.EBUSY, "busy"), "its compass"))
    assert "its compass at 0x0c cannot be used (Device or resource busy)" in told


@given(st.lists(writes | reads, min_size=1, max_size=12))
def test_what_is_encoded_is_what_the_other_end_reads(messages):
    stream = io.BytesIO(encode_transaction(messages))
    assert read_request(stream) == [tuple(message) for message in messages]
    assert stream.read() == b""


class Bus(SocketBus):
    def __init__(self, pieces):
        self._pieces = pieces
        super().__init__("")

    def _connect(self):
        return Canned(self._pieces)


class Canned:
    """A socket that answers with what it was given, in the pieces it was given."""

    def __init__(self, pieces):
        self._pieces = pieces

    def settimeout(self, _seconds):
        pass

    def sendall(self, _data):
        pass

    def recv(self, most):
        if not self._pieces:
            return b""
        piece = self._pieces.pop(0)
        if len(piece) > most:
            self._pieces.insert(0, piece[most:])
        return piece[:most]

    def close(self):
        pass


@given(st.lists(st.binary(min_size=1, max_size=6), max_size=6), st.integers(1, 14))
def test_whatever_is_answered_in_whatever_pieces_is_data_or_an_oserror(pieces, length):
    answer = b"".join(pieces)
    bus = Bus(list(pieces))
    failure, data = None, b""
    try:
        data = bytes(bus.read_i2c_block_data(0x68, 0, length))
    except OSError as err:
        failure = err
    if failure is None:
        assert b"\0" + data == answer[: length + 1]
    else:
        assert failure.errno
        assert answer[:1] != b"\0" or len(answer) != length + 1
