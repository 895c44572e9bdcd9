"""Why something was refused, ended or lost, as a code: programs read the code, people read the sentence beside it.

A code never changes its meaning; new ones are added. So that an older program reads a newer robot, messages carry codes
as plain strings, and a program treats one that it does not know like `refused` or `failed`.
"""

from typing import Annotated, Literal

from msgspec import Meta, Struct

ReasonCode = Annotated[str, Meta(description="why, from the list of codes; empty: nothing to tell")]
"""A code as messages carry it."""

Code = Literal[
    "done",
    "idle",
    "time_over",
    "off_goal",
    "superseded",
    "stopped",
    "to_feet",
    "stopped_since",
    "taken_over",
    "lapsed",
    "holder_gone",
    "cancelled",
    "shutting_down",
    "estop",
    "held",
    "dead_lease",
    "foreign_lease",
    "late",
    "repeated",
    "query_first",
    "rest_first",
    "clock",
    "busy",
    "confirm",
    "role",
    "rights",
    "token",
    "denied",
    "bad_value",
    "malformed",
    "unknown_name",
    "unknown_command",
    "not_possible",
    "read_only",
    "changed",
    "exists",
    "check",
    "limit",
    "obstacle",
    "stale_sensor",
    "not_found",
    "lost",
    "fallen",
    "stuck",
    "not_followed",
    "not_armed",
    "no_torque",
    "off",
    "latched",
    "not_ready",
    "wiring",
    "unreachable",
    "timeout",
    "failed",
    "refused",
]

MEANINGS: dict[Code, str] = {
    "done": "what was asked for is done, or the goal was reached",
    "idle": "nothing was asked of it yet, or nothing is now",
    "time_over": "the time that was asked for is over, as planned",
    "off_goal": "it came to its end as planned, but something is not where it was to be",
    "superseded": "the same sender asked for something else meanwhile",
    "stopped": "a stop came, from a person or a program",
    "to_feet": "it was stopped and goes on to where it stands, for 0.8 s at most; one more stop holds it at once",
    "stopped_since": "another stopped the robot after this was typed or written",
    "taken_over": "another sender took over",
    "lapsed": "the lease was not renewed, or an offer not confirmed, in time",
    "holder_gone": "the process or the person that held it is gone",
    "cancelled": "it was called off before it came to its end",
    "shutting_down": "the process that would do it ends",
    "estop": "the emergency stop is latched; `reset` releases it",
    "held": "another sender holds it; it may be taken over, rights permitting",
    "dead_lease": "the lease that was quoted is not live; the cause says how that one ended, if it was known here",
    "foreign_lease": "the lease that was quoted is another sender's, on another machine",
    "late": "it came too long after it was sent, or has no date that makes sense",
    "repeated": "it came twice, or after a newer one",
    "query_first": "a sender on another machine asks for a lease by a query first",
    "rest_first": "its sender went on sending when it should not have; it must pause or stop before it moves again",
    "clock": "the clock went back, so that no date means anything",
    "busy": "something else is under way there, or too much waits already; ask again later",
    "confirm": "it does something that must be meant: say it again, confirmed",
    "role": "the sender's role does not allow it",
    "rights": "the system does not let lbr have it, such as a device file of a group that its user is not in",
    "token": "the sender has to show a token, or the one that it showed counts for nothing",
    "denied": "it may not be asked for from there, such as a foreign web page or an address that is not listed",
    "bad_value": "a value is missing, misspelt or out of its bounds",
    "malformed": "the message cannot be read",
    "unknown_name": "there is nothing of this name",
    "unknown_command": "this is not understood there",
    "not_possible": "this robot, or this part of it, cannot do that as it is",
    "read_only": "it is built in or belongs elsewhere, and is not to be changed there",
    "changed": "it has changed since the version that was quoted",
    "exists": "there is one of this name or number already",
    "check": "a check of the user's own said no, or did not answer",
    "limit": "it would go beyond a limit that the rows set",
    "obstacle": "something is in the way, by what sensors see or saw",
    "stale_sensor": "what would have to be known is not measured, too old, or cannot be believed",
    "not_found": "what was looked for was not seen anywhere",
    "lost": "what was followed is not seen any more",
    "fallen": "the robot has fallen, by what its inertial unit says",
    "stuck": "what was driven does not move",
    "not_followed": "what was driven does not do as it is told",
    "not_armed": "the motors or servos are not armed",
    "no_torque": "a joint has no torque",
    "off": "it is switched off, by its row, the launch profile or a person, and waits to be switched on",
    "latched": "a device has latched a fault and waits to be recovered",
    "not_ready": "it has just begun and does not know enough yet; ask again",
    "wiring": "a channel row is missing, or there is one too many",
    "unreachable": "a process or a device that it needs is gone or does not answer",
    "timeout": "it was not done or answered in time",
    "failed": "it was tried and went wrong; the sentence says how",
    "refused": "it was refused for a reason that has no code of its own",
}
"""The documented list: every code, and what it means."""


class Reason(Struct, frozen=True):
    """A reason: its code, the sentence for people, and the cause where two things are told.

    `note` is the rest of the sentence by itself, for programs that pass it on. `holder` has what is held.
    """

    code: Code
    text: str
    cause: str = ""
    note: str = ""
    holder: str = ""

    def __str__(self) -> str:
        return self.text


def heard(code: str, text: str, cause: str = "", note: str = "", holder: str = "") -> Reason:
    """Return a reason as a message told it; a code that is not on the list, or none, is `failed`."""
    return Reason(code if code in MEANINGS else "failed", text, cause, note, holder)
