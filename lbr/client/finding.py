"""Finds robots: those of this machine, and those that report themselves to the network."""

import time
from collections.abc import Sequence
from ipaddress import IPv4Interface, IPv6Interface, ip_address, ip_interface
from typing import Any, NamedTuple

from lbr import home
from lbr.client.robot import Robot, connect

KIND = "_lbr._tcp.local."
"""The announcements of `lbr.apps.web.announce`."""


class Found(NamedTuple):
    """A robot: `host` is empty on this machine; `door` is its endpoint for programs elsewhere, `page` that for
    browsers."""

    robot: str
    host: str = ""
    door: str = ""
    page: str = ""

    def connect(self, **how: Any) -> Robot:
        """Connect to it, as `connect` does; raise BusError if it has no door to other machines."""
        return connect(self.robot, at=self.door or None, **how)


def find(*, within_s: float = 2.0) -> list[Found]:
    """Return the robots that run here and, where the package `zeroconf` is installed, those of the network.

    A robot announces itself in the network once its page is open to it (`web`), and its door if that has a row (`lan`).
    """
    local = [Found(one.robot) for one in home.running()]
    return local + _of_network(within_s)


def _of_network(within_s: float) -> list[Found]:
    try:
        from zeroconf import ServiceBrowser, Zeroconf
    except ImportError:
        return []
    services: set[str] = set()

    def hear(name: str, **_rest: object) -> None:
        services.add(name)

    try:
        network = Zeroconf()
    except OSError:  # there is no network
        return []
    try:
        ServiceBrowser(network, KIND, handlers=[hear])
        time.sleep(within_s)
        infos = [network.get_service_info(KIND, name, timeout=1000) for name in sorted(services)]
    finally:
        network.close()
    interfaces = _interfaces()
    return [_robot_of(info, interfaces) for info in infos if info is not None and info.parsed_addresses()]


def _interfaces() -> list[IPv4Interface | IPv6Interface]:
    import ifaddr

    every = [one for adapter in ifaddr.get_adapters() for one in adapter.ips]
    return [ip_interface(f"{one.ip if one.is_IPv4 else one.ip[0]}/{one.network_prefix}") for one in every]


def near(addresses: list[str], interfaces: Sequence[IPv4Interface | IPv6Interface]) -> str:
    """Return a reachable address of a machine: the first in a network of ours, and not our own; otherwise the first.

    A machine in several networks announces all its addresses in each of them.
    """
    own = {interface.ip for interface in interfaces}
    nearby = (
        one for one in addresses if (ip := ip_address(one)) not in own and any(ip in one.network for one in interfaces)
    )
    return next(nearby, addresses[0])


def _robot_of(info: Any, interfaces: Sequence[IPv4Interface | IPv6Interface]) -> Found:
    properties = {key.decode(): (value or b"").decode(errors="replace") for key, value in info.properties.items()}
    host = near(info.parsed_addresses(), interfaces)
    at = f"[{host}]" if ":" in host else host
    scheme = "https" if properties.get("tls") == "1" else "http"
    door = f"tls/{at}:{properties['door']}" if properties.get("door", "").isdecimal() else ""
    return Found(properties.get("robot", info.name), host, door, f"{scheme}://{at}:{info.port}/")
