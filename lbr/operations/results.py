"""The results of goals that end with their leases."""

from lbr.leases.lease import Ended, M, Result
from lbr.messages.drive import GoalResult


def goal_result(ended: Ended[M], goal: str, began: float, now: float) -> Result:
    """Return the result of a goal that ended with its lease."""
    why = ended.why
    return Result(
        message=GoalResult(
            goal=goal,
            result=ended.how,
            reason=why.text,
            code=why.code,
            cause=why.cause,
            note=why.note,
            elapsed_s=round(max(0.0, now - began), 3),
        )
    )
