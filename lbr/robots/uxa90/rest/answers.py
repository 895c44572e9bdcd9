"""Answers of the API, with the keys and their order known to phones and scripts; other keys only on request."""

# ruff: noqa: N815 - the API's own names

from typing import Literal

from msgspec import UNSET, Struct, UnsetType

from lbr.messages.schema import JsonObject

Number = int | float


class Measured(Struct, frozen=True):
    """The report of a servo: its count, its load as a fraction, its age; null if unknown or untrusted."""

    position: int | None
    load: float | None
    age_s: float | None
    trusted: bool


class MotorData(Struct, frozen=True):
    """A motor. `position` is its last commanded one; `rawPosition` the same as a whole count, `smartPosition` in the
    requested unit."""

    id: int
    name: str
    description: str
    position: Number
    min: int
    max: int
    default: int
    inverted: bool
    smartPosition: Number | UnsetType | None = UNSET
    rawPosition: int | UnsetType = UNSET
    measured: Measured | UnsetType | None = UNSET
    commanded: Number | UnsetType = UNSET


class MotorAnswer(Struct, frozen=True):
    """All motors, one, or one that moves from now on; `job` if it will do so after a delay."""

    data: list[MotorData] | MotorData
    message: Literal["getAllMotors", "getMotorInfo", "setMotorPos"]
    oldPosition: Number | UnsetType = UNSET
    newPosition: Number | UnsetType = UNSET
    torq: Number | UnsetType = UNSET
    job: str | UnsetType = UNSET


class MultiPositions(Struct, frozen=True):
    """The motors of the request, with the clamped positions."""

    positions: list[JsonObject]


class MultiAnswer(Struct, frozen=True):
    """Several motors that move from now on, or after their delays as `job`."""

    message: Literal["setMultiMotorsPos"]
    multiMsg: MultiPositions
    job: str | UnsetType = UNSET


class MotionData(Struct, frozen=True):
    """A motion: its number, its name, the button of the remote control."""

    id: int
    name: str
    button: str


class MotionsAnswer(Struct, frozen=True):
    """All motions."""

    data: list[MotionData]
    message: Literal["findAll"] = "findAll"


class MotionMessage(Struct, frozen=True):
    """The code of a motion; a name for an order to the main board that is not a motion."""

    btn_code: int | UnsetType = UNSET
    motion_name: str | UnsetType = UNSET


class PlayedAnswer(Struct, frozen=True):
    """A motion that plays from now on."""

    data: MotionData
    message: Literal["callMotionById", "callMotionByName"]
    motionMsg: MotionMessage
