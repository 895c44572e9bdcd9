"""The one document that a capability's process gets at its start: settings, wiring, devices, rows."""

from msgspec import Raw, Struct

from lbr.bus.access import Credentials
from lbr.messages.codes import ReasonCode
from lbr.messages.rows import RowSet
from lbr.messages.schema import JsonObject
from lbr.messages.system import EstopState

NOTHING = Raw(b"null")
"""The private document of kinds that have none."""


class InputWire(Struct, frozen=True, kw_only=True):
    """A stream that feeds a port: its key, its publisher, and how much of it is read."""

    key: str
    source: str
    rate_hz: float | None = None
    history: int = 1
    seal: str = ""


class OutputWire(Struct, frozen=True, kw_only=True):
    """A key on which an output is published; sealed if it is a setpoint."""

    key: str
    seal: str = ""


class DeviceConfig(Struct, frozen=True, kw_only=True):
    """A device row, with the address from the profile."""

    name: str
    type: str
    address: str
    settings: JsonObject = {}


class ProcessConfig(Struct, frozen=True, kw_only=True):
    """Everything that a process needs; it reads nothing else.

    `wiring` maps inputs and setpoints to the streams that feed them. `outputs` maps every output to its keys, and
    `requests` maps requests to their receivers and keys. `simulated`: the robot's devices are emulated. `release_key`
    proves that a release of the e-stop is the executive's. `rows` are those that its kind reads, by table. `private` is
    a document between its kind and the executive. `host` is the other machine on which it runs, and `certificate` (PEM)
    the only one that the robot's door may present there. Both are empty on the robot's own machine. `source` is the
    accepted text of the user's own file that declares its kind. It is empty for an installed kind, or if the host has
    the file. `process` names the process that it shares with others. It is empty if it has its own. `reach` are the
    addresses of all devices of the capabilities in that process.
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
    source: str = ""
    process: str = ""
    reach: tuple[str, ...] = ()
    device: str = ""
    devices: tuple[DeviceConfig, ...] = ()
    wiring: dict[str, tuple[InputWire, ...]] = {}
    outputs: dict[str, tuple[OutputWire, ...]] = {}
    requests: dict[str, dict[str, str]] = {}
    rows: dict[str, RowSet] = {}
    estop: EstopState = EstopState(engaged=False, reason="")
    release_key: str = ""
    private: Raw = NOTHING

    @property
    def places(self) -> tuple[str, ...]:
        """Return the places that its process must reach: its home, and the devices of all capabilities in it."""
        return (self.home, *self.reach, *(device.address for device in self.devices))


class Report(Struct, frozen=True, kw_only=True, omit_defaults=True):
    """A line from a process to its executive. A line without phase, counts and rows is a bare heartbeat.

    `at` is when the loop went round, on this machine's monotonic clock. `number` is that of the order that started the
    capability. `code` classifies `reason`, by the list of codes. `learnt` are rows to store, by table. `thread` is the
    kernel's number of the thread that the loop runs in.
    """

    number: int = 0
    phase: str = ""
    reason: str = ""
    code: ReasonCode = ""
    counts: dict[str, int] = {}
    learnt: dict[str, Raw] = {}
    thread: int = 0
    at: float = 0.0


class Order(Struct, frozen=True, kw_only=True, omit_defaults=True):
    """A line to a process: `start` a capability, or end the one that was started with this number.

    No number is used twice, so that a report never counts for another start.
    """

    number: int
    start: ProcessConfig | None = None
