"""A bus of Feetech STS3215 servos, as in an SO-101 arm: its kind and its settings.

`table` is the control table, `bus` the transactions, `model` the meaning of the numbers. `setup` checks a servo before
its use, `driver` combines all of it, and `twin` is the emulated bus. The common part of all servo drivers is in
`lbr.drivers.servos`.
"""

from typing import Annotated

from msgspec import Meta

from lbr.drivers.servos import RegisterServosSettings, servos_kind

ModelNumber = Annotated[int, Meta(ge=1, le=0xFFFF)]


class FeetechSettings(RegisterServosSettings, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The settings of a row of kind `feetech`."""

    baud: Annotated[int, Meta(ge=38_400, le=1_000_000)] = 1_000_000
    reply_margin_s: Annotated[
        float, Meta(ge=0.001, le=0.1, description="an answer so much later than wire and servo explain is lost")
    ] = 0.006
    sync_read: Annotated[bool, Meta(description="read all servos by one request")] = True
    acceleration: Annotated[
        int, Meta(ge=0, le=254, description="how fast servos gain speed, in 0.153 rad/s2; 0: as fast as they can")
    ] = 0
    models: Annotated[
        tuple[ModelNumber, ...], Meta(min_length=1, description="model numbers that are driven; 777 is an STS3215")
    ] = (777,)
    check_phase: Annotated[
        bool, Meta(description="refuse a servo whose register 18 says that it counts speeds or turns in another way")
    ] = True


KIND = servos_kind(
    "feetech",
    "a bus of Feetech STS3215 servos, as of an SO-101 arm",
    "lbr_so101.driver:Feetech",
    FeetechSettings,
    recognised="lbr_so101.recognition:HANDSHAKE",
)
