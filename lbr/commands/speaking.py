"""Commands that send lines to a robot."""

from collections.abc import Iterator
from contextlib import contextmanager

from lbr.console import target
from lbr.console.operator import LINE_TIMEOUT_S, BusOperator
from lbr.console.target import Target


@contextmanager
def speaking(robot: Target, program: str, *, answers_within_s: float = LINE_TIMEOUT_S) -> Iterator[BusOperator]:
    """Connect to a robot as an operator that sends lines, and receives only their results."""
    with target.connected(robot) as bus:
        speaker = BusOperator(
            bus,
            robot.robot,
            target.source(program),
            role=robot.role,
            proof=robot.proof,
            listen=False,
            answers_within_s=answers_within_s,
        )
        try:
            yield speaker
        finally:
            speaker.close()
