"""The routers of a robot: the core that its processes meet at, and the doors to it.

    process (user, password) ──► core ◄── annex: opened later, for processes whose rights the core does not know
    anybody at the socket ─────► local door ─┘

What a router allows is fixed when it opens, and to open the core anew would cut off everything that moves. So a
process that an edit has given other rights gets an annex: a router that knows its rights, hung on the core for as
long as the robot runs. `lbr/executive/rights.py` says who may do what.
"""

import secrets
from collections.abc import Iterable, Mapping
from contextlib import ExitStack

from lbr import home
from lbr.bus import session
from lbr.bus.access import TOOLS, Credentials, Rights
from lbr.executive import rights
from lbr.executive.plan import Plan, Site, Unit

EXECUTIVE, ANNEX = "@executive", "@annex"
TRUSTED = Rights(trusted=True)


def local_endpoint(robot: str) -> str:
    """Return where anybody on this machine who may read the home comes in."""
    return f"unixsock-stream/{home.socket_path(robot)}"


def core_endpoint(robot: str) -> str:
    """Return where the robot's own processes come in."""
    return f"unixsock-stream/{home.socket_path(robot, '.core')}"


class Doors:
    """Opens core and local door; `place` says where a process comes in. Raises BusError if a socket is taken."""

    def __init__(self, plan: Plan, site: Site) -> None:
        self._robot = plan.robot
        self._site = site
        self._stack = ExitStack()
        self._known: dict[str, tuple[str, dict[str, Rights]]] = {}
        self._annexes = 0
        core = {name: rights.of_unit(plan, unit) for name, unit in plan.units.items()}
        link = secrets.token_hex(8)
        self._open(session.Router(listen=(local_endpoint(self._robot),), id=link))
        self._open_for(
            core_endpoint(self._robot),
            {EXECUTIVE: TRUSTED, TOOLS: TRUSTED, ANNEX: TRUSTED} | _merged(core.values()),
            links={link: rights.of_local(plan)},
            connect=(local_endpoint(self._robot),),
        )
        self._known |= {name: (core_endpoint(self._robot), users) for name, users in core.items()}

    def credentials(self, user: str) -> Credentials:
        """Return how a user proves itself, the same for the whole run."""
        return self._site.credentials(user)

    def place(self, plan: Plan, unit: Unit) -> str:
        """Return the endpoint where a process has its rights; opens an annex if nothing knows them."""
        wanted = rights.of_unit(plan, unit)
        where, known = self._known.get(unit.name, ("", {}))
        if known != wanted:
            self._annexes += 1
            where = f"unixsock-stream/{home.socket_path(self._robot, f'.{self._annexes}')}"
            up = (core_endpoint(self._robot),)
            self._open_for(where, wanted, connect=up, credentials=self.credentials(ANNEX))
            self._known[unit.name] = (where, wanted)
        return where

    def close(self) -> None:
        """Close every router, the newest first."""
        self._stack.close()

    def _open_for(
        self,
        endpoint: str,
        users: Mapping[str, Rights],
        *,
        connect: tuple[str, ...],
        links: Mapping[str, Rights] | None = None,
        credentials: Credentials | None = None,
    ) -> None:
        self._open(
            session.Router(
                listen=(endpoint,),
                robot=self._robot,
                users={user: self.credentials(user).password for user in users},
                rights=dict(users),
                links=dict(links or {}),
                connect=connect,
                credentials=credentials,
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
