"""Reads a body from a MuJoCo description (MJCF), without MuJoCo: bodies, joints, simple shapes, cameras, sites.

Everything else is left out, meshes too; `Body.left_out` lists it. Links without shapes are added if a body has several
joints, or one whose axis is off its origin.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from math import isfinite, pi
from pathlib import Path
from xml.etree import ElementTree as ET

from msgspec.structs import replace

from lbr.apps.bodies.parts import GREY, ORIGIN, Body, JointKind, Link, Rgba, Sensor, Shape, ShapeKind, Xyz
from lbr.apps.bodies.turning import NO_TURN, Place, about, by_axes, by_euler, by_z, product, rpy, unit
from lbr.errors import InputError

SHOWN_GROUPS = 3
"""Viewers show the shapes of groups 0 to 2; groups from 3 on are for collisions only."""
_SIZES: dict[ShapeKind, int] = {"sphere": 1, "capsule": 2, "cylinder": 2, "box": 3, "ellipsoid": 3}
_JOINTS: dict[str, JointKind] = {"hinge": "hinge", "slide": "slide"}
_LOOKING = by_axes((0.0, 0.0, -1.0), (-1.0, 0.0, 0.0))
"""A camera looks along its -z with x to the right; a `Sensor` along its x with y to the left."""

Attributes = Mapping[str, str]


def read(path: Path) -> Body:
    """Read the body in a file; raise InputError with its fault."""
    try:
        text = path.read_text(encoding="utf-8")
        return parse(text)
    except (OSError, UnicodeDecodeError, InputError) as err:
        raise InputError(f"body {path}: {err}") from err


def parse(text: str) -> Body:
    """Parse the body in a description; raise InputError with its fault."""
    try:
        root = ET.fromstring(text)  # noqa: S314 - a file of the robot's owner
    except ET.ParseError as err:
        raise InputError(f"it is no XML: {err}") from err
    world = root.find("worldbody")
    if root.tag != "mujoco" or world is None:
        raise InputError("it is no MJCF: it needs <mujoco> with a <worldbody>")
    try:
        return _Reader(root).body(world)
    except (ValueError, RecursionError) as err:
        raise InputError(f"it cannot be read: {err or type(err).__name__}") from err


@dataclass
class _Parts:
    """The parts found so far."""

    links: list[Link] = field(default_factory=list)
    joints: dict[str, JointKind] = field(default_factory=dict)
    sensors: list[Sensor] = field(default_factory=list)
    left_out: dict[str, int] = field(default_factory=dict)


class _Reader:
    """One description: its angles, defaults and materials, and the parts of its body."""

    def __init__(self, root: ET.Element) -> None:
        compiler: dict[str, str] = {}
        for element in root.findall("compiler"):
            compiler |= element.attrib
        self._radians = 1.0 if compiler.get("angle", "degree") == "radian" else pi / 180
        self._order = compiler.get("eulerseq", "xyz")
        self._defaults: dict[str, dict[str, dict[str, str]]] = {"": {}, "main": {}}
        for element in root.findall("default"):
            self._read_defaults(element, {}, top=True)
        self._materials = {
            material.attrib["name"]: material.attrib.get("rgba", "1 1 1 1")
            for material in root.iterfind("asset/material")
            if "name" in material.attrib
        }
        self._parts = _Parts()

    def body(self, world: ET.Element) -> Body:
        """Return the body of a world's elements."""
        shapes = self._shapes(world, "", Place())
        if shapes:
            self._parts.links.append(Link(name="world", shapes=shapes))
        self._children(world, "world" if shapes else "", "", Place())
        parts = self._parts
        return Body(
            links=tuple(parts.links),
            joints=parts.joints,
            sensors=tuple(parts.sensors),
            left_out=tuple(f"{count} {what}" for what, count in parts.left_out.items()),
        )

    def _children(self, element: ET.Element, parent: str, style: str, at: Place) -> None:
        """Read the bodies in an element whose frame is at `at` in that of the link `parent`."""
        for child in element:
            if child.tag == "body":
                self._body(child, parent, child.attrib.get("childclass", style), at.then(self._place(child.attrib)))
            elif child.tag == "frame":
                inner = at.then(self._place(child.attrib))
                self._children(child, parent, child.attrib.get("childclass", style), inner)
            elif child.tag in {"include", "attach", "replicate", "composite", "flexcomp"}:
                self._leave_out(f"<{child.tag}>")

    def _body(self, element: ET.Element, parent: str, style: str, at: Place) -> None:
        name = element.attrib.get("name") or f"body {len(self._parts.links)}"
        joints, whole = list(self._joints(element, style)), False
        for number, joint in enumerate(joints, 1):
            anchor = _xyz(joint, "pos")
            whole = number == len(joints) and anchor == ORIGIN
            link = name if whole else f"{name}/{joint.get('name') or number}"
            shapes = self._shapes(element, style, Place()) if whole else ()
            self._moved(joint, Link(name=link, parent=parent, shapes=shapes), at.then(Place(anchor)))
            parent, at = link, Place((-anchor[0], -anchor[1], -anchor[2]))
        if not whole:
            self._add(Link(name=name, parent=parent, shapes=self._shapes(element, style, Place())), at)
        self._sensors(element, name, style, Place())
        self._children(element, name, style, Place())

    def _moved(self, joint: Attributes, link: Link, at: Place) -> None:
        """Add a link that a joint moves."""
        kind, name = _JOINTS[joint.get("type", "hinge")], joint.get("name", "")
        x, y, z = unit(_xyz(joint, "axis", (0.0, 0.0, 1.0)))
        rest = float(joint.get("ref", "0"))
        if kind == "hinge":
            at = at.then(Place(turn=about((x, y, z), -rest * self._radians)))
        else:
            at = at.then(Place((-rest * x, -rest * y, -rest * z)))
        if name:
            self._parts.joints[name] = kind
        self._add(replace(link, joint=name, axis=(x, y, z)), at)

    def _add(self, link: Link, at: Place) -> None:
        self._parts.links.append(replace(link, origin_xyz=at.xyz, origin_rpy=rpy(at.turn)))

    def _joints(self, element: ET.Element, style: str) -> Iterator[Attributes]:
        for child in element.findall("joint"):
            joint = self._with_defaults(child, style)
            if joint.get("type", "hinge") in _JOINTS:
                yield joint
            elif joint["type"] != "free":
                self._leave_out(f"joint of type {joint['type']}")

    def _shapes(self, element: ET.Element, style: str, at: Place) -> tuple[Shape, ...]:
        shapes: list[Shape] = []
        for child in element:
            if child.tag == "geom":
                shape = self._shape(self._with_defaults(child, style), at)
                shapes += [shape] if shape is not None else []
            elif child.tag == "frame":
                inner = at.then(self._place(child.attrib))
                shapes += self._shapes(child, child.attrib.get("childclass", style), inner)
        return tuple(shapes)

    def _shape(self, geom: Attributes, at: Place) -> Shape | None:
        kind = geom.get("type", "mesh" if "mesh" in geom else "sphere")
        colour = self._colour(geom)
        if int(geom.get("group", "0")) >= SHOWN_GROUPS or colour[3] == 0.0:
            return None
        if kind not in _SIZES:
            self._leave_out(f"shape of type {kind}")
            return None
        place, half = self._place(geom), _numbers(geom.get("size", ""))
        if "fromto" in geom:
            place, half = _between(kind, _numbers(geom["fromto"]), half)
        if len(half) < _SIZES[kind] or min(half[: _SIZES[kind]]) < 0.0:
            raise ValueError(f"a {kind} needs {_SIZES[kind]} sizes, and has '{geom.get('size', '')}'")
        place = at.then(place)
        return Shape(kind=kind, size=_full(kind, half), xyz=place.xyz, rpy=rpy(place.turn), rgba=colour)

    def _colour(self, geom: Attributes) -> Rgba:
        given = geom.get("rgba") or self._materials.get(geom.get("material", ""), "")
        values = _numbers(given)
        return (values[0], values[1], values[2], values[3]) if len(values) == 4 else GREY

    def _sensors(self, element: ET.Element, link: str, style: str, at: Place) -> None:
        for child in element:
            if child.tag == "frame":
                self._sensors(child, link, child.attrib.get("childclass", style), at.then(self._place(child.attrib)))
            name = child.attrib.get("name", "")
            if child.tag not in {"camera", "site"} or not name:
                continue
            given = self._with_defaults(child, style)
            place = at.then(self._place(given))
            if child.tag == "camera":
                turn, fov = product(place.turn, _LOOKING), float(given.get("fovy", "45")) * pi / 180
                self._parts.sensors.append(
                    Sensor(name=name, kind="camera", link=link, xyz=place.xyz, rpy=rpy(turn), fov_rad=fov)
                )
            else:
                kind = "imu" if name == "imu" else "site"
                self._parts.sensors.append(Sensor(name=name, kind=kind, link=link, xyz=place.xyz, rpy=rpy(place.turn)))

    def _place(self, given: Attributes) -> Place:
        return Place(_xyz(given, "pos"), self._turn(given))

    def _turn(self, given: Attributes) -> tuple[float, float, float, float]:
        if "quat" in given:
            w, x, y, z = unit(_numbers(given["quat"]))
            return w, x, y, z
        if "euler" in given:
            return by_euler([angle * self._radians for angle in _numbers(given["euler"])], self._order)
        if "axisangle" in given:
            *axis, angle = _numbers(given["axisangle"])
            return about(axis, angle * self._radians)
        if "xyaxes" in given:
            six = _numbers(given["xyaxes"])
            return by_axes(six[:3], six[3:])
        return by_z(_numbers(given["zaxis"])) if "zaxis" in given else NO_TURN

    def _with_defaults(self, element: ET.Element, style: str) -> dict[str, str]:
        name = element.attrib.get("class", style)
        if name not in self._defaults:
            raise ValueError(f"there is no default class '{name}'")
        return {**self._defaults[name].get(element.tag, {}), **element.attrib}

    def _read_defaults(self, element: ET.Element, outer: Mapping[str, dict[str, str]], *, top: bool = False) -> None:
        own = {tag: dict(values) for tag, values in outer.items()}
        for child in element:
            if child.tag != "default":
                own[child.tag] = {**own.get(child.tag, {}), **child.attrib}
        self._defaults[element.attrib.get("class", "main")] = own
        if top:
            self._defaults[""] = own
        for child in element.findall("default"):
            self._read_defaults(child, own)

    def _leave_out(self, what: str) -> None:
        self._parts.left_out[what] = self._parts.left_out.get(what, 0) + 1


def _between(kind: ShapeKind, ends: list[float], size: list[float]) -> tuple[Place, list[float]]:
    """Return the place and half sizes of a shape that reaches from one point to another."""
    if len(ends) != 6 or not size:
        raise ValueError("fromto needs six numbers, and size one")
    start, end = ends[:3], ends[3:]
    along = [a - b for a, b in zip(start, end, strict=True)]
    half = sum(value * value for value in along) ** 0.5 / 2
    x, y, z = ((a + b) / 2 for a, b in zip(start, end, strict=True))
    return Place((x, y, z), by_z(along)), [size[0], size[0], half] if kind in {"box", "ellipsoid"} else [size[0], half]


def _full(kind: ShapeKind, half: list[float]) -> tuple[float, ...]:
    """Convert MuJoCo's half sizes to a size of `Shape`."""
    if kind == "box":
        return 2 * half[0], 2 * half[1], 2 * half[2]
    if kind in {"cylinder", "capsule"}:
        return half[0], 2 * half[1]
    return tuple(half[: _SIZES[kind]])


def _xyz(given: Attributes, name: str, otherwise: Xyz = ORIGIN) -> Xyz:
    if name not in given:
        return otherwise
    x, y, z = _numbers(given[name])
    return x, y, z


def _numbers(text: str) -> list[float]:
    values = [float(word) for word in text.split()]
    if not all(map(isfinite, values)):
        raise ValueError(f"'{text}' is not finite")
    return values
