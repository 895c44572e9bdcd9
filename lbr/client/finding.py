"""Which robots there are: on this machine, and those that tell the network where they are."""

import time
from typing import Any, NamedTuple

from lbr import home
from lbr.client.robot import Robot, connect

KIND = "_lbr._tcp.local."
"""What `lbr.apps.web.announce` announces."""


class Found(NamedTuple):
    """A robot: `host` is empty on this machine; `door` is where programs come in from elsewhere, `page` for browsers."""

    robot: str
    host: str = ""
    door: str = ""
    page: str = ""

    def connect(self, **how: Any) -> Robot:
        """Connect to it, as `connect` does; raise BusError if it has no door to other machines."""
        return connect(self.robot, at=self.door or None, **how)


def find(*, within_s: float = 2.0) -> list[Found]:
    """Return the robots that run here and, where the package `zeroconf` is installed, those of the network.

    A robot tells the network of itself once its page is open to it (`web`), and of its door once that has a row (`lan`).
    """
    here = [Found(one.robot) for one in home.running()]
    return here + _of_network(within_s)


def _of_network(within_s: float) -> list[Found]:
    try:
        from zeroconf import ServiceBrowser, Zeroconf  # noqa: PLC0415 - an extra
    except ImportError:
        return []
    heard: set[str] = set()

    def hear(name: str, **_rest: object) -> None:
        heard.add(name)

    try:
        network = Zeroconf()
    except OSError:  # no network at all
        return []
    try:
        ServiceBrowser(network, KIND, handlers=[hear])
        time.sleep(within_s)
        infos = [network.get_service_info(KIND, name, timeout=1000) for name in sorted(heard)]
    finally:
        network.close()
    return [_found(info) for info in infos if info is not None and info.parsed_addresses()]


def _found(info: Any) -> Found:
    said = {key.decode(): (value or b"").decode(errors="replace") for key, value in info.properties.items()}
    host = info.parsed_addresses()[0]
    at = f"[{host}]" if ":" in host else host
    scheme = "https" if said.get("tls") == "1" else "http"
    door = f"tls/{at}:{said['door']}" if said.get("door", "").isdecimal() else ""
    return Found(said.get("robot", info.name), host, door, f"{scheme}://{at}:{info.port}/")
