"""The routes of the UXA-90's API: what each takes, returns and needs."""

from collections.abc import Sequence
from typing import Any

from lbr.apps.web import face as web
from lbr.apps.web.face import Route
from lbr.robots.uxa90.rest.answers import MotionsAnswer, MotorAnswer, MultiAnswer, PlayedAnswer
from lbr.robots.uxa90.rest.bodies import (
    MotionBody,
    MotionRowAnswer,
    MotorBody,
    MotorParams,
    MotorRowAnswer,
    MultiBody,
    MultiParams,
    NewMotorBody,
)
from lbr.robots.uxa90.rest.handlers import Handlers, ok
from lbr.robots.uxa90.rest.jobs import JobReply, JobsReply

REFUSED = {400: "It makes no sense.", 409: "It is not there, is busy, held by another, or not allowed."}
MOVE_S = 4.0
"""A motion's answer may need three others': the joints given back, motions, joints again."""
EDIT_S = 7.0
EDIT = {400: "The body makes no sense.", 403: "It is built in.", 404: "It is not there.", 409: "It cannot be so."}
CHANGED = {412: "It was changed since the version that was quoted."}


def declared(handlers: Handlers) -> tuple[Route, ...]:
    """Return all of them."""
    groups = (_motor_routes, _motion_routes, _job_routes, _row_routes)
    return tuple(route for group in groups for route in group(handlers))


def _motor_routes(handlers: Handlers) -> Sequence[Route]:
    motor: dict[str, Any] = {
        "handle": handlers.motor,
        "summary": "List motors, read one, or move one",
        "description": "Without `id`: all. With `id`: that one. With `pos` as well: it moves (role operate).",
        "params": MotorParams,
        "within_s": MOVE_S,
        "replies": {200: MotorAnswer},
        "refuses": REFUSED,
        "lenient": True,
        "bare": True,
    }
    several: dict[str, Any] = {
        "handle": handlers.several,
        "summary": "Move several motors at once, or each after its delay",
        "description": "All of the list is looked at first: if anything is wrong with it, nothing moves.",
        "params": MultiParams,
        "within_s": MOVE_S,
        "body": MultiBody,
        "replies": {200: MultiAnswer},
        "refuses": REFUSED,
        "lenient": True,
        "bare": True,
        "role": "operate",
    }
    return (
        Route(
            method="GET",
            path="/",
            handle=ok,
            summary="Say that it is there",
            replies={200: web.TEXT},
            role=None,
            page=True,
        ),
        Route(method="GET", path="/motor", **motor),
        Route(method="GET", path="/multimotor", **several),
        Route(method="POST", path="/multimotor", **several),
    )


def _motion_routes(handlers: Handlers) -> Sequence[Route]:
    play: dict[str, Any] = {
        "handle": handlers.play,
        "summary": "Play a motion, by number or name",
        "description": "It plays by itself after the answer; one at a time. 99, pc_control, only takes the main "
        "board over.",
        "replies": {200: PlayedAnswer},
        "within_s": MOVE_S,
        "refuses": REFUSED,
        "bare": True,
        "role": "operate",
    }
    return (
        Route(
            method="GET",
            path="/motion",
            handle=handlers.motions,
            summary="List motions",
            replies={200: MotionsAnswer},
        ),
        Route(method="GET", path="/motion/{key}", **play),
        Route(method="POST", path="/motion/{key}", **play),
    )


def _job_routes(handlers: Handlers) -> Sequence[Route]:
    missing = {404: "there is no such job"}
    return (
        Route(method="GET", path="/jobs", handle=handlers.jobs, summary="List jobs", replies={200: JobsReply}),
        Route(
            method="GET",
            path="/jobs/{job}",
            handle=handlers.job,
            summary="Read a job",
            replies={200: JobReply},
            refuses=missing,
        ),
        Route(
            method="DELETE",
            path="/jobs/{job}",
            handle=handlers.cancel,
            summary="Cancel a job: what has not begun does not begin",
            replies={200: JobReply},
            refuses={**missing, 409: "it is over"},
            role="operate",
        ),
    )


def _row_routes(handlers: Handlers) -> Sequence[Route]:
    edit: dict[str, Any] = {"refuses": {**EDIT, **CHANGED}, "role": "admin", "within_s": EDIT_S}
    motor, motion = edit | {"replies": {200: MotorRowAnswer}}, edit | {"replies": {200: MotionRowAnswer}}
    missing = {404: "it is not there"}
    return (
        Route(
            method="GET",
            path="/motors/{id}",
            handle=handlers.show_motor,
            summary="Read a motor's row",
            replies={200: MotorRowAnswer},
            refuses=missing,
            within_s=EDIT_S,
        ),
        Route(
            method="POST",
            path="/motors",
            handle=handlers.add_motor,
            summary="Make a motor",
            body=NewMotorBody,
            **{**motor, "replies": {201: MotorRowAnswer}},
        ),
        Route(
            method="PUT",
            path="/motors/{id}",
            handle=handlers.change_motor,
            summary="Change a motor that is not built in",
            body=MotorBody,
            **motor,
        ),
        Route(
            method="GET",
            path="/motions/{id}",
            handle=handlers.show_motion,
            summary="Read a motion's row and its key frames; plays nothing",
            replies={200: MotionRowAnswer},
            refuses=missing,
            within_s=EDIT_S,
        ),
        Route(
            method="POST",
            path="/motions",
            handle=handlers.add_motion,
            summary="Make a motion of key frames",
            body=MotionBody,
            **{**motion, "replies": {201: MotionRowAnswer}},
        ),
        Route(
            method="PUT",
            path="/motions/{id}",
            handle=handlers.change_motion,
            summary="Change a motion that is not built in",
            body=MotionBody,
            **motion,
        ),
    )
