"""The inputs and requests of a face beyond the server's own. Light to import, as rows are checked by it.

A package declares them in a module of its own, and its component names that in `ports`, beside its face:

    PORTS = FacePorts(inputs={"gripper": GripperState}, states=("gripper",), requests={"grip": GripCommand})
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from msgspec import Struct

from lbr import plugins
from lbr.messages.rows import Row
from lbr.plugins import PluginError

OF_STATE = {"robot", "age_s", "faces"}
"""The fields of `/state` that are not inputs."""


@dataclass(frozen=True, kw_only=True, slots=True)
class FacePorts:
    """Ports that a package adds to the kind `web` while it is installed.

    - `states`: the inputs whose newest value is in `/state`, under its name. Each input is optional.
    - `replies`: the types of answers; without one it is a CommandReply.
    - `edits`: the tables whose rows the request `edit` may write.
    """

    inputs: Mapping[str, type[Struct]] = field(default_factory=dict)
    states: tuple[str, ...] = ()
    requests: Mapping[str, type[Struct]] = field(default_factory=dict)
    replies: Mapping[str, type[Struct]] = field(default_factory=dict)
    rows: tuple[type[Row], ...] = ()
    edits: tuple[type[Row], ...] = ()


def with_faces(own: FacePorts) -> tuple[FacePorts, tuple[str, ...]]:
    """Return the server's own ports with those of installed faces, and a sentence for each refused one."""
    ports, refused = own, []
    for name in sorted(plugins.installed("ports")):
        try:
            ports = _with(ports, name)
        except PluginError as err:
            refused.append(str(err))
    return ports, tuple(refused)


def _with(ports: FacePorts, name: str) -> FacePorts:
    plugin = plugins.installed("ports")[name]
    more = plugin.load()
    if not isinstance(more, FacePorts):
        raise PluginError(plugin, f"{plugin.value} is no FacePorts(…)")
    if why := next(_contradictions(ports, more), None):
        raise PluginError(plugin, why)
    return FacePorts(
        inputs={**ports.inputs, **more.inputs},
        states=tuple(dict.fromkeys((*ports.states, *more.states))),
        requests={**ports.requests, **more.requests},
        replies={**ports.replies, **more.replies},
        rows=tuple(dict.fromkeys((*ports.rows, *more.rows))),
        edits=tuple(dict.fromkeys((*ports.edits, *more.edits))),
    )


def _contradictions(ports: FacePorts, more: FacePorts) -> Iterator[str]:
    """Yield the conflicts of new ports with the present ones: a name stands for one message."""
    for of, known, added in (
        ("input", ports.inputs, more.inputs),
        ("request", ports.requests, more.requests),
        ("reply", ports.replies, more.replies),
    ):
        for name, message in added.items():
            if not name.isidentifier():
                yield f"{of} '{name}' is not a name: those are of letters, digits and _"
            if known.get(name, message) is not message:
                yield f"{of} '{name}' is {message.__name__}, and there is one already, of {known[name].__name__}"
    yield from _missing(ports, more)
    tables = {row.TABLE: row for row in ports.rows}
    for row in more.rows:
        if tables.get(row.TABLE, row) is not row:
            yield f"rows: table '{row.TABLE}' is read as {tables[row.TABLE].__name__} already"


def _missing(ports: FacePorts, more: FacePorts) -> Iterator[str]:
    """Yield the names in ports that do not exist."""
    if taken := [name for name in more.states if name in OF_STATE]:
        yield f"states: '{taken[0]}' is a field of `/state` itself; choose another name"
    if lost := [name for name in more.states if name not in more.inputs and name not in ports.inputs]:
        yield f"states: there is no input '{lost[0]}'"
    if lost := [name for name in more.replies if name not in more.requests and name not in ports.requests]:
        yield f"replies: there is no request '{lost[0]}'"
