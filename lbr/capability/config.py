"""The one document a capability's process gets at start: settings, wiring, devices, calibration."""

from collections.abc import Collection
from typing import Any, Protocol

from msgspec import Raw, Struct

from lbr.bus.access import Credentials, Rights
from lbr.messages.dance import DanceStep
from lbr.messages.faces import Button, EditCommand, FaceRows, Motor
from lbr.messages.joints import CapturedFrame, Joint, Motion
from lbr.messages.speech import Phrase
from lbr.messages.system import EstopState, Role, TokenRole


class InputWire(Struct, frozen=True, kw_only=True):
    """A stream that feeds a port: its key, who publishes it, and how much of it is wanted."""

    key: str
    source: str
    rate_hz: float | None = None
    history: int = 1
    seal: str = ""


class OutputWire(Struct, frozen=True, kw_only=True):
    """A key on which an output is published; sealed if it is somebody's setpoint."""

    key: str
    seal: str = ""


class DeviceConfig(Struct, frozen=True, kw_only=True):
    """A device row, its address as the profile has it."""

    name: str
    type: str
    address: str
    settings: dict[str, Any] = {}


class LanUser(Struct, frozen=True, kw_only=True):
    """Somebody who may come in from another machine; `hash` is of the secret, and must fit it."""

    name: str
    role: TokenRole
    secret: str
    hash: str


class LanGuest(Struct, frozen=True, kw_only=True):
    """A process of this robot that runs on another machine: who it is at the door, and what its rows wire."""

    credentials: Credentials
    rights: Rights


class LanConfig(Struct, frozen=True, kw_only=True):
    """What only the door to other machines needs to know.

    `link` is how its router proves itself to the one it hangs on, whose id is `upstream`; `inside` is where its relay
    comes in. `streams` may be read by all, `stops` be used by all, and `commands` maps every other command to the role
    it needs. `private_key` and `certificate` are files. `guests` are processes on other machines; what they take
    themselves, by role, is in `theirs` and not in `commands`.
    """

    listen: tuple[str, ...]
    link: Credentials
    users: tuple[LanUser, ...]
    streams: tuple[str, ...]
    stops: tuple[str, ...]
    commands: dict[str, Role]
    private_key: str
    certificate: str
    guests: tuple[LanGuest, ...] = ()
    theirs: dict[str, Role] = {}
    upstream: str = ""
    inside: str = ""


class ProcessConfig(Struct, frozen=True, kw_only=True):
    """Everything a process needs to know; it reads nothing else.

    `wiring` maps inputs and setpoints to the streams that feed them, `outputs` every output to its keys, `requests`
    to the capabilities asked and their keys. `simulated`: the robot's devices are emulated. `release_key` proves that a release of the e-stop is the executive's.
    `calibrates` is the device whose `calibration` this is. `host` is the other machine that it runs on, where
    `certificate` (PEM) is the only one that the robot's door may show; both are empty where the robot runs.
    """

    robot: str
    name: str
    kind: str
    settings: Raw
    simulated: bool = False
    endpoints: tuple[str, ...]
    home: str
    credentials: Credentials | None = None
    host: str = ""
    certificate: str = ""
    device: str = ""
    devices: tuple[DeviceConfig, ...] = ()
    wiring: dict[str, tuple[InputWire, ...]] = {}
    outputs: dict[str, tuple[OutputWire, ...]] = {}
    requests: dict[str, dict[str, str]] = {}
    calibrates: str = ""
    calibration: dict[str, float] = {}
    phrases: tuple[Phrase, ...] = ()
    dance_steps: tuple[DanceStep, ...] = ()
    joints: tuple[Joint, ...] = ()
    motions: tuple[Motion, ...] = ()
    motors: tuple[Motor, ...] = ()
    buttons: tuple[Button, ...] = ()
    users: tuple[LanUser, ...] = ()
    estop: EstopState = EstopState(engaged=False, reason="")
    release_key: str = ""
    lan: LanConfig | None = None


class Report(Struct, frozen=True, kw_only=True, omit_defaults=True):
    """A line from a process to its executive; an empty line is a bare heartbeat.

    `calibration` is what was measured on the device that it calibrates, `captured` a key frame that was made; both are
    to be written down.
    """

    phase: str = ""
    reason: str = ""
    counts: dict[str, int] = {}
    calibration: dict[str, float] = {}
    captured: CapturedFrame | None = None


class HasFaceRows(Protocol):
    """Whoever has been given rows that an edit may touch."""

    @property
    def motors(self) -> tuple[Motor, ...]:
        """Rows of the table `motor`."""

    @property
    def motions(self) -> tuple[Motion, ...]:
        """Rows of the table `motion`, with their key frames."""

    @property
    def buttons(self) -> tuple[Button, ...]:
        """Rows of the table `button`."""


def with_edit(before: HasFaceRows, edit: EditCommand, tables: Collection[str]) -> dict[str, Any]:
    """Return `motors`, `motions` and `buttons` as they are after an edit, as far as `tables` says that they are known."""
    rows = FaceRows(motors=before.motors, motions=before.motions, buttons=before.buttons).edited(edit)
    known = {"motor": "motors", "motion": "motions", "button": "buttons"}
    return {field: getattr(rows, field) for table, field in known.items() if table in tables}
