"""The servos' guard: holds their line too, and when the driver dies or hangs holds them still, then lets them go slowly."""

from collections.abc import Callable, Collection

from lbr.capability.reporter import last_words
from lbr.drivers import guard
from lbr.drivers.dynamixel import DynamixelSettings
from lbr.drivers.dynamixel.line import ServoLine

PROGRAM = "lbr.drivers.dynamixel.let_go"
SPARE_S = 10.0
"""For reading servos that do not answer, one after the other."""


class Guard(guard.Guard):
    """Kills a driver that is silent for too long while a servo has torque; see `let_go` for what it does then."""

    def __init__(
        self, line: ServoLine, settings: DynamixelSettings, servos: Collection[int], clock: Callable[[], float]
    ) -> None:
        silence_ms = settings.guard_silence_ms
        fd, words = last_words("hung", f"the servo driver stood still for {silence_ms} ms while a servo had torque")

        def command(pipe: int, driver: int) -> list[str]:
            numbers = (line.fileno(), pipe, driver, silence_ms, fd)
            times = (line.baud, line.margin_s, settings.hold_s, settings.release_s)
            words_or_none = words.hex() or "-"
            return ["-m", PROGRAM, *map(str, numbers), words_or_none, *map(str, times), *map(str, servos)]

        super().__init__(command, (line.fileno(), fd), clock, settings.hold_s + settings.release_s + SPARE_S)
