"""Where a door may listen: an endpoint that the bus understands, in one piece."""

import msgspec
import pytest

from lbr.apps.lan.kind import LanSettings


@pytest.mark.parametrize("endpoint", ["tls/0.0.0.0:7447", "tls/[::]:80", "tcp/127.0.0.1:80", "tls/robot.local:65535"])
def test_an_endpoint_is_a_protocol_a_host_and_a_port(endpoint):
    assert msgspec.convert({"listen": [endpoint]}, LanSettings).listen == (endpoint,)


@pytest.mark.parametrize(
    "endpoint",
    ["tls/0.0.0.0:7447\n", "tls/0.0.0.0:7447\n\n", "tls/a b:1", "tls/a:1#x", "udp/a:1", "tls/a", "tls/a:123456"],
)
def test_what_a_line_break_or_more_follows_is_none(endpoint):
    with pytest.raises(msgspec.ValidationError, match="listen"):
        msgspec.convert({"listen": [endpoint]}, LanSettings)
