"""The kind `foxglove`: its settings, ports and words."""

import re
from typing import Annotated

from msgspec import Meta

from lbr.apps.foxglove.messages import FoxgloveState
from lbr.apps.web.server_settings import ServerSettings
from lbr.bus.door import LanUser
from lbr.capability.kind import Kind, Needs, Rights, Rows
from lbr.messages.joints import Joint
from lbr.messages.kinematics import Wheel
from lbr.messages.sensing import RangeSensor

_ORIGIN = re.compile(r"[a-z][a-z0-9+.-]*://[^/?#\s@]*")


class FoxgloveSettings(ServerSettings, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Settings of a row of kind `foxglove`.

    Where other machines reach it, clients need a token, and TLS unless `clear_text`. `cors`: origins whose pages may
    connect; by default Foxglove's own.
    """

    port: Annotated[int, Meta(ge=0, le=65535, description="0: any free one")] = 8765
    cors: Annotated[tuple[str, ...], Meta(description="origins whose pages may connect")] = (
        "https://app.foxglove.dev",
        "https://embed.foxglove.dev",
    )
    rate_hz: Annotated[float, Meta(ge=0.5, le=50.0, description="messages a second of one stream, at most")] = 25.0
    clients: Annotated[int, Meta(ge=1, le=16, description="connections at once")] = 8

    def __post_init__(self) -> None:
        """Refuse bad origins, and settings that contradict each other."""
        for origin in self.cors:
            if origin != "null" and _ORIGIN.fullmatch(origin) is None:
                raise ValueError(f"cors: '{origin}' is not an origin; origins look like https://app.foxglove.dev")
        super().__post_init__()


KIND = Kind(
    name="foxglove",
    summary="serves the robot to Foxglove: streams, cameras, its body, its words as services",
    family="app",
    rights=Rights(people=True, lets_in=("enabled", "host", "tls", "clear_text", "cors", "names")),
    entry="lbr.apps.foxglove.capability:Foxglove",
    settings=FoxgloveSettings,
    outputs={"state": FoxgloveState},
    rows=(Joint, Wheel, RangeSensor, Rows(LanUser, followed=True)),
    needs=Needs("uvicorn", extra="foxglove"),
)
