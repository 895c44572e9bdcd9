"""Where processes come in: at the core, or at an annex that knows rights which the core does not."""

import socket
import threading
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path

import pytest
from msgspec.structs import replace

from lbr.bus import keys, session, wire
from lbr.database import store
from lbr.errors import BusError
from lbr.executive.planning import planner
from lbr.executive.planning.plan import Plan
from lbr.executive.planning.profile import Profile
from lbr.executive.planning.run_identity import RunIdentity
from lbr.executive.processes import doors as module
from lbr.executive.processes.doors import Doors, OpenRouter, core_endpoint, local_endpoint
from tests.support.waiting import HANG_S, until


class Routers:
    """Stands in for the bus library: what it opens is counted, and it may refuse, or never return."""

    def __init__(self) -> None:
        self.open: list[str] = []
        self.links: dict[str, Link] = {}
        self.opened = 0
        self.refuses = False
        self.goes_on = threading.Event()
        self.goes_on.set()

    def __call__(self, router: session.Router, _robot: str) -> "Opened":
        if self.opened >= 2:  # core and local door are there: it is an annex
            self.goes_on.wait()
        if self.refuses:
            raise BusError("no")
        self.opened += 1
        return Opened(self, router)


class Opened:
    def __init__(self, routers: Routers, router: session.Router) -> None:
        self.routers, self.router, self.endpoint = routers, router, router.listen[0]
        routers.open.append(self.endpoint)

    def crossing(self, far: str, _robot: str, wake: Callable[[], None]) -> "Link":
        return self.routers.links.setdefault(far, Link(wake))

    def close(self) -> None:
        if self.endpoint in self.routers.open:
            self.routers.open.remove(self.endpoint)


class Link:
    """Stands in for what tries a link: it is in order until a test says otherwise."""

    def __init__(self, wake: Callable[[], None]) -> None:
        self.wake, self.deaf = wake, False

    def due(self) -> float | None:
        return 0.0 if self.deaf else None

    def broken(self) -> bool:
        deaf, self.deaf = self.deaf, False
        return deaf

    def break_down(self) -> None:
        self.deaf = True
        self.wake()

    def close(self) -> None:
        pass


@pytest.fixture
def site(home: Path, monkeypatch: pytest.MonkeyPatch) -> RunIdentity:
    monkeypatch.setenv("LBR_HOME", str(home))
    monkeypatch.setattr(module, "SETTLED_S", 0.02)
    return RunIdentity(home=str(home), endpoints=(core_endpoint("lbr"),), secret=b"s" * 32)


@pytest.fixture
def found(home: Path, site: RunIdentity) -> tuple[Plan, Plan]:
    """The shipped plan, and one in which what fed the drive has other rights, and so has the drive."""
    with store.Database.open(home / "robot.db") as database:
        rows = database.load("lbr")
    without = replace(rows, channels=tuple(one for one in rows.channels if one.target_end[0] != "drive"))
    made = [planner.make(one, Profile(robot="lbr", simulate=True), site)[0] for one in (rows, without)]
    assert made[0] is not None
    assert made[1] is not None
    return made[0], made[1]


@pytest.fixture
def routers() -> Iterator[Routers]:
    made = Routers()
    yield made
    made.goes_on.set()


def doors_of(plan: Plan, site: RunIdentity, routers: Routers) -> Doors:
    return Doors(plan, site, open_router=routers)  # type: ignore[arg-type]


def place(doors: Doors, plan: Plan, name: str = "drive") -> str:
    return until(lambda: doors.place(plan.units[name])).endpoint


def test_a_client_gets_answers_once_the_local_door_knows_who_has_the_status(
    site: RunIdentity, found: tuple[Plan, Plan]
) -> None:
    with closing(Doors(found[0], site)) as doors:
        core = session.open_client([core_endpoint("lbr")], site.credentials(module.EXECUTIVE))
        with closing(core):
            assert not doors.answers
            status = wire.StaticReply(core, keys.status("lbr"), lambda: "well")
            until(lambda: doors.answers)
            client = session.open_client([local_endpoint("lbr")])
            with closing(client):
                assert wire.ask(client, keys.status("lbr"), None, source="test")
            status.close()


def test_rights_that_come_back_find_their_router_and_no_change_opens_more_than_one(
    site: RunIdentity, found: tuple[Plan, Plan], routers: Routers
) -> None:
    usual, other = found
    with closing(doors_of(usual, site, routers)) as doors:
        assert place(doors, usual) == core_endpoint("lbr")
        doors.adopt(other)
        annex = place(doors, other)
        assert {place(doors, other, name) for name in other.local_units} == {core_endpoint("lbr"), annex}
        assert annex != core_endpoint("lbr")
        doors.tidy([annex])
        doors.adopt(usual)
        assert place(doors, usual) == core_endpoint("lbr")
        doors.adopt(other)
        assert place(doors, other) == annex
        assert routers.opened == 3


def test_an_annex_is_closed_when_none_of_its_processes_runs_or_is_to_run(
    site: RunIdentity, found: tuple[Plan, Plan], routers: Routers
) -> None:
    usual, other = found
    with closing(doors_of(usual, site, routers)) as doors:
        for _ in range(20):
            doors.adopt(other)
            annex = place(doors, other)
            doors.tidy([core_endpoint("lbr"), annex])
            doors.adopt(usual)
            assert annex in routers.open  # its process ends in order, and stops its motion before
            doors.tidy([core_endpoint("lbr")])
            until(lambda gone=annex: gone not in routers.open)
        assert len(routers.open) == 2


def test_who_is_to_come_in_waits_for_a_router_that_does_not_open_and_nobody_else(
    site: RunIdentity, found: tuple[Plan, Plan], routers: Routers, monkeypatch: pytest.MonkeyPatch
) -> None:
    usual, other = found
    routers.goes_on.clear()
    with closing(doors_of(usual, site, routers)) as doors:
        doors.adopt(other)
        assert doors.place(other.units["drive"]) is None
        assert place(doors, other, "motors") == core_endpoint("lbr")
        monkeypatch.setattr(module, "OPENS_WITHIN_S", -1.0)
        until(lambda: refused(doors, other))
        doors.adopt(usual)  # good rows bring it back
        assert place(doors, usual) == core_endpoint("lbr")


def test_a_router_that_is_refused_is_said_and_tried_again(
    site: RunIdentity, found: tuple[Plan, Plan], routers: Routers, monkeypatch: pytest.MonkeyPatch
) -> None:
    usual, other = found
    monkeypatch.setattr(module, "RETRY_S", 0.02)
    with closing(doors_of(usual, site, routers)) as doors:
        routers.refuses = True
        doors.adopt(other)
        assert until(lambda: refused(doors, other)).endswith(": no")
        routers.refuses = False
        until(lambda: not refused(doors, other) and doors.place(other.units["drive"]))


@pytest.mark.parametrize("which", ["local door", "annex"])
def test_a_router_that_nothing_passes_is_opened_again_in_its_place_and_told(
    which: str, site: RunIdentity, found: tuple[Plan, Plan], routers: Routers
) -> None:
    usual, other = found
    with closing(doors_of(usual, site, routers)) as doors:
        doors.adopt(other)
        annex = place(doors, other)
        routers.links[site.router_id("core" if which == "local door" else "annex 1")].break_down()
        told = until(lambda: doors.tidy([annex]))
        assert "opened again" in told[0]
        until(lambda: routers.opened == 4)
        assert sorted(routers.open) == sorted({local_endpoint("lbr"), core_endpoint("lbr"), annex})
        assert doors.tidy([annex]) == []


def test_a_router_answers_no_more_before_its_links_go(tmp_path: Path) -> None:
    """Who has a router's answer and loses its link in the same moment looks for what is gone, and a thread of it ends."""
    core = OpenRouter(session.Router(listen=(f"unixsock-stream/{tmp_path}/core.sock",), id="c0"), "r")
    there = session.Router(listen=(f"unixsock-stream/{tmp_path}/annex.sock",), id="a0", connect=core.router.listen)
    hung = OpenRouter(there, "r")
    with closing(core), session.open_client(core.router.listen) as bus:
        until(lambda: wire.ask(bus, keys.router("r", "a0"), None, source="test", timeout_s=0.2), what="its answer")
        hung._session = watched = Watched(
            hung._session, lambda: bool(wire.ask(bus, keys.router("r", "a0"), None, source="test", timeout_s=0.2))
        )
        hung.close()
        assert watched.closed


def test_a_closed_router_leaves_no_link_that_the_bus_library_forgot(tmp_path: Path) -> None:
    path = str(tmp_path / "door.sock")
    with socket.socket(socket.AF_UNIX) as listening, socket.socket(socket.AF_UNIX) as far:
        listening.bind(path)
        listening.listen()
        far.connect(path)
        forgotten, _ = listening.accept()
        listening.close()
        Path(path).unlink()
        with forgotten:
            OpenRouter(session.Router(listen=(f"unixsock-stream/{path}",)), "r").close()
            far.settimeout(HANG_S)
            assert far.recv(1) == b""


class Watched:
    """A session that is closed only once it answers no more."""

    def __init__(self, opened: session.Session, answers: Callable[[], bool]) -> None:
        self.closed = False
        self._opened, self._answers = opened, answers

    def close(self) -> None:
        try:
            until(lambda: not self._answers(), what="it answers no more")
            self.closed = True
        finally:
            self._opened.close()


def refused(doors: Doors, plan: Plan) -> str:
    try:
        doors.place(plan.units["drive"])
    except BusError as err:
        return str(err)
    return ""
