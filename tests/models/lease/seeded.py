"""Errors that the model can have on purpose: each is the number it has there, and breaks one property."""

from dataclasses import dataclass

PROPERTIES = {
    1: "a motor turns only for a setpoint that is fresh, or until the controller's watchdog stops it",
    2: "a lease that died moves nothing any more",
    3: "after a stop or a pause nothing said before it moves the base",
    4: "one holds the base; another takes it only by saying so",
    5: "who falls silent stops moving the base within the bound",
    6: "after a restart nothing from before it moves the base",
    7: "nothing moves in an emergency stop, and its reset by itself moves nothing",
    8: "a command counts once",
}


@dataclass(frozen=True, slots=True)
class Seeded:
    """A seeded error. `world` is what it takes to see it: r(emote), t(aking), e(stop), c(rashes), i(nsisting)."""

    number: int
    name: str
    breaks: int
    world: str = "i"


SEEDED = (
    Seeded(1, "the drive extends a lapsed lease", 2),
    Seeded(2, "the drive accepts a replay", 8),
    Seeded(3, "a stop leaves the lease alive", 3),
    Seeded(4, "a stop forgets when it was", 3),
    Seeded(5, "the driver keeps the last setpoint", 1),
    Seeded(6, "the watchdog is fed with an old command", 1, "c"),
    Seeded(7, "the driver arms on a motion", 6, "ci"),
    Seeded(8, "the reset resumes what was held", 7, "ei"),
    Seeded(9, "a take-over leaves the old lease alive", 2, "ti"),
    Seeded(10, "a lease's name is given twice", 2),
    Seeded(11, "a command counts from its arrival", 3),
    Seeded(12, "who asks, takes", 4),
    Seeded(13, "who insists is not noticed", 7, "ei"),
    Seeded(14, "another machine is believed at once", 5, "rt"),
    Seeded(15, "a motion that a pause overtook counts", 3),
    Seeded(16, "a new drive knows of no stop", 6, "c"),
    Seeded(17, "setpoints may overtake each other", 3, ""),
    Seeded(18, "a zero from before arms a new driver", 6, "ci"),
)
