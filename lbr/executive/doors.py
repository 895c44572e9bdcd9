"""The routers of a robot: the core that its processes meet at, and the doors to it.

    process (user, password) ──► core ◄── annex: opened later, for processes whose rights the core does not know
    anybody at the socket ─────► local door ─┘

What a router allows is fixed when it opens, and to open the core anew would cut off everything that moves. So a
process that an edit has given other rights gets an annex: a router that knows its rights, hung on the core for as
long as the robot runs. `lbr/executive/rights.py` says who may do what.
"""

from collections.abc import Iterable, Mapping
from contextlib import ExitStack
from typing import NamedTuple

from lbr import home
from lbr.bus import session
from lbr.bus.access import TOOLS, Credentials, Rights
from lbr.executive import rights
from lbr.executive.plan import Plan
from lbr.executive.site import Site
from lbr.executive.units import Unit

EXECUTIVE, ANNEX = "@executive", "@annex"
CORE = "core"
TRUSTED = Rights(trusted=True)


def local_endpoint(robot: str) -> str:
    """Return where anybody on this machine who may read the home comes in."""
    return f"unixsock-stream/{home.socket_path(robot)}"


def core_endpoint(robot: str) -> str:
    """Return where the robot's own processes come in."""
    return f"unixsock-stream/{home.socket_path(robot, '.core')}"


def inside_endpoint(robot: str, name: str) -> str:
    """Return where the relay of a door to other machines comes in at it."""
    return f"unixsock-stream/{home.socket_path(robot, f'.{name}')}"


class Place(NamedTuple):
    """A router that a process comes in at."""

    endpoint: str
    router_id: str


class Doors:
    """Opens core and local door; `place` says where a process comes in. Raises BusError if a socket is taken."""

    def __init__(self, plan: Plan, site: Site) -> None:
        self._robot = plan.robot
        self._site = site
        self._stack = ExitStack()
        self._known: dict[str, list[tuple[Place, dict[str, Rights]]]] = {}
        self._annexes = 0
        core = {name: rights.of_unit(plan, unit) for name, unit in plan.here.items()}
        local = site.router_id("local")
        self._core = Place(core_endpoint(self._robot), site.router_id(CORE))
        self._open(session.Router(listen=(local_endpoint(self._robot),), id=local, lease_ms=session.HELD_MS))
        self._open_for(
            self._core,
            {EXECUTIVE: TRUSTED, TOOLS: TRUSTED, ANNEX: TRUSTED} | _merged(core.values()),
            links={local: rights.of_local(plan)},
            connect=(local_endpoint(self._robot),),
            looked_at=rights.looked_at(plan),
        )
        self._known |= {name: [(self._core, users)] for name, users in core.items()}

    def credentials(self, user: str) -> Credentials:
        """Return how a user proves itself, the same for the whole run."""
        return self._site.credentials(user)

    def place(self, plan: Plan, unit: Unit) -> Place:
        """Return where a process has its rights; opens an annex if no router knows them."""
        wanted = rights.of_unit(plan, unit)
        places = self._known.setdefault(unit.name, [])
        where = next((place for place, known in places if known == wanted), None)
        if where is None:
            self._annexes += 1
            socket = home.socket_path(self._robot, f".{self._annexes}")
            where = Place(f"unixsock-stream/{socket}", self._site.router_id(f"annex {self._annexes}"))
            self._open_for(
                where,
                wanted,
                links={self._core.router_id: TRUSTED},
                connect=(self._core.endpoint,),
                looked_at=rights.looked_at(plan),
                credentials=self.credentials(ANNEX),
            )
            places.append((where, wanted))
        return where

    def close(self) -> None:
        """Close every router, the newest first."""
        self._stack.close()

    def _open_for(
        self,
        place: Place,
        users: Mapping[str, Rights],
        *,
        links: Mapping[str, Rights],
        connect: tuple[str, ...],
        looked_at: tuple[str, ...],
        credentials: Credentials | None = None,
    ) -> None:
        self._open(
            session.Router(
                listen=(place.endpoint,),
                robot=self._robot,
                users={user: self.credentials(user).password for user in users},
                rights=dict(users),
                links=dict(links),
                id=place.router_id,
                connect=connect,
                credentials=credentials,
                never_waiting=looked_at,
                lease_ms=session.HELD_MS,
            )
        )

    def _open(self, router: session.Router) -> None:
        try:
            self._stack.enter_context(session.open_router(router))
        except BaseException:
            self.close()
            raise


def _merged(all_users: Iterable[dict[str, Rights]]) -> dict[str, Rights]:
    return {user: found for users in all_users for user, found in users.items()}
