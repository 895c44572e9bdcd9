"""The nodes, publishers and subscribers in ROS, by their liveliness tokens. Pure."""

from collections.abc import Collection, Iterable, Mapping

from lbr.apps.ros2 import wire
from lbr.apps.ros2.wire import Endpoint, Node
from lbr.errors import InputError

MOST = 2000
"""The most entities; further ones are ignored."""


class Graph:
    """All other entities, by their tokens."""

    def __init__(self) -> None:
        self._entities: dict[str, Node | Endpoint] = {}
        self._gids: set[bytes] = set()
        self._named: dict[bytes, Endpoint] = {}
        self._subscribed: frozenset[tuple[str, str]] | None = None

    def come(self, token: str) -> Endpoint | Node | None:
        """Add an entity; return it if it is new."""
        try:
            entity = wire.token(token)
        except InputError:
            return None
        if entity is None or token in self._entities or len(self._entities) >= MOST:
            return None
        self._entities[token] = entity
        self._subscribed = None
        if isinstance(entity, Endpoint):
            self._gids.add(gid := wire.gid(token))
            self._named[gid] = entity
            if len(self._named) > 2 * MOST:
                self._named.pop(next(iter(self._named)))
        return entity

    def go(self, token: str) -> Endpoint | Node | None:
        """Remove an entity; return it if it was known."""
        self._subscribed = None
        self._gids.discard(wire.gid(token))
        return self._entities.pop(token, None)

    def clear(self) -> None:
        """Forget all, as the router is gone."""
        self._entities.clear()
        self._gids.clear()
        self._subscribed = None

    @property
    def nodes(self) -> int:
        """Return the number of nodes."""
        return sum(isinstance(one, Node) for one in self._entities.values())

    def subscribed(self, topic: str, type_: str) -> bool:
        """Return whether a topic has a subscriber of its type."""
        if self._subscribed is None:
            self._subscribed = frozenset((one.topic, one.type) for one in self._of("MS"))
        return (topic, type_) in self._subscribed

    def name(self, gid: bytes) -> str:
        """Return the node of an endpoint, for people; even of one that is gone."""
        return found.node.path if (found := self._named.get(gid)) is not None else "somebody without a token"

    def place(self, gid: bytes) -> str:
        """Return the topic of an endpoint, for people, to follow its node."""
        return f" on {found.topic}" if (found := self._named.get(gid)) is not None else ""

    def knows(self, gid: bytes) -> bool:
        """Return whether an endpoint has a token."""
        return gid in self._gids

    def _of(self, kind: str) -> Iterable[Endpoint]:
        return (one for one in self._entities.values() if isinstance(one, Endpoint) and one.kind == kind)


def refusal_of(endpoint: Endpoint, accepted: Mapping[str, Mapping[str, Collection[str]]]) -> str:
    """Return why the messages of an endpoint are refused; empty if they are not, or its topic is not received.

    `accepted` are the topics with their types and those types' hashes.
    """
    if endpoint.kind != "MP" or endpoint.topic not in accepted:
        return ""
    types = accepted[endpoint.topic]
    if endpoint.type not in types:
        names = " and ".join(one.rpartition("/")[2] for one in types)
        kind = endpoint.type.rpartition("/")[2]
        return f"{endpoint.node.path} publishes {kind} on {endpoint.topic}, which takes {names}"
    if endpoint.hash not in types[endpoint.type]:
        return (
            f"{endpoint.node.path} publishes another {endpoint.type} on {endpoint.topic}: its hash is {endpoint.hash}"
        )
    return ""
