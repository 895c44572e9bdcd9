"""A robot's body as URDF, for RViz: its links, shapes and joints, below `base_link`. Pure."""

from collections.abc import Iterator, Sequence
from xml.sax.saxutils import quoteattr

from lbr.apps.bodies.parts import Link, RobotModel, Shape
from lbr.apps.ros2.conversion import BASE, moves, parent

LEAST_M = 0.001
FAST_RPS, STRONG = 1.0, 100.0
"""Values that URDF requires of every joint. No row has them, and no motion depends on them."""


def urdf(model: RobotModel) -> str:
    """Return the URDF of a body; of an unknown one, of its base alone."""
    lines = [f"<robot name={quoteattr(model.robot)}>"]
    if all(link.name != BASE for link in model.links):
        lines.append(f"  <link name={quoteattr(BASE)}/>")
    for link in model.links:
        lines += _link(link)
        if link.name != BASE:
            lines += _joint(link, model)
    return "\n".join([*lines, "</robot>"])


def _link(link: Link) -> Iterator[str]:
    shapes = [line for shape in link.shapes for line in _shape(shape)]
    yield f"  <link name={quoteattr(link.name)}{'>' if shapes else '/>'}"
    if shapes:
        yield from shapes
        yield "  </link>"


def _shape(shape: Shape) -> Iterator[str]:
    yield "    <visual>"
    yield f"      {_origin(shape.xyz, shape.rpy)}"
    yield f"      <geometry>{_geometry(shape)}</geometry>"
    yield f'      <material name=""><color rgba="{_numbers(shape.rgba)}"/></material>'
    yield "    </visual>"


def _geometry(shape: Shape) -> str:
    match shape.kind, shape.size:
        case "box", size:
            return f'<box size="{_numbers(size)}"/>'
        case "sphere", (radius, *_):
            return f'<sphere radius="{radius:g}"/>'
        case "cylinder" | "capsule", (radius, length, *_):
            return f'<cylinder radius="{radius:g}" length="{max(length, LEAST_M):g}"/>'
        case _, size:
            return f'<box size="{_numbers([2 * one for one in size])}"/>'


def _joint(link: Link, model: RobotModel) -> Iterator[str]:
    joint = model.joints.get(link.joint) if moves(link, model) else None
    kind = "fixed" if joint is None else "prismatic" if joint.kind == "slide" else "revolute"
    yield f'  <joint name={quoteattr(link.joint if joint is not None else f"{link.name}_seat")} type="{kind}">'
    yield f"    <parent link={quoteattr(parent(link, model))}/><child link={quoteattr(link.name)}/>"
    yield f"    {_origin(link.origin_xyz, link.origin_rpy)}"
    if joint is not None:
        lower, upper = joint.lower or 0.0, joint.upper or 0.0
        speed = joint.speed_rps or FAST_RPS
        yield f'    <axis xyz="{_numbers(link.axis)}"/>'
        yield f'    <limit lower="{lower:g}" upper="{upper:g}" effort="{STRONG:g}" velocity="{speed:g}"/>'
    yield "  </joint>"


def _origin(xyz: Sequence[float], rpy: Sequence[float]) -> str:
    return f'<origin xyz="{_numbers(xyz)}" rpy="{_numbers(rpy)}"/>'


def _numbers(values: Sequence[float]) -> str:
    return " ".join(f"{value:g}" for value in values)
