"""The door to other machines: a router of its own, with tokens, and a relay that marks what commands motion."""

from typing import Annotated

from msgspec import Meta, Struct

from lbr.capability.kind import Kind

Endpoint = Annotated[str, Meta(pattern="^(tls|tcp)/[^\\s#?]+:[0-9]{1,5}$", max_length=200)]


class LanSettings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Where to listen. `tls/…` anywhere, `tcp/…` on loopback only."""

    listen: Annotated[tuple[Endpoint, ...], Meta(min_length=1, max_length=8)]


KIND = Kind(
    name="lan",
    summary="the door to other machines: whoever has a token comes in, with the rights of its role",
    family="app",
    entry="lbr.apps.lan.capability:Lan",
    settings=LanSettings,
)
