"""The servos' guard, on the same line: when the driver dies or hangs it holds the servos, then releases them slowly."""

from collections.abc import Callable, Collection

from lbr.capability.reporter import final_report
from lbr.drivers import guard
from lbr.drivers.servos import ServosSettings

SPARE_S = 10.0
"""The allowance for servos that do not answer, read one after the other, and for a slow line."""


class Guard(guard.Guard):
    """Kills a driver that is silent for too long while a servo has torque; then `guard_release` acts.

    `program` is the module that calls `guard_release.run`, and `words` are its arguments beyond those of every such
    program. `settling_s` is its allowance beyond holding and fading.
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
