"""Things that are placed while the world runs: a few bodies wait below the floor for that."""

from math import cos, hypot, sin

from lbr.errors import InputError
from lbr.simulation.bindings import MjData, MjModel
from lbr.simulation.messages import WorldBox
from lbr.simulation.model import PARKED_M, PLACEABLE

_PARKED = ((0.0, 0.0, PARKED_M), (1.0, 0.0, 0.0, 0.0), (0.1, 0.1, 0.1))

Quad = tuple[float, float, float, float]
Triple = tuple[float, float, float]


class Placed:
    """The placed things, by name; any thread may ask, and `apply` places them between two steps of the physics."""

    def __init__(self, model: MjModel) -> None:
        self._things: dict[str, WorldBox] = {}
        self._slots: dict[str, str] = {}
        self.changed = False
        self._geoms = {slot: int(model.geom(slot).id) for slot in PLACEABLE}
        self._bodies = {slot: int(model.body(slot).id) for slot in PLACEABLE}

    @property
    def things(self) -> tuple[WorldBox, ...]:
        """Return the placed things."""
        return tuple(self._things.values())

    def place(self, box: WorldBox, robot: tuple[float, float, float]) -> None:
        """Place a thing, or move it if its name is known; `robot` is the robot's place, and its outline's radius."""
        x, y, radius_m = robot
        if box.name not in self._slots and len(self._slots) == len(PLACEABLE):
            there = ", ".join(sorted(self._things))
            raise InputError(f"{len(PLACEABLE)} things are placed already ({there}); remove one of them")
        if box.kind != "box":
            raise InputError(f"'{box.name}' is a {box.kind}; only boxes can be placed")
        if _gap_m(box, x, y) < radius_m:
            raise InputError(f"'{box.name}' would appear where the robot is ({x:.2f}, {y:.2f})")
        free = next((slot for slot in PLACEABLE if slot not in self._slots.values()), "")
        self._slots.setdefault(box.name, free)
        self._things[box.name] = box
        self.changed = True

    def remove(self, name: str) -> None:
        """Remove a thing."""
        if name not in self._slots:
            raise InputError(
                f"nothing called '{name}' was placed; there is: {', '.join(sorted(self._things)) or 'nothing'}"
            )
        del self._slots[name], self._things[name]
        self.changed = True

    def apply(self, model: MjModel, data: MjData) -> None:
        """Put everything at its place, if anything has changed."""
        if not self.changed:
            return
        self.changed = False
        taken = {slot: self._things[name] for name, slot in tuple(self._slots.items()) if name in self._things}
        for slot in PLACEABLE:
            position, turned, half = _set_up(taken[slot]) if slot in taken else _PARKED
            geom, body = self._geoms[slot], self._bodies[slot]
            mocap = model.body_mocapid[body]
            data.mocap_pos[mocap], data.mocap_quat[mocap] = position, turned
            resize(model, geom, body, half)


def resize(model: MjModel, geom: int, body: int, half: Triple) -> None:
    """Resize the only geom of a body, with all values that the physics derives from it."""
    model.geom_size[geom] = half
    model.geom_rbound[geom] = sum(value**2 for value in half) ** 0.5
    model.geom_aabb[geom] = model.bvh_aabb[model.body_bvhadr[body]] = (0.0, 0.0, 0.0, *half)


def _set_up(thing: WorldBox) -> tuple[Triple, Quad, Triple]:
    half = (thing.length_m / 2, thing.width_m / 2, thing.height_m / 2)
    turned = (cos(thing.yaw_rad / 2), 0.0, 0.0, sin(thing.yaw_rad / 2))
    return (thing.x_m, thing.y_m, thing.bottom_m + half[2]), turned, half


def _gap_m(box: WorldBox, x_m: float, y_m: float) -> float:
    """Return the distance of a point on the floor from a thing."""
    c, s = cos(box.yaw_rad), sin(box.yaw_rad)
    dx, dy = x_m - box.x_m, y_m - box.y_m
    ahead, aside = abs(dx * c + dy * s) - box.length_m / 2, abs(dy * c - dx * s) - box.width_m / 2
    return hypot(max(0.0, ahead), max(0.0, aside))
