"""One motion of the base: asked for, renewed under its lease, and how it ended."""

from typing import Any

from lbr.apps.autodock.view import Ending
from lbr.apps.program import Robot
from lbr.bus import keys, wire
from lbr.bus.codec import Decoder
from lbr.errors import MalformedError
from lbr.messages.codes import Reason
from lbr.messages.drive import GoalResult
from lbr.messages.leases import CommandReply

TTL_S = 0.8
"""Slow motions, by a program that has to wait while the machine is busy."""
ANSWER_S = 1.0
RESULT_S = 0.5
MOST_ASKED = 4
FINAL = frozenset({"stopped", "taken_over", "superseded", "held", "estop", "role", "denied"})
"""Why a motion ends, or is refused, when somebody wants the robot to stand, or to go elsewhere."""

_replies = Decoder(CommandReply)


class Motion:
    """A command of the drive's, such as `turn`, with its fields. Whoever ceases to renew it lets it lapse."""

    def __init__(self, robot: Robot, command: str, fields: dict[str, Any], now: float) -> None:
        self.ending: Ending | None = None
        self._robot = robot
        self._key = keys.port(robot.name, "drive", command)
        self._began = self._answered = now
        self._lease = self._goal = ""
        self._refused: tuple[Reason, float] | None = None
        self._results: dict[str, GoalResult] = {}
        self._asked = [self._question(fields)]

    def renew(self, fields: dict[str, Any], now: float) -> None:
        """Go on, perhaps otherwise than before."""
        self._read(now)
        if self.ending is None and self._lease and self._refused is None and len(self._asked) < MOST_ASKED:
            self._asked.append(self._question(fields | {"lease": self._lease}))

    def hear(self, result: GoalResult) -> None:
        """Take a result, of whichever motion."""
        self._results[result.goal] = result

    def _question(self, fields: dict[str, Any]) -> wire.Question:
        payload = wire.encode(fields | {"ttl_s": TTL_S})
        return wire.Question(self._robot.bus, self._key, payload, timeout_s=ANSWER_S, source=self._robot.source)

    def _read(self, now: float) -> None:
        for question in [question for question in self._asked if question.done or question.replies]:
            self._asked.remove(question)
            for raw in question.replies:
                self._take(raw.payload, now)
        result = self._results.get(self._goal) if self._goal else None
        if result is not None:
            good = result.result in {"reached", "interval"}
            self.ending = Ending(
                good=good, text=result.reason or result.result, final=not good and result.code in FINAL
            )
        elif self._refused is not None and (not self._goal or now - self._refused[1] > RESULT_S):
            why = self._refused[0]
            self.ending = Ending(good=False, text=why.text, final=why.code in FINAL)
        elif not now - self._answered < ANSWER_S + TTL_S:
            self.ending = Ending(good=False, text="the drive does not answer", final=True)

    def _take(self, payload: bytes, now: float) -> None:
        try:
            reply = _replies.decode(payload)
        except MalformedError:
            return
        self._answered = now
        if not reply.accepted:
            self._refused = self._refused or (reply.why, now)
            return
        self._lease = reply.lease or self._lease
        self._goal = reply.goal or self._goal
