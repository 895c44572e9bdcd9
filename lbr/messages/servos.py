"""Messages on `servos/*`: between the joints operation and the driver of a servo bus, in the servos' own angles."""

from typing import Annotated, Literal

from msgspec import Meta, Struct

from lbr.messages.codes import ReasonCode
from lbr.messages.units import Fraction

ServoId = Annotated[int, Meta(ge=0, le=253, description="the servo's number on its bus")]
ServoRad = Annotated[float, Meta(ge=-10.0, le=10.0, description="radians from the middle of its range")]
ServoRps = Annotated[float, Meta(gt=0.0, le=100.0, description="radians a second")]
ServoPhase = Literal["released", "following", "holding", "releasing"]


class ServoGoal(Struct, frozen=True, kw_only=True):
    """The order for one servo. `position_rad` null: stay. `torque`: a fraction of its maximum; 0: off."""

    id: ServoId
    position_rad: ServoRad | None = None
    speed_rps: ServoRps | None = None
    torque: Fraction = 1.0


class StoredPlay(Struct, frozen=True, kw_only=True):
    """Play what the controller keeps in a slot, once for each growing `count`; no servo moves beside it."""

    slot: Annotated[int, Meta(ge=1, le=255)]
    count: Annotated[int, Meta(ge=1)]
    duration_s: Annotated[float, Meta(gt=0.0, le=600.0)]
    limp: bool = False


class StoredState(Struct, frozen=True, kw_only=True):
    """The progress of the newest `StoredPlay`."""

    slot: int
    count: int
    phase: Literal["waiting", "playing", "over", "failed"]
    reason: str = ""
    code: ReasonCode = ""


class ServoSetpoint(Struct, frozen=True, kw_only=True):
    """The goals of a bus, valid for 0.1 s; servos without a goal have no torque.

    `lost`: their sender is gone; the driver holds, then releases slowly. `halt`: counts stops; a new one goes to every
    servo first, and ends what the controller plays. While `stored` is played, `goals` only permit torque to servos.
    `lease`: a mark of the lease, which cannot be quoted.
    """

    goals: tuple[ServoGoal, ...]
    lost: bool = False
    halt: int = 0
    lease: str = ""
    stored: StoredPlay | None = None


class ServoState(Struct, frozen=True, kw_only=True):
    """One servo as measured last; null is not measured. `load`: a fraction of its maximum, signed like `speed_rps`.

    `faults`: reported by it or found by the driver. `latched`: those that keep it without torque until it is recovered.
    `age_s`: of the position. `trusted` false: `raw` came, and is not believed; null: the line leaves no doubt.
    """

    id: int
    position_rad: float | None = None
    speed_rps: float | None = None
    load: float | None = None
    goal_rad: float | None = None
    torque: float | None = None
    voltage_v: float | None = None
    temperature_c: float | None = None
    faults: tuple[str, ...] = ()
    latched: tuple[str, ...] = ()
    raw: int | None = None
    trusted: bool | None = None
    age_s: float | None = None
    reason: str = ""


class BusStatistics(Struct, frozen=True, kw_only=True):
    """The line in the last second or so, and its faults since it was opened."""

    sweeps_hz: float = 0.0
    states_hz: float = 0.0
    sweep_ms: float = 0.0
    timeouts: int = 0
    corrupt: int = 0
    retries: int = 0
    strays: int = 0
    sync_read: bool = False


class ServosState(Struct, frozen=True, kw_only=True):
    """One coherent look at every servo of a bus. `sweep` counts; `measured_s` is its end, monotonic.

    `armed`: a setpoint would be applied. `rests`: no servo moves; a setpoint is good for 0.3 s then. `stores`: its
    controller plays motions of its own; `stored`: the newest. `mode`: the controller's, where it has several.
    `tells_torque` false: servos cannot report their torque; null where this driver sent none.
    """

    sweep: int
    measured_s: float
    armed: bool
    phase: ServoPhase
    servos: tuple[ServoState, ...]
    reason: str = ""
    code: ReasonCode = ""
    estop: bool = False
    halt: int = 0
    stores: bool = False
    stored: StoredState | None = None
    mode: str = ""
    tells_torque: bool = True
    rests: bool = False
    bus: BusStatistics = BusStatistics()
    heard: bool | None = None


class RecoverServos(Struct, frozen=True, kw_only=True):
    """Recover servos from latched faults whose cause is gone; moves nothing. Empty: all."""

    ids: tuple[ServoId, ...] = ()
