"""The kind `mqtt`: its settings, ports and words."""

import re
from typing import Annotated, Literal, get_args

from msgspec import Meta, Struct

from lbr.apps.http.names import is_local
from lbr.apps.motion_requests import motion_requests
from lbr.apps.mqtt.messages import MqttState
from lbr.apps.mqtt.report import Streams
from lbr.apps.mqtt.words import Word
from lbr.bus.door import TokenRight
from lbr.capability.kind import Kind, Needs, Rights, Rows, Wire
from lbr.messages.behaviour import RunBehaviour
from lbr.messages.camera import JpegFrame
from lbr.messages.drive import GoalResult
from lbr.messages.speech import SayCommand
from lbr.messages.units import Name

Part = Literal["battery", "docked", "position", "motion", "behaviour", "faults"]
CredentialFile = Annotated[
    str,
    Meta(
        pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]{0,79}$(?!\n)|^$(?!\n)",
        description="a file in credentials/ of the robot's home",
    ),
]
_SEGMENT = r"[^/+#\x00\s]{1,64}"
Topic = Annotated[str, Meta(pattern=rf"^({_SEGMENT}(/{_SEGMENT}){{0,6}})?$(?!\n)", max_length=200)]


class Shadow(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A device shadow of AWS IoT: its thing and its name; empty: the unnamed one."""

    thing: Annotated[str, Meta(pattern=r"^[A-Za-z0-9:_-]{1,128}$(?!\n)")]
    name: Annotated[str, Meta(pattern=r"^[A-Za-z0-9:_-]{0,64}$(?!\n)")] = ""


class HomeAssistant(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The discovery by Home Assistant; `picture_s`: the period of pictures from `frames`."""

    prefix: Annotated[Topic, Meta(min_length=1)] = "homeassistant"
    name: Annotated[str, Meta(max_length=80, description="the robot's name; empty: its row's")] = ""
    picture_s: Annotated[float, Meta(ge=1.0, le=3600.0)] = 10.0


class MqttSettings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Settings of a row of kind `mqtt`.

    TLS unless the broker is on this machine, or `clear_text`. `ca`: the broker's authority, if the system does not know
    it; `certificate`, `key`: the robot's own. `token`: whoever sends `words` has its role; without one only a stop
    is done. `topic`: the beginning of all topics; empty: `lbr/` and the robot's name.
    """

    host: Annotated[str, Meta(max_length=253, description="the broker; empty: there is none")] = ""
    port: Annotated[int, Meta(ge=1, le=65535)] = 8883
    tls: bool = True
    clear_text: Annotated[
        bool, Meta(description="no TLS to another machine: all in between read, and ask in its name")
    ] = False
    ca: CredentialFile = ""
    certificate: CredentialFile = ""
    key: CredentialFile = ""
    user: Annotated[str, Meta(max_length=128)] = ""
    password: Annotated[CredentialFile, Meta(description="the file with the user's password")] = ""
    client_id: Annotated[str, Meta(pattern=r"^[A-Za-z0-9:_-]{0,128}$(?!\n)")] = ""
    keepalive_s: Annotated[int, Meta(ge=5, le=1200, description="a broker silent for longer is gone")] = 20
    topic: Topic = ""
    report: tuple[Part, ...] = ("battery", "docked", "position", "motion", "behaviour", "faults")
    every_s: Annotated[float, Meta(ge=5.0, le=3600.0, description="changes are reported at most so often")] = 5.0
    token: Annotated[str, Meta(max_length=40)] = ""
    words: Annotated[dict[Name, Word], Meta(max_length=40, description="what may be asked")] = {}
    late_s: Annotated[float, Meta(ge=1.0, le=300.0, description="older desires of a shadow are not done")] = 20.0
    ttl_s: Annotated[float, Meta(ge=0.2, le=1.0, description="motion outlives this process for so long")] = 0.5
    shadow: Shadow | None = None
    home_assistant: HomeAssistant | None = None

    def __post_init__(self) -> None:
        """Refuse settings that contradict each other or cannot be meant, before anything is sent."""
        if self.host and re.fullmatch(r"[A-Za-z0-9]([A-Za-z0-9.:_-]*[A-Za-z0-9])?|::1", self.host) is None:
            raise ValueError(f"host: '{self.host}' is no name and no address of a machine")
        if self.host and not (self.tls or self.clear_text or is_local(self.host)):
            raise ValueError(
                "tls: another machine is spoken to by TLS; clear_text = true does without, and lets all in between ask"
            )
        if bool(self.certificate) != bool(self.key):
            raise ValueError("certificate and key: each needs the other")
        if self.password and not self.user:
            raise ValueError("password: it needs a user")


_MOTION = motion_requests("move", "turn", "heading", "halt", "play", "play_halt", "stop_all")
_STREAMS: dict[str, type[Struct]] = {name: get_args(kind)[0] for name, kind in Streams.__annotations__.items()}

KIND = Kind(
    name="mqtt",
    summary="reports the robot to an MQTT broker, and does what its row allows there",
    family="app",
    rights=Rights(
        lets_in=(
            *("enabled", "host", "port", "tls", "clear_text", "ca", "user", "topic"),
            *("token", "words", "shadow", "home_assistant"),
        )
    ),
    entry="lbr.apps.mqtt.capability:Mqtt",
    settings=MqttSettings,
    inputs={**_STREAMS, "results": GoalResult, "frames": JpegFrame},
    optional=(*_STREAMS, "results", "frames"),
    outputs={"state": MqttState},
    requests={**_MOTION.requests, "run": RunBehaviour, "say": SayCommand},
    rows=(Rows(TokenRight, {"name": "token"}),),
    wires={
        **dict.fromkeys(_STREAMS, Wire("state")),
        "results": Wire("result", 16),
        **_MOTION.wires,
        "run": Wire("behaviour.run"),
        "say": Wire("speech.say"),
    },
    needs=Needs("paho", extra="mqtt"),
)
