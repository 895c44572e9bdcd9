"""The motors' guard: holds their line too, and writes zero the moment the driver dies or hangs."""

from collections.abc import Callable
from pathlib import Path

from lbr.capability.reporter import last_words
from lbr.drivers import guard
from lbr.drivers.roboteq.protocol import STOP

PROGRAM = Path(__file__).with_name("zero_on_death.py")
LAST_WORD_S = 2.0
"""Several times what `zero_on_death` takes at most: ten tries of 30 ms."""


class Guard(guard.Guard):
    """Kills a driver that is silent for `silence_ms` while a motor may turn, and writes zero after its end."""

    def __init__(self, tty: int, silence_ms: int, clock: Callable[[], float]) -> None:
        fd, words = last_words("hung", f"the motor driver stood still for {silence_ms} ms while a motor could turn")

        def command(pipe: int, driver: int) -> list[str]:
            numbers = [str(number) for number in (tty, pipe, driver, silence_ms)]
            said = [str(fd), words.hex()] if fd >= 0 else []
            return ["-I", "-S", str(PROGRAM), *numbers, STOP.hex(), *said]

        super().__init__(command, (tty, fd), clock, LAST_WORD_S)
