"""The kind `registrar`: its settings, ports and words."""

import re
from typing import Annotated

from msgspec import Meta, Struct

from lbr.apps.registry.book import Endpoint
from lbr.apps.registry.messages import RegistrarState
from lbr.capability.kind import Kind, Wire
from lbr.messages.web import WebState

PORT = 9147
_URL = re.compile(r"https://(\[[0-9a-fA-F:]+\]|[A-Za-z0-9]([A-Za-z0-9.-]*[A-Za-z0-9])?)(:[0-9]{1,5})?/?")


class RegistrarSettings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Settings of a row of kind `registrar`.

    `credential`: the file in credentials/ with this robot's token, from `lbr registry add`. `endpoints`: ways to the
    robot's bus, reported beside its web addresses.
    """

    url: Annotated[str, Meta(max_length=300, description="the service; empty: there is none")] = ""
    credential: Annotated[str, Meta(pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]{0,79}$(?!\n)")] = "registry.token"
    every_s: Annotated[float, Meta(ge=5.0, le=300.0, description="gone after three times this")] = 10.0
    endpoints: Annotated[tuple[Endpoint, ...], Meta(max_length=8)] = ()

    def __post_init__(self) -> None:
        """Refuse a bad URL."""
        if self.url and _URL.fullmatch(self.url) is None:
            raise ValueError(f"url: '{self.url[:80]}' is no address; addresses look like https://HOST:{PORT}")


KIND = Kind(
    name="registrar",
    summary="registers the robot with a service that lists which robots are up",
    family="app",
    entry="lbr.apps.registry.capability:Registrar",
    settings=RegistrarSettings,
    inputs={"web": WebState},
    optional=("web",),
    outputs={"state": RegistrarState},
    wires={"web": Wire("state", 4)},
)
