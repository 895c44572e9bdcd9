"""Shows the wires between capabilities, from the rows: as a text tree, as a graph for `dot`, and as plain data."""

from collections.abc import Iterable, Mapping

import msgspec
from msgspec import Struct

from lbr.database.rows import RobotRows
from lbr.errors import MalformedError
from lbr.messages.system import Status


class Node(Struct, frozen=True, kw_only=True):
    """A capability of the graph; `state` is empty if the robot does not run."""

    name: str
    kind: str
    enabled: bool
    state: str = ""


class Edge(Struct, frozen=True, kw_only=True):
    """A wire between two ports; a verb's wire comes from the console."""

    source: str
    target: str
    enabled: bool = True
    rate_hz: float | None = None


class Graph(Struct, frozen=True, kw_only=True):
    """A robot's capabilities and wires."""

    robot: str
    nodes: tuple[Node, ...]
    edges: tuple[Edge, ...]


def graph(rows: RobotRows, states: Mapping[str, str], rates: Mapping[str, float]) -> Graph:
    """Return the graph of a robot's rows; states by capability and rates by `capability.output` if it runs."""
    words = sorted(
        {(f"console.{row.word}", row.target) for row in rows.verbs if not row.target.startswith("executive.")}
    )
    return Graph(
        robot=rows.robot.name,
        nodes=tuple(
            Node(name=row.name, kind=row.kind, enabled=row.enabled, state=states.get(row.name, ""))
            for row in rows.capabilities
        ),
        edges=(
            *(
                Edge(source=row.source, target=row.target, enabled=row.enabled, rate_hz=rates.get(row.source))
                for row in rows.channels
            ),
            *(Edge(source=source, target=target) for source, target in words),
        ),
    )


def running(status: Status) -> tuple[dict[str, str], dict[str, float]]:
    """Return the states and rates of a running robot for its graph."""
    states = {one.name: str(one.phase) for one in status.capabilities}
    return states, {f"{one.name}.{out}": hz for one in status.capabilities for out, hz in one.rates_hz.items()}


def tree(of: Graph) -> list[str]:
    """Return the graph as lines: under each capability its streams, with their receivers."""
    lines = [of.robot]
    names = [*(node.name for node in of.nodes), "console"]
    about = {node.name: f" ({node.kind}{_state(node)})" for node in of.nodes}
    for index, name in enumerate(names):
        last = index == len(names) - 1
        lines.append(f"{'`-' if last else '|-'} {name}{about.get(name, '')}")
        lines += _branches(of.edges, name, "   " if last else "|  ")
    return lines


def dot(of: Graph) -> list[str]:
    """Return the graph in the language of Graphviz."""
    lines = [f'digraph "{of.robot}" {{', "  rankdir=LR;", "  node [shape=box];"]
    lines += [f'  "{node.name}" [label="{node.name}\\n{node.kind}"];' for node in of.nodes]
    for edge in of.edges:
        (source, output), (target, port) = edge.source.split("."), edge.target.split(".")
        rate = f"\\n{edge.rate_hz:.0f} Hz" if edge.rate_hz is not None else ""
        style = "" if edge.enabled else ", style=dashed"
        lines.append(f'  "{source}" -> "{target}" [label="{output} > {port}{rate}"{style}];')
    return [*lines, "}"]


def from_plain(data: object) -> Graph:
    """Return the graph from plain data; raise MalformedError for other data."""
    try:
        return msgspec.convert(data, Graph)
    except msgspec.ValidationError as err:
        raise MalformedError(f"this is not a graph: {err}") from err


def _state(node: Node) -> str:
    return f", {node.state}" if node.state else "" if node.enabled else ", disabled"


def _branches(edges: Iterable[Edge], name: str, indent: str) -> list[str]:
    own = [edge for edge in edges if edge.source.split(".")[0] == name]
    width = max((len(edge.source.split(".")[1]) for edge in own), default=0)
    lines = []
    for index, edge in enumerate(own):
        rate = f"  {edge.rate_hz:.0f} Hz" if edge.rate_hz is not None else ""
        off = "" if edge.enabled else "  (off)"
        mark = "`-" if index == len(own) - 1 else "|-"
        lines.append(f"{indent}{mark} {edge.source.split('.')[1]:<{width}} -> {edge.target}{rate}{off}")
    return lines
