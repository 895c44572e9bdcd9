"""The faults of a trial, by name."""

from collections.abc import Mapping
from math import inf, pi

from msgspec import Struct
from msgspec.structs import replace

from lbr.simulation.settings import BoxSettings, WorldSettings

BOX = BoxSettings(name="box", x_m=-0.5, y_m=1.2, length_m=0.4, width_m=0.5)
"""Before the dock of the furnished room."""


class Faults(Struct, frozen=True, kw_only=True):
    """The faults of a trial; times are from its start.

    `dock` is the changed dock, None: it is gone; `box` also stands in the room. `deaf` are the beams that are invisible
    from `deaf_s` on. From `blind_s` on the ranges measure nothing, from `lost_s` on the attitude is silent. With `slip`
    the wheels turn up to so much farther than the robot goes. For a humanoid, a servo has no torque from `dead_s` on,
    and a push comes at `pushed_s`. Its motors have the share `strength` of their torque.
    """

    dock: Mapping[str, float] | None = {}
    box: BoxSettings | None = None
    deaf: frozenset[str] = frozenset()
    deaf_s: float = 0.0
    blind_s: float = inf
    lost_s: float = inf
    slip: float = 0.0
    dead_s: float = inf
    pushed_s: float = inf
    strength: float = 1.0

    def world(self, world: WorldSettings) -> WorldSettings:
        """Return the world with its faults."""
        if world.dock is not None:
            dock = None if self.dock is None else replace(world.dock, **self.dock)
            world = replace(world, dock=dock)
        return world if self.box is None else replace(world, walls=(*world.walls, self.box))


NONE = Faults()
DOCKING: dict[str, Faults] = {
    "dock gone": Faults(dock=None),
    "dock without power": Faults(deaf=frozenset({"left", "right", "power"}), dock={"current_a": 0.0}),
    "beams end on the way": Faults(deaf=frozenset({"left", "right"}), deaf_s=25.0),
    "dock blocked": Faults(box=BOX),
    "dock moved along its wall": Faults(dock={"y_m": -0.4}),
    "dock moved to another wall": Faults(dock={"x_m": 1.5, "y_m": -2.14, "yaw_rad": pi / 2}),
    "left beam dead": Faults(deaf=frozenset({"left"})),
    "right beam dead": Faults(deaf=frozenset({"right"})),
    "ranges dead on the way": Faults(blind_s=20.0),
    "attitude lost on the way": Faults(lost_s=20.0),
    "battery does not charge": Faults(dock={"current_a": 0.0}),
    "wheels slip": Faults(slip=0.3),
}
"""Faults of the dock, and of streams that any table reads. Those of the dock assume the furnished room."""
ANY: dict[str, Faults] = {
    name: DOCKING[name] for name in ("ranges dead on the way", "attitude lost on the way", "wheels slip")
}
"""Faults of streams that any table reads."""
BODY: dict[str, Faults] = {
    "attitude lost in a motion": Faults(lost_s=5.0),
    "a servo lets go": Faults(dead_s=6.0),
    "pushed": Faults(pushed_s=6.0),
    "motors weak": Faults(strength=0.6),
}
"""Faults of a humanoid."""
ON_WHEELS: Mapping[str, Faults] = {**DOCKING, **ANY}
EVERY: Mapping[str, Faults] = {**BODY, **ON_WHEELS}
