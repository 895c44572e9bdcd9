"""Announces the robot in the network by zeroconf while the server runs, in the server's event loop."""

import asyncio
import hashlib
import ipaddress
from collections.abc import Callable
from contextlib import suppress

from lbr.apps.http import names

LOOK_S = 5.0
TRY_AGAIN_S = 30.0
KINDS = ("_http._tcp.local.", "_lbr._tcp.local.")


def own_mark(addresses: tuple[str, ...], port: int) -> str:
    """Return a mark of this server; machines from one image have the same host name, but different addresses."""
    return hashlib.blake2b(f"{addresses} {port}".encode(), digest_size=3).hexdigest()


class Announcer:
    """Announces `name` at `port`, with the addresses of `where` and the `properties`, and follows their changes.

    The announced name ends with a mark, and the host name is this machine's alone, so robots cannot be mixed up.

    - `said`: the announced name, or empty.
    - `trouble`: the reason why it is not announced, or empty.
    """

    def __init__(
        self, name: str, port: int, where: Callable[[], tuple[str, ...]], properties: Callable[[], dict[str, str]]
    ) -> None:
        self.said = ""
        self.trouble = ""
        self._name = name
        self._port = port
        self._where = where
        self._properties = properties

    async def run(self) -> None:
        """Announce until cancelled; errors do not end it."""
        while True:
            addresses = self._where()
            if not addresses:
                self.trouble = "this machine is in no network"
                await asyncio.sleep(LOOK_S)
                continue
            wait_s = await self._announce(addresses)
            if wait_s:
                await asyncio.sleep(wait_s)

    async def _announce(self, addresses: tuple[str, ...]) -> float:
        """Announce while the addresses stay; return the wait before the next try."""
        try:
            from zeroconf import Error, IPVersion
            from zeroconf.asyncio import AsyncServiceInfo, AsyncZeroconf
        except ImportError:
            self.trouble = "the package 'zeroconf' is missing: pip install 'lbr[web]'"
            return TRY_AGAIN_S
        both = any(":" in address for address in addresses)
        try:
            zeroconf = AsyncZeroconf(
                interfaces=[address for address in addresses if ":" not in address] or list(addresses),
                ip_version=IPVersion.All if both and all(":" in address for address in addresses) else IPVersion.V4Only,
            )
        except (OSError, Error, RuntimeError) as err:
            self.trouble = f"the network takes no announcement ({err})"
            return TRY_AGAIN_S
        try:
            properties = self._properties()
            there_as = [ipaddress.ip_address(address).packed for address in addresses]
            mark = own_mark(addresses, self._port)
            infos = [
                AsyncServiceInfo(
                    kind,
                    f"{self._name} {mark}.{kind}",
                    port=self._port,
                    addresses=there_as,
                    properties=properties,
                    server=f"{names.announced()}.",
                )
                for kind in KINDS
            ]
            told = [zeroconf.async_register_service(info, allow_name_change=True) for info in infos]
            broadcasts = await asyncio.gather(*told)
            self.said, self.trouble = infos[0].name, ""
            await asyncio.gather(*broadcasts)
            await self._until_changed(addresses, properties)
        except (OSError, Error, TimeoutError) as err:
            self.trouble = f"the network takes no announcement ({err or type(err).__name__})"
            return TRY_AGAIN_S
        else:
            return 0.0
        finally:
            self.said = ""
            with suppress(OSError, Error, TimeoutError):
                async with asyncio.timeout(1.0):
                    await zeroconf.async_close()

    async def _until_changed(self, addresses: tuple[str, ...], properties: dict[str, str]) -> None:
        while True:
            await asyncio.sleep(LOOK_S)
            if self._where() != addresses or self._properties() != properties:
                return
