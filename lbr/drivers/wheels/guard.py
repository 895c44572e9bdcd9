"""The wheels' guard, on the same line: it writes the controller's stop the moment the driver dies or hangs."""

from collections.abc import Callable
from pathlib import Path

from lbr.capability.reporter import final_report
from lbr.drivers import guard
from lbr.drivers.wheels.contract import GuardStop

PROGRAM = Path(__file__).with_name("guard_stop.py")
LAST_WORD_S = 2.0
"""Several times the longest run of `guard_stop`: ten tries of 30 ms."""


class Guard(guard.Guard):
    """Kills a driver that is silent for `silence_ms` while a motor may turn, and writes the stop after its end."""

    def __init__(self, line: int, stop: GuardStop, silence_ms: int, clock: Callable[[], float]) -> None:
        fd, words = final_report(
            "hung", f"the motor driver stood still for {silence_ms} ms while a motor could turn", "timeout"
        )

        def command(pipe: int, driver: int) -> list[str]:
            numbers = [str(number) for number in (line, pipe, driver, silence_ms)]
            told = [stop.request.hex(), stop.acknowledged.hex() or "-"]
            said = [str(fd), words.hex()] if fd >= 0 else []
            return ["-I", "-S", str(PROGRAM), *numbers, *told, *said]

        super().__init__(command, (line, fd), clock, LAST_WORD_S)
