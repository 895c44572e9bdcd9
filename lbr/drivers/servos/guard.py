"""The servos' guard: holds their line too, and when the driver dies or hangs holds them still, then releases them
slowly."""

from collections.abc import Callable, Collection

from lbr.capability.reporter import final_report
from lbr.drivers import guard
from lbr.drivers.servos import ServosSettings

SPARE_S = 10.0
"""For servos that do not answer, read one after the other, and for a line that takes slowly what is written."""


class Guard(guard.Guard):
    """Kills a driver that is silent for too long while a servo has torque; see `guard_release` for what it does then.

    `program` is the module whose `main` calls `guard_release.run`, and `words` are what it is told beside all that
    every such program is told. `settling_s` is how much longer than holding and fading it may take.
    """

    def __init__(
        self,
        program: str,
        line: int,
        settings: ServosSettings,
        servos: Collection[int],
        clock: Callable[[], float],
        *,
        words: Collection[object] = (),
        settling_s: float = 0.0,
    ) -> None:
        silence_ms = settings.guard_silence_ms
        fd, last = final_report(
            "hung", f"the servo driver stood still for {silence_ms} ms while a servo had torque", "timeout"
        )

        def command(pipe: int, driver: int) -> list[str]:
            numbers = (line, pipe, driver, silence_ms, fd)
            ids = ",".join(map(str, servos))
            told = (last.hex() or "-", settings.hold_s, settings.release_s, ids, *words)
            return ["-m", program, *map(str, numbers), *map(str, told)]

        spare_s = settling_s + SPARE_S
        super().__init__(command, (line, fd), clock, settings.hold_s + settings.release_s + spare_s)
