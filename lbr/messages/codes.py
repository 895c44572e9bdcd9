"""The codes of refusals, ends and losses: programs read the code, people read the sentence beside it.

A code never changes its meaning; new ones may be added. Messages carry codes as plain strings, so that an older program
reads a newer robot. A program treats an unknown code like `refused` or `failed`.
"""

from typing import Annotated, Literal

from msgspec import Meta, Struct

ReasonCode = Annotated[str, Meta(description="why, from the list of codes; empty: no reason")]
"""A code in messages."""

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
    "no_setpoint",
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
    "done": "done, or the goal was reached",
    "idle": "nothing is asked of it",
    "time_over": "the time asked for is over, as planned",
    "off_goal": "it ended as planned, but something is not in its place",
    "superseded": "the same sender asked for something else",
    "stopped": "a stop came, from a person or a program",
    "to_feet": "stopped, it goes on to its stance for 0.8 s at most; another stop holds it at once",
    "stopped_since": "another stop came after this was typed or written",
    "taken_over": "another sender took over",
    "lapsed": "the lease was not renewed, or the offer not confirmed, in time",
    "holder_gone": "the process or the person that held it is gone",
    "cancelled": "it was called off before its end",
    "shutting_down": "the process that would do it ends",
    "estop": "the emergency stop is latched; `reset` releases it",
    "held": "another sender holds it; a role may allow to take it over",
    "dead_lease": "the quoted lease is dead; the cause is how it ended, if known",
    "foreign_lease": "the quoted lease is another sender's, on another machine",
    "late": "it came too late, or its date makes no sense",
    "repeated": "it came twice, or after a newer one",
    "query_first": "another machine asks for a lease by a query first",
    "rest_first": "its sender sent on when it should not; it must pause or stop first",
    "clock": "the clock went back: dates mean nothing",
    "busy": "something else is under way, or too much waits; ask again later",
    "confirm": "it must be meant: repeat it, confirmed",
    "role": "the sender's role does not allow it",
    "rights": "the system denies it, such as a device file of another group",
    "token": "the sender's token is missing or invalid",
    "denied": "not from there, such as a foreign web page or an unlisted address",
    "bad_value": "a value is missing, misspelt or out of its bounds",
    "malformed": "the message cannot be read",
    "unknown_name": "there is nothing of this name",
    "unknown_command": "this is not understood there",
    "not_possible": "this robot or part cannot do that",
    "read_only": "built in or owned elsewhere, and not changed there",
    "changed": "it has changed since the quoted version",
    "exists": "the name or number exists already",
    "check": "a user's check refused it, or did not answer",
    "limit": "it exceeds a limit of the rows",
    "obstacle": "something is in the way, by sensors",
    "stale_sensor": "what must be known is not measured, too old, or not believed",
    "not_found": "the target was not seen",
    "lost": "the target is not seen any more",
    "fallen": "the robot has fallen, by its inertial unit",
    "stuck": "what was driven does not move",
    "not_followed": "what was driven does not follow",
    "not_armed": "the motors or servos are not armed",
    "no_setpoint": "no setpoint came in time, so the motors or servos stopped",
    "no_torque": "a joint has no torque",
    "off": "switched off by its row, the profile or a person",
    "latched": "a device has latched a fault; recover it",
    "not_ready": "it has just begun; ask again",
    "wiring": "a channel row is missing or surplus",
    "unreachable": "a process or device that it needs does not answer",
    "timeout": "it was not done or answered in time",
    "failed": "it went wrong; the sentence has the reason",
    "refused": "refused, for a reason without a code of its own",
}
"""The documented list: every code with its meaning."""


class Reason(Struct, frozen=True):
    """A reason: its code, the sentence for people, and the cause if there are two facts.

    `note` is the rest of the sentence by itself, for programs that pass it on. `holder` is the holder of the requested
    part.
    """

    code: Code
    text: str
    cause: str = ""
    note: str = ""
    holder: str = ""

    def __str__(self) -> str:
        return self.text


def heard(code: str, text: str, cause: str = "", note: str = "", holder: str = "") -> Reason:
    """Return a reason from a message's fields; an unknown or empty code becomes `failed`."""
    return Reason(code if code in MEANINGS else "failed", text, cause, note, holder)
