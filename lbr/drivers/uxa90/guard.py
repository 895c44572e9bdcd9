"""The guard of a UXA-90: holds its line too, and when the driver dies or hangs lets the servos hold, brake, then let go."""

from collections.abc import Callable, Collection

from lbr.capability.reporter import last_words
from lbr.drivers import guard
from lbr.drivers.uxa90 import Uxa90Settings
from lbr.drivers.wire import Wire

PROGRAM = "lbr.drivers.uxa90.let_go"
SPARE_S = 10.0
"""For a line that takes what is written slowly."""


class Guard(guard.Guard):
    """Kills a driver that is silent for too long while a servo has torque; see `let_go` for what it does then."""

    def __init__(
        self, line: Wire, settings: Uxa90Settings, servos: Collection[int], clock: Callable[[], float]
    ) -> None:
        silence_ms = settings.guard_silence_ms
        fd, words = last_words("hung", f"the servo driver stood still for {silence_ms} ms while a servo had torque")

        def command(pipe: int, driver: int) -> list[str]:
            numbers = (line.fileno(), pipe, driver, silence_ms, fd)
            times = (settings.hold_s, settings.release_s, settings.settle_s)
            return ["-m", PROGRAM, *map(str, numbers), words.hex() or "-", *map(str, times), *map(str, servos)]

        last_word_s = settings.hold_s + 2.0 * settings.settle_s + settings.release_s + SPARE_S
        super().__init__(command, (line.fileno(), fd), clock, last_word_s)
