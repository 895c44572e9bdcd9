"""The kind `web`: its settings, ports and words."""

import re
from ipaddress import ip_network
from typing import Annotated, Literal

from msgspec import Meta, Struct

from lbr import plugins
from lbr.apps.web.ports import FacePorts, with_faces
from lbr.apps.web.server_settings import ServerSettings
from lbr.bus.door import LanUser
from lbr.capability.kind import Command, Kind, Rights, Rows
from lbr.capability.word import Word
from lbr.messages.battery import BatteryState
from lbr.messages.drive import DriveState, GoalResult
from lbr.messages.faces import Button, EditCommand, EditReply, Motor
from lbr.messages.joints import (
    Joint,
    JointsCommand,
    JointsState,
    MotionRow,
    MotionsState,
    MotionStep,
    PlayCommand,
    TorqueCommand,
)
from lbr.messages.leases import CommandReply, StopCommand
from lbr.messages.pairing import PairCommand, PairReply
from lbr.messages.sensing import Ranges
from lbr.messages.system import EstopResetCommand
from lbr.messages.units import Name
from lbr.messages.web import AddressCommand, AddressReply, WebState

_ORIGIN = re.compile(r"[a-z][a-z0-9+.-]*://[^/?#\s@]+")
Network = Annotated[str, Meta(description="an address or a network, such as 192.168.1.0/24")]


class OldApi(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The face `lbr_original` and the clients of the old API of the robot lbr."""

    heartbeat_s: Annotated[float, Meta(ge=0.5, le=5.0, description="a moving client silent for longer is lost")] = 1.5
    unattended_s: Annotated[
        float,
        Meta(ge=0.0, le=60.0, description="of a turn or timed move that its client only began"),
    ] = 10.0
    dock_ttl_s: Annotated[float, Meta(ge=0.2, le=10.0, description="how long a client's beam counts")] = 3.0
    over_range_cm: Annotated[int, Meta(ge=100, le=1000, description="the distance where nothing is within reach")] = 758


class WebSettings(ServerSettings, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Settings of a row of kind `web`.

    It serves HTTPS where other machines reach it, unless `clear_text` is set. Clients in `trusted` networks operate
    without a token. `legacy` opens the API from before tokens: all programs of this machine may then move the robot. A
    GET may move it, too, and any web page can send one. With `simulated` this holds only while the robot is simulated.
    """

    port: Annotated[int, Meta(ge=0, le=65535, description="0: any free one")] = 50000
    faces: Annotated[tuple[Name, ...], Meta(description="components' faces, besides states and stops")] = ()
    layer: Annotated[Name, Meta(description="which layer of the table `motor` is shown")] = "api"
    legacy: Annotated[
        Literal["off", "simulated", "on"],
        Meta(description="apps without a token move the robot, from here and trusted networks"),
    ] = "simulated"
    trusted: Annotated[tuple[Network, ...], Meta(description="networks whose clients operate without a token")] = ()
    cors: Annotated[tuple[str, ...], Meta(description="origins of pages, such as http://localhost:8081; *: all")] = ()
    announce: Annotated[bool, Meta(description="by zeroconf, where others reach it")] = True
    requests_per_s: Annotated[float, Meta(ge=1.0, le=10_000.0, description="the most from one address")] = 200.0
    old_api: OldApi = OldApi()

    def __post_init__(self) -> None:
        """Refuse bad networks, bad origins, and settings that contradict each other."""
        for network in self.trusted:
            try:
                ip_network(network, strict=False)
            except ValueError:
                raise ValueError(f"trusted: '{network}' is not an address or network, such as 192.168.1.0/24") from None
        for origin in self.cors:
            if origin not in {"*", "null"} and _ORIGIN.fullmatch(origin) is None:
                raise ValueError(f"cors: '{origin}' is not an origin; origins look like http://localhost:8081")
        super().__post_init__()

    def doubts(self) -> tuple[str, ...]:
        """Return the faces that no installed package brings; the server shows the others."""
        there = sorted(plugins.installed("faces"))
        text = f"there are {', '.join(there) or 'none'}"
        missing = tuple(f"faces: no package brings '{name}'; {text}" for name in self.faces if name not in there)
        return missing + REFUSED


_COMMANDS = ("move", "halt", "torque", "play", "stop_motion", "estop_reset")
PORTS, REFUSED = with_faces(
    FacePorts(
        inputs={
            "joints": JointsState,
            "motions": MotionsState,
            "moved": GoalResult,
            "played": GoalResult,
            "drive": DriveState,
            "ranges": Ranges,
            "battery": BatteryState,
        },
        states=("joints", "motions", "drive", "ranges", "battery"),
        requests={
            "move": JointsCommand,
            "halt": StopCommand,
            "torque": TorqueCommand,
            "play": PlayCommand,
            "stop_motion": StopCommand,
            "edit": EditCommand,
            "estop_reset": EstopResetCommand,
        },
        replies={"edit": EditReply, **dict.fromkeys(_COMMANDS, CommandReply)},
        rows=(Joint, MotionRow, MotionStep, Motor, Button, LanUser),
    )
)
"""The ports of the server and of all installed faces; REFUSED has the faults of the others."""

PHONE = "Connect a phone: open the web server to your network, and show a code to scan"
FOLLOWED = {LanUser, MotionRow, MotionStep}
"""The rows for whose edits the server is not restarted: a revoked token ends its own client's connections."""
LETS_IN = ("host", "tls", "clear_text", "legacy", "trusted", "cors", "names", "announce")

KIND = Kind(
    name="web",
    summary="serves the robot over HTTP: an API, a page, and a stream of states",
    family="app",
    rights=Rights(serves=True, people=True, pairs=True, lets_in=LETS_IN, edits=PORTS.edits),
    entry="lbr.apps.web.start:Web",
    settings=WebSettings,
    inputs=PORTS.inputs,
    optional=tuple(PORTS.inputs),
    outputs={"state": WebState},
    commands={
        "address": Command(AddressCommand, role="view"),
        "stop": StopCommand,
    },
    requests={**PORTS.requests, "pair": PairCommand},
    replies={"address": AddressReply, "stop": CommandReply, "pair": PairReply, **PORTS.replies},
    rows=tuple(Rows(row, followed=row in FOLLOWED) for row in PORTS.rows),
    words=(
        Word("phone", "phone", PHONE, executive=True, role="admin"),
        Word("p", "phone", PHONE, executive=True, role="admin"),
        Word("qr", "address", "Show where phones find the robot, as a QR code"),
        Word(
            "pair", "pair", "Let a phone in: six digits for a token, good for two minutes", executive=True, role="admin"
        ),
        Word("/pair/{role}", "pair", "The same, with a role: view, operate or admin", executive=True, role="admin"),
        Word("open", "open", "Let other machines reach the web server, and show where", executive=True, role="admin"),
        Word("close", "close", "Let only this machine reach the web server", executive=True, role="admin"),
    ),
)
