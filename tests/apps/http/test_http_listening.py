"""Who listens for this machine does so by IPv4 and IPv6: nobody else answers to `localhost` at the same port."""

import socket
from contextlib import ExitStack

import pytest

from lbr.apps.http import listening
from lbr.errors import InputError

pytestmark = pytest.mark.skipif(not listening.is_here("::1"), reason="no IPv6 here")


@pytest.mark.parametrize("host", ["127.0.0.1", "localhost", "0.0.0.0", "::1", "::"])
def test_nobody_else_can_listen_where_a_browser_looks_for_localhost(host):
    with ExitStack() as stack:
        found = [stack.enter_context(one) for one in listening.listen(host, 0)]
        port = found[0].getsockname()[1]
        for address in ("127.0.0.1", "::1"):
            with pytest.raises(InputError, match="Address already in use"):
                listening._listen(address, port)
            socket.create_connection((address, port), timeout=2.0).close()


def test_a_port_that_somebody_has_by_ipv6_is_taken():
    with socket.create_server(("::1", 0), family=socket.AF_INET6) as other:
        port = other.getsockname()[1]
        with pytest.raises(InputError, match=f"port {port} at ::1 cannot be used"):
            listening.listen("127.0.0.1", port)
        with socket.create_server(("127.0.0.1", port)):
            pass  # nothing was kept


@pytest.mark.parametrize("host", ["127.0.0.2", "::"])
def test_another_address_is_listened_at_alone(host):
    with ExitStack() as stack:
        found = [stack.enter_context(one) for one in listening.listen(host, 0)]
        assert [one.getsockname()[0] for one in found] == [host]
