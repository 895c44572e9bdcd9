"""The routers of a robot: the core that its processes meet at, and the doors to it.

    process (user, password) ──► core ◄── annex: opened later, for processes whose rights the core does not know
    anybody at the socket ─────► local door ─┘

The rights of a router are fixed when it opens, and to reopen the core would cut off everything that moves. So an edit
that gives processes other rights opens an annex: a router with these rights, hung on the core. It is closed when none
of the processes runs any more. `lbr/executive/planning/rights.py` has the rights of each.

A thread of its own opens and closes annexes, because the bus library may take its time. Only the processes that are to
come in there wait for it. When a link between two routers has broken, the thread asks whether questions still pass,
and opens the outer router again if not.
"""

import contextlib
import os
import socket
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from lbr import home
from lbr.bus import keys, session
from lbr.bus.access import TOOLS, Credentials, Rights, everything
from lbr.errors import BusError
from lbr.executive import threads
from lbr.executive.planning import rights
from lbr.executive.planning.plan import Plan
from lbr.executive.planning.process_specs import ProcessSpec
from lbr.executive.planning.run_identity import RunIdentity
from lbr.executive.processes import crossing
from lbr.executive.processes.crossing import Crossing

EXECUTIVE, ANNEX = "@executive", "@annex"
CORE = "core"
TRUSTED = Rights(trusted=True)
SETTLED_S = 0.3
"""Routers report changes to one another 0.1 s later. One that is closed before keeps a thread of the library for ten
seconds. The library has fifty of them, and without a free one no client comes in."""
OPENS_WITHIN_S = 5.0
RETRY_S = 1.0
CLOSES_WITHIN_S = 1.0
Users = dict[str, Rights]


def local_endpoint(robot: str) -> str:
    """Return where anybody on this machine who may read the home comes in."""
    return f"unixsock-stream/{home.socket_path(robot)}"


def core_endpoint(robot: str) -> str:
    """Return where the robot's own processes come in."""
    return f"unixsock-stream/{home.socket_path(robot, '.core')}"


def inside_endpoint(robot: str, name: str) -> str:
    """Return where the relay of a door to other machines comes in at it."""
    return f"unixsock-stream/{home.socket_path(robot, f'.{name}')}"


class RouterAddress(NamedTuple):
    """A router that a process comes in at."""

    endpoint: str
    router_id: str


class OpenRouter:
    """A router that is open and answers for itself. Raises BusError if its socket is taken."""

    def __init__(self, router: session.Router, robot: str) -> None:
        self.router = router
        self._session = session.open_router(router)
        self._robot = robot
        self._answer = crossing.answer(self._session, robot)
        self._status: Any = None

    @property
    def knows_status(self) -> bool:
        """Return whether it knows who answers for the status. Routers report such changes within 0.1 s."""
        self._status = self._status or self._session.declare_querier(keys.status(self._robot))
        return bool(self._status.matching_status.matching)

    def crossing(self, far: str, robot: str, wake: Callable[[], None]) -> Crossing:
        """Return what tries the link by which the router with the id `far` has called this one."""
        return Crossing(self._session, far, robot, wake)

    def close(self) -> None:
        """Close it, and remove its socket; its answer goes first, or the far end of a link looks at times for what is
        gone."""
        self._answer.close()
        self._session.close()
        path = self.router.listen[0].removeprefix("unixsock-stream/")
        _cut_links_to(path)
        with contextlib.suppress(OSError):
            Path(path).unlink()


class Hung:
    """A router that the core can do without for a moment, and the link between the two."""

    def __init__(self, opened: OpenRouter, tried: Callable[[OpenRouter], Crossing]) -> None:
        self._tried = tried
        self.opened = opened
        self.crossing = tried(opened)

    def close(self) -> None:
        """Close the router."""
        self.crossing.close()
        self.opened.close()

    def reopen(self, open_router: Callable[[session.Router], OpenRouter]) -> None:
        """Close the router and open it again in its place."""
        self.close()
        self.opened = open_router(self.opened.router)
        self.crossing = self._tried(self.opened)


class Annex(NamedTuple):
    """A router for the processes of one change; `known` is what each of them may do there."""

    place: RouterAddress
    known: dict[str, Users]
    hung: Hung


class Doors:
    """Opens core and local door, and annexes as plans need them. Raises BusError if a socket is taken.

    `wake` is called when a router has opened for a process that waits, or there is news. `open_router` is there for
    tests.
    """

    def __init__(
        self,
        plan: Plan,
        site: RunIdentity,
        wake: Callable[[], None] = lambda: None,
        open_router: Callable[[session.Router, str], OpenRouter] = OpenRouter,
    ) -> None:
        self._robot = plan.robot
        self._site = site
        self._wake = wake
        self._open_router = open_router
        self._news: deque[str] = deque()
        self._plan = plan
        self._wanted = _wanted(plan)
        self._in_use: frozenset[str] = frozenset()
        self._annexes: list[Annex] = []
        self._opened = 0
        self._since: float | None = None
        self._trouble = ""
        self._settled_at = self._retry_at = 0.0
        self._over = False
        self._changed = threading.Condition()
        self._known = dict(self._wanted)
        self._core = RouterAddress(core_endpoint(self._robot), site.router_id(CORE))
        local_id = site.router_id("local")
        local = self._open(
            session.Router(
                listen=(local_endpoint(self._robot),),
                id=local_id,
                never_waiting=everything(self._robot),
                urgent_waits=True,
            )
        )
        with contextlib.ExitStack() as failed:
            failed.callback(local.close)
            core = self._open(
                self._router(
                    self._core,
                    {EXECUTIVE: TRUSTED, TOOLS: TRUSTED, ANNEX: TRUSTED} | _merged(self._known.values()),
                    links={local_id: rights.of_local(plan)},
                    connect=(local_endpoint(self._robot),),
                )
            )
            failed.pop_all()
        self._core_router = core
        self._local = Hung(local, lambda opened: opened.crossing(self._core.router_id, self._robot, self._notify))
        self._worker = threading.Thread(target=self._work, name="doors", daemon=True)
        self._worker.start()

    @property
    def answers(self) -> bool:
        """Return whether the executive answers a client at the local door.

        A router knows of the status for up to 0.1 s before its clients' questions find the way there.
        """
        return self._local.crossing.passes and self._local.opened.knows_status

    def adopt(self, plan: Plan) -> None:
        """Adopt a plan: one annex is opened for all its processes whose rights no router knows."""
        wanted = _wanted(plan)
        with self._changed:
            self._plan, self._wanted, self._trouble, self._retry_at = plan, wanted, "", 0.0
            self._changed.notify_all()

    def place(self, unit: ProcessSpec) -> RouterAddress | None:
        """Return where a process of the plan has its rights, None if that is being opened; BusError if it cannot be."""
        with self._changed:
            found = self._find(unit.name)
            if found is not None or unit.name not in self._wanted:
                return found
            if self._trouble:
                raise BusError(f"the router for its rights did not open: {self._trouble}")
            if self._since is not None and time.monotonic() - self._since > OPENS_WITHIN_S:
                text = f"the router for its rights has not opened within {OPENS_WITHIN_S:.0f} s"
                raise BusError(f"{text}; the robot runs on without it until it is restarted")
            return None

    def tidy(self, in_use: Iterable[str]) -> list[str]:
        """Have the annexes closed that no process of the plan needs and none runs at, by their endpoints.

        Return the news of the routers, each text once.
        """
        found = frozenset(in_use)
        with self._changed:
            if found != self._in_use:
                self._in_use = found
                self._changed.notify_all()
        return [self._news.popleft() for _ in range(len(self._news))]

    def close(self) -> None:
        """Close every router, the newest first, as far as the bus library does so in time."""
        with self._changed:
            self._over = True
            self._changed.notify_all()
        closing = threads.begin(self._close_all, "doors close")
        if closing is not None:
            closing.join(CLOSES_WITHIN_S)

    def _close_all(self) -> None:
        self._worker.join(CLOSES_WITHIN_S)
        for annex in reversed(self._annexes):
            annex.hung.close()
        self._core_router.close()
        self._local.close()

    # -- the thread that opens and closes annexes ---------------------------------------------------------------------

    def _work(self) -> None:
        while (job := self._next_job()) is not None:
            job()

    def _next_job(self) -> Callable[[], None] | None:
        """Wait for something to open or to close; None if all is over."""
        with self._changed:
            while not self._over:
                now, missing, unused = time.monotonic(), self._missing(), self._unused()
                if missing and now >= self._retry_at:
                    return partial(self._open_annex, missing)
                if unused is not None and now >= self._settled_at:
                    self._annexes.remove(unused)  # so that no process is sent there
                    return partial(self._close_annex, unused)
                doubts = {
                    due: hung
                    for hung in (self._local, *(annex.hung for annex in self._annexes))
                    if (due := hung.crossing.due()) is not None
                }
                if doubts and now >= min(doubts):
                    return partial(self._look_across, doubts[min(doubts)])
                dues = [*doubts, *([self._retry_at] if missing else ()), *([self._settled_at] if unused else ())]
                self._changed.wait(min(dues) - now if dues else None)
        return None

    def _look_across(self, hung: Hung) -> None:
        if not hung.crossing.broken():
            return
        text = "a link of the bus had broken and nothing passed over it any more; its router was opened again"
        self._news.append(text)
        self._wake()
        with contextlib.suppress(BusError):  # all is over before its socket is free
            hung.reopen(self._open_at_last)

    def _open_at_last(self, router: session.Router) -> OpenRouter:
        while True:
            try:
                return self._open(router)
            except BusError:
                if self._over:
                    raise
                time.sleep(RETRY_S)

    def _notify(self) -> None:
        with self._changed:
            self._changed.notify_all()

    def _missing(self) -> dict[str, Users]:
        return {name: users for name, users in self._wanted.items() if self._find(name) is None}

    def _unused(self) -> Annex | None:
        needed = {place.endpoint for name in self._wanted if (place := self._find(name)) is not None} | self._in_use
        return next((annex for annex in self._annexes if annex.place.endpoint not in needed), None)

    def _close_annex(self, annex: Annex) -> None:
        annex.hung.close()
        with self._changed:
            self._settled_at = time.monotonic() + SETTLED_S

    def _find(self, name: str) -> RouterAddress | None:
        wanted = self._wanted.get(name)
        if wanted is None or self._known.get(name) == wanted:
            return self._core if wanted is not None else None
        return next((annex.place for annex in self._annexes if annex.known.get(name) == wanted), None)

    def _open_annex(self, known: dict[str, Users]) -> None:
        with self._changed:
            self._opened += 1
            number, plan = self._opened, self._plan
            self._since = time.monotonic()
        socket = home.socket_path(self._robot, f".{number}")
        place = RouterAddress(f"unixsock-stream/{socket}", self._site.router_id(f"annex {number}"))
        router = self._router(
            place,
            _merged(known.values()),
            links={self._core.router_id: TRUSTED},
            connect=(self._core.endpoint,),
            credentials=self._site.credentials(ANNEX),
            plan=plan,
        )
        try:
            hung, trouble = Hung(self._open(router), lambda _opened: self._cross_to(place)), ""
        except BusError as err:
            hung, trouble = None, str(err)
        with self._changed:
            now = time.monotonic()
            self._since, self._trouble = None, trouble
            self._settled_at, self._retry_at = now + SETTLED_S, now + RETRY_S if trouble else 0.0
            if hung is not None:
                self._annexes.append(Annex(place, known, hung))
        self._wake()

    # -- routers -------------------------------------------------------------------------------------------------------

    def _router(
        self,
        place: RouterAddress,
        users: Mapping[str, Rights],
        *,
        links: Mapping[str, Rights],
        connect: tuple[str, ...],
        credentials: Credentials | None = None,
        plan: Plan | None = None,
    ) -> session.Router:
        return session.Router(
            listen=(place.endpoint,),
            robot=self._robot,
            users={user: self._site.credentials(user).password for user in users},
            rights=dict(users),
            links=dict(links),
            id=place.router_id,
            connect=connect,
            credentials=credentials,
            never_waiting=rights.looked_at(plan or self._plan),
        )

    def _cross_to(self, place: RouterAddress) -> Crossing:
        return self._core_router.crossing(place.router_id, self._robot, self._notify)

    def _open(self, router: session.Router) -> OpenRouter:
        return self._open_router(router, self._robot)


def _cut_links_to(path: str) -> None:
    """Cut what is still connected to the socket of a closed router.

    The bus library forgets a link that comes before an older one of the same end has gone, and never closes it. The
    other end holds a link to nobody then, and never connects again.
    """
    for entry in Path("/proc/self/fd").iterdir():
        with contextlib.suppress(OSError):  # it has been closed meanwhile
            if not entry.is_socket():
                continue
            with socket.socket(fileno=os.dup(int(entry.name))) as link:
                if link.family == socket.AF_UNIX and link.getsockname() == path:
                    link.shutdown(socket.SHUT_RDWR)


def _wanted(plan: Plan) -> dict[str, Users]:
    return {name: rights.of_unit(plan, unit) for name, unit in plan.local_units.items()}


def _merged(all_users: Iterable[Users]) -> Users:
    """Return every user; those of a shared process have what each of its capabilities may do."""
    merged: Users = {}
    for users in all_users:
        for user, found in users.items():
            merged[user] = merged[user].and_of(found) if user in merged else found
    return merged
