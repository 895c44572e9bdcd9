"""A table as an SVG picture: states in layers from the start down, conditions beside the arrows. Pure."""

from collections import deque
from collections.abc import Iterable, Iterator, Mapping
from html import escape
from typing import NamedTuple

from lbr.messages.behaviour import BehaviourRow, BehaviourTable

WIDE, HIGH, ACROSS, DOWN, EDGE = 170, 44, 90, 120, 40
LONGEST = 34
_STYLE = """
  .page { fill: #ffffff } .state { fill: #f4f6f8; stroke: #5b6b7b; stroke-width: 1.5 }
  .start { fill: #e3effc; stroke: #2b6cb0 } .end { fill: #e4f5e9; stroke: #2f855a }
  .fail { fill: #fce8e6; stroke: #c53030 }
  .way { fill: none; stroke: #7b8794; stroke-width: 1.4; marker-end: url(#tip) } .tip { fill: #7b8794 }
  text { font: 13px system-ui, sans-serif; fill: #1f2933; text-anchor: middle }
  .title { font-size: 17px; font-weight: 600; text-anchor: start }
  .said { font-size: 11px; fill: #52606d; paint-order: stroke; stroke: #ffffff; stroke-width: 4px }
  @media (prefers-color-scheme: dark) {
    .page { fill: #14181d } .state { fill: #222a33; stroke: #8b9aab } text { fill: #e4e7eb }
    .start { fill: #1d3450; stroke: #63a4e8 } .end { fill: #1b3a28; stroke: #68c08d }
    .fail { fill: #45211f; stroke: #f08c85 }
    .said { fill: #b6c2cf; stroke: #14181d }
  }
"""

_TIP = (
    '<defs><marker id="tip" viewBox="0 0 10 10" refX="9" refY="5" markerWidth="7" markerHeight="7" orient="auto">'
    '<path class="tip" d="M0 0 L10 5 L0 10 z"/></marker></defs>'
)


class _Place(NamedTuple):
    x: float
    y: float


def svg(table: BehaviourTable, rows: Iterable[BehaviourRow]) -> str:
    """Return the table's state graph as an SVG picture, for light and dark pages."""
    used = sorted((row for row in rows if row.type != "#" and row.state), key=lambda row: row.step)
    layers = _layers(used)
    width = max((len(layer) for layer in layers), default=1) * (WIDE + ACROSS) + 2 * EDGE + ACROSS
    height = len(layers) * (HIGH + DOWN) + 2 * EDGE
    places = {
        state: _Place(width / 2 + (number - (len(layer) - 1) / 2) * (WIDE + ACROSS), EDGE + 50 + depth * (HIGH + DOWN))
        for depth, layer in enumerate(layers)
        for number, state in enumerate(layer)
    }
    types = {row.state: row.type for row in reversed(used) if row.type in {"start", "end", "fail"}}
    parts = [*_ways(used, places, types), *_boxes(places, types)]
    title = escape(f"{table.name}: {table.help}" if table.help else table.name)
    return "\n".join(
        (
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:.0f} {height:.0f}" role="img">',
            f"<title>{title}</title><style>{_STYLE}</style>",
            _TIP,
            f'<rect class="page" width="{width:.0f}" height="{height:.0f}"/>',
            f'<text class="title" x="{EDGE}" y="{EDGE}">{title}</text>',
            *parts,
            "</svg>\n",
        )
    )


def _layers(rows: Iterable[BehaviourRow]) -> list[list[str]]:
    """Return the states in layers by their distance from the start; unreachable states come last."""
    rows = list(rows)
    order = list(dict.fromkeys(row.state for row in rows))
    start = next((row.state for row in rows if row.type == "start"), order[0] if order else "")
    depth, waiting = {start: 0} if start else {}, deque([start])
    while waiting:
        state = waiting.popleft()
        for row in rows:
            if row.state == state and row.next_state in order and row.next_state not in depth:
                depth[row.next_state] = depth[state] + 1
                waiting.append(row.next_state)
    last = max(depth.values(), default=0) + 1
    found: dict[int, list[str]] = {}
    for state in order:
        found.setdefault(depth.get(state, last), []).append(state)
    return [found[number] for number in sorted(found)]


def _ways(rows: Iterable[BehaviourRow], places: Mapping[str, _Place], types: Mapping[str, str]) -> Iterator[str]:
    drawn: dict[tuple[str, str], int] = {}
    for row in rows:
        if row.next_state not in places or types.get(row.state) in {"end", "fail"} or row.type == "entry":
            continue
        pair = row.state, row.next_state
        number = drawn[pair] = drawn.get(pair, -1) + 1
        yield _way(places[row.state], places[row.next_state], number, _label(row))


def _way(a: _Place, b: _Place, number: int, label: str) -> str:
    """Return an arrow: nearly straight to the next layer, in a bow elsewhere, as a loop to the same state."""
    half, bow = HIGH / 2, 26 + 30 * number
    if a == b:
        x, out = a.x + WIDE / 2, 34 + 16 * number
        path = (
            f"M{x:.0f} {a.y - 9:.0f} C{x + out:.0f} {a.y - 30:.0f} {x + out:.0f} {a.y + 30:.0f} {x:.0f} {a.y + 9:.0f}"
        )
        return _drawn(path, x + 30, a.y + 30 + 13 * number, label)
    if 0 < b.y - a.y <= HIGH + DOWN:
        shift = 22 * number
        begin, end, top, bottom = a.x + shift, b.x + shift, a.y + half, b.y - half
        path = f"M{begin:.0f} {top:.0f} C{begin:.0f} {top + 45:.0f} {end:.0f} {bottom - 45:.0f} {end:.0f} {bottom:.0f}"
        return _drawn(path, a.x + 0.42 * (b.x - a.x) + shift, a.y + half + 40 + 14 * number, label)
    side = 1 if b.x >= a.x else -1
    x1, x2 = a.x + side * WIDE / 2, b.x + side * WIDE / 2
    far = side * (max(side * x1, side * x2) + bow + 18)
    path = f"M{x1:.0f} {a.y:.0f} C{far:.0f} {a.y:.0f} {far:.0f} {b.y:.0f} {x2:.0f} {b.y:.0f}"
    return _drawn(path, 0.25 * (x1 + x2) + 0.5 * far, (a.y + b.y) / 2 + 13 * number, label)


def _drawn(path: str, x: float, y: float, said: str) -> str:
    text = f'<text class="said" x="{x:.0f}" y="{y:.0f}">{escape(said)}</text>' if said else ""
    return f'<path class="way" d="{path}"/>{text}'


def _boxes(places: Mapping[str, _Place], types: Mapping[str, str]) -> Iterator[str]:
    for state, at in places.items():
        kind = types.get(state, "")
        yield (
            f'<rect class="state {kind}" x="{at.x - WIDE / 2:.0f}" y="{at.y - HIGH / 2:.0f}" '
            f'width="{WIDE}" height="{HIGH}" rx="{22 if kind else 9}"/>'
            f'<text x="{at.x:.0f}" y="{at.y + 4:.0f}">{escape(_short(state, 24))}</text>'
        )


def _label(row: BehaviourRow) -> str:
    return _short(", ".join(f"{column} {text}" for column, text in row.conditions.items() if text.strip()), LONGEST)


def _short(text: str, most: int) -> str:
    return text if len(text) <= most else text[: most - 1] + "…"
