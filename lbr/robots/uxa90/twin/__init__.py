"""The emulated serial line of a UXA-90: the settings of its device rows, its faults, and its twin."""

from typing import Annotated

from msgspec import Meta, Struct

from lbr.capability.twins import DeviceTwin
from lbr.robots.uxa90.twin.firmware import Programme
from lbr.simulation.faults import Faults, Probability, ServoIds

Scale = Annotated[float, Meta(gt=0.0, le=1e6)]
Byte = Annotated[int, Meta(ge=0, le=255)]
Slot = Annotated[str, Meta(pattern="^[1-9][0-9]?$(?!\\n)", description="the number of a main board's motion")]


class Uxa90Faults(Faults, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Faults of a UXA-90's serial line; lists are of servos' ids. `unplug`: the cable is out, the robot goes on.

    `no_replies`: only the main board answers. `kills_pc`: PC control ends after half a second. `babble`: bytes all the
    time. `late_s`: the delay of answers. `dead`: missing servos; `stuck`: they do not turn; `frozen`: positions and
    loads repeat. Of answers, `missing`: none; `garbage`: other bytes; `shifted`: a byte before.
    """

    silent: bool = False
    no_replies: bool = False
    stop_reading: bool = False
    brown_out: bool = False
    kills_pc: bool = False
    babble: bool = False
    frozen: bool = False
    late_s: Annotated[float, Meta(ge=0.0, le=10.0, description="seconds")] = 0.0
    dead: ServoIds = ()
    stuck: ServoIds = ()
    missing: Probability = 0.0
    garbage: Probability = 0.0
    shifted: Probability = 0.0
    bit_flip: Probability = 0.0


class Uxa90Row(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The main board at the other end of a `uxa90` device row's line, and its speed; `ids` are its servos.

    `zeros`: each servo's, as stored in the board. `programmes`: replace motions of the board, by slot. `aborts`: PC
    control ends a motion; else it is ignored meanwhile. `reports_end`: a motion of the remote control is answered at
    its end. `answers_fine`: a move of 14 bits is, too. `imu_sum`: its inertial unit's sum is right. A servo answers
    after `reply_ms` and up to `jitter_ms`, PC control after `settle_ms`. `trace`: bytes and mode changes go to a
    `.trace` file beside the device's address.
    """

    faults: Uxa90Faults = Uxa90Faults()
    baud: Annotated[int, Meta(ge=4800, le=921_600)] = 115_200
    ids: Annotated[tuple[Annotated[int, Meta(ge=0, le=30)], ...], Meta(min_length=1)] = tuple(range(25))
    firmware: Annotated[tuple[Byte, ...], Meta(min_length=2, max_length=2)] = (0xC9, 0x00)
    serial: Annotated[str, Meta(pattern="^[0-9]{13}$(?!\\n)")] = "6012000010005"
    zeros: Annotated[tuple[Annotated[int, Meta(ge=0, le=254)], ...], Meta(min_length=31, max_length=31)] = (
        *(130, 129, 129, 131, 38, 214, 85, 172, 128, 132, 131, 130, 87, 169, 134, 125),
        *(128, 126, 215, 43, 127, 127, 127, 130, 125, 1, 127, 127, 127, 127, 127),
    )
    programmes: dict[Slot, Programme] = {}
    aborts: bool = True
    reports_end: bool = True
    answers_fine: bool = False
    imu_sum: bool = True
    imu_lsb_per_g: Scale = 256.0
    reply_ms: Annotated[float, Meta(ge=0.0, le=250.0)] = 1.0
    jitter_ms: Annotated[float, Meta(ge=0.0, le=250.0)] = 0.3
    saving_ms: Annotated[float, Meta(ge=0.0, le=250.0, description="how much longer saving a register takes")] = 30.0
    settle_ms: Annotated[float, Meta(ge=0.0, le=5000.0)] = 50.0
    trace: bool = False


TWIN = DeviceTwin(
    device="uxa90",
    row=Uxa90Row,
    entry="lbr.robots.uxa90.twin.twin:Uxa90Twin",
    player="lbr.robots.uxa90.twin.board:MainBoard",
)
