"""The unix socket that stands in for a bus or a camera."""

import select
import socket
from threading import Thread

import pytest

from lbr.drivers.i2c_socket import SocketBus
from lbr.errors import DeviceError
from lbr.simulation.socket_port import SocketPort
from tests.support.waiting import HANG_S


@pytest.fixture
def port(tmp_path):
    with SocketPort(f"unix:{tmp_path / 'ports' / 'imu'}") as made:
        yield made


def connect(port):
    client = socket.socket(socket.AF_UNIX)
    client.settimeout(HANG_S)
    client.connect(str(port.path))
    return client


def news(port):
    """What came, waited for as the world waits."""
    assert select.select([port], [], [], HANG_S)[0]
    return port.receive()


def test_clients_are_told_apart_and_answered_each(port):
    with connect(port) as one, connect(port) as two:
        ((first, _),) = news(port)
        ((second, _),) = news(port)
        one.send(b"one")
        assert news(port) == [(first, b"one")]
        two.send(b"two")
        assert news(port) == [(second, b"two")]
        assert port.send(second, b"2") == 1
        assert two.recv(9) == b"2"


def test_who_leaves_is_forgotten(port):
    with connect(port):
        ((client, _),) = news(port)
        assert port.clients == (client,)
    assert news(port) == [(client, b"")]
    assert port.clients == ()
    assert port.send(client, b"x") == 0


def test_more_than_a_few_are_turned_away(port):
    clients = []
    for _ in range(9):
        clients.append(connect(port))
        news(port)
    assert len(port.clients) == 8
    assert clients[-1].recv(1) == b""
    for client in clients:
        client.close()


def test_who_reads_nothing_never_blocks_the_device(port):
    with connect(port):
        ((client, _),) = news(port)
        while port.send(client, b"x" * 100_000) == 100_000:
            pass
        assert port.send(client, b"x" * 1_000_000) < 1_000_000


def test_a_connection_can_be_handed_over(port):
    with connect(port) as one:
        ((client, _),) = news(port)
        taken = port.hand_over(client)
        assert port.clients == ()
        with taken:
            taken.sendall(b"mine now")
        assert one.recv(20) == b"mine now"


def test_unplugging_ends_clients_and_the_name_and_plugging_brings_it_back(port):
    with connect(port) as one:
        news(port)
        port.unplug()
        assert one.recv(1) == b""
    assert not port.path.exists()
    assert port.receive() == []
    with pytest.raises(DeviceError, match="unplugged"):
        port.fileno()
    port.plug()
    with connect(port):
        assert len(news(port)) == 1


def test_what_a_dead_world_left_is_replaced(port):
    stale = socket.socket(socket.AF_UNIX)
    path = port.path.with_name("left")
    stale.bind(str(path))
    stale.close()
    with SocketPort(path) as again, connect(again):
        assert len(news(again)) == 1


def test_anothers_socket_is_left_alone(port):
    port.path.unlink()
    other = SocketPort(port.path)
    other.plug()
    port.unplug()
    assert port.path.is_socket()
    other.unplug()


def test_a_path_of_any_length_is_listened_at_and_found(tmp_path):
    folder = tmp_path.joinpath(*["a_home_far_down"] * 10)
    with SocketPort(folder / "imu") as port:
        client = Thread(target=lambda: SocketBus(str(port.path)).close())
        client.start()
        assert news(port)
        client.join()
    assert not port.path.exists()
