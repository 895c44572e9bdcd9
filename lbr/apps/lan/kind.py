"""The kind `lan`: its settings, ports and words."""

from typing import Annotated

from msgspec import Meta, Struct

from lbr.apps.http.names import is_local
from lbr.capability.kind import Kind, Rights

Endpoint = Annotated[str, Meta(pattern="^(tls|tcp)/[^\\s#?]+:[0-9]{1,5}$(?!\\n)", max_length=200)]


class LanSettings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Where to listen. `tls/…` anywhere, `tcp/…` on loopback only."""

    listen: Annotated[tuple[Endpoint, ...], Meta(min_length=1, max_length=8)]

    def __post_init__(self) -> None:
        """Refuse clear text to other machines, and bad ports."""
        for endpoint in self.listen:
            protocol, _, place = endpoint.partition("/")
            host, _, port = place.rpartition(":")
            if not 0 < int(port) < 65536:
                raise ValueError(f"listen: '{endpoint}' has no port between 1 and 65535")
            if protocol == "tcp" and not is_local(host.strip("[]")):
                raise ValueError(
                    f"listen: '{endpoint}' would talk to other machines in clear text; "
                    f"write 'tls/{place}' in the setting 'listen' of the row, or after --listen"
                )


KIND = Kind(
    name="lan",
    summary="the door to other machines: each token lets in with the rights of its role",
    family="app",
    rights=Rights(serves=True, lets_in=("enabled", "listen")),
    entry="lbr.apps.lan.capability:Lan",
    settings=LanSettings,
)
