"""A session that several share: each hears the others, and takes back at its end what it declared and nothing else."""

import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from lbr.bus import session, wire
from lbr.bus.session import Session
from lbr.bus.shared_session import LOOK_AFTER, SharedSession
from tests.support.waiting import until


@pytest.fixture
def endpoint(tmp_path: Path) -> Iterator[str]:
    place = f"unixsock-stream/{tmp_path}/bus.sock"
    with session.open_router(session.Router(listen=(place,))):
        yield place


@pytest.fixture
def far(endpoint: str) -> Iterator[Session]:
    """Somebody else's session."""
    with session.open_client([endpoint]) as bus:
        yield bus


class Shared:
    def __init__(self, endpoint: str) -> None:
        self.closed: list[str] = []
        self.session = SharedSession(session.open_client([endpoint]), self._note, threading.Lock())

    def _note(self) -> None:
        self.closed.append("closed")


@pytest.fixture
def shared(endpoint: str) -> Shared:
    return Shared(endpoint)


def test_what_one_publishes_the_other_hears_at_once_and_others_do_too(shared: Shared, far: Session) -> None:
    one, two = shared.session.enter(), shared.session.enter()
    near, away = wire.Subscription(two, "r/a/x"), wire.Subscription(far, "r/a/x")
    publisher = wire.Publisher(one, "r/a/x", "a")
    publisher.put({"n": 1})
    assert [message.payload for message in near.take()] == [b'{"n":1}'], "before `put` returned"
    until(lambda: publisher.put({"n": 2}) and away.take())
    one.close()
    two.close()


def test_one_answers_what_the_other_asks(shared: Shared) -> None:
    one, two = shared.session.enter(), shared.session.enter()
    asked = threading.Event()
    server = wire.QueryServer(one, "r/a/do", asked.set)

    def answer() -> None:
        assert asked.wait(5.0)
        server.take()[0].reply({"done": True}, "a")

    answering = threading.Thread(target=answer)
    answering.start()
    assert [reply.payload for reply in wire.ask(two, "r/a/do", {}, source="b")] == [b'{"done":true}']
    answering.join()
    one.close()
    two.close()


def test_who_leaves_is_heard_no_more_and_the_other_goes_on(shared: Shared, far: Session) -> None:
    one, two = shared.session.enter(), shared.session.enter()
    presence = wire.Presence(far, "r")
    wire.alive(one, "r", "a"), wire.alive(two, "r", "b")
    publishers = [wire.Publisher(part, f"r/{name}/x", name) for part, name in ((one, "a"), (two, "b"))]
    for publisher in publishers:
        publisher.put({})
    until(lambda: presence.names == {"a", "b"})
    one.close()
    one.close()  # as often as one likes
    until(lambda: presence.names == {"b"})
    assert wire.ask(far, "r/a/x", None, source="c", timeout_s=0.3) == []
    assert wire.ask(far, "r/b/x", None, source="c")
    assert not shared.closed
    two.close()
    until(lambda: not presence.names)
    assert shared.closed == ["closed"]


def test_who_leaves_while_somebody_begins_or_ends_to_hear_it_fails_nowhere(
    shared: Shared, far: Session, monkeypatch: pytest.MonkeyPatch
) -> None:
    errors: list[BaseException] = []
    monkeypatch.setattr(wire, "on_callback_error", errors.append)
    stays, over = shared.session.enter(), threading.Event()

    def come_and_go() -> None:
        while not over.is_set():
            wire.Subscription(far, "r/a/frame").close()

    coming = threading.Thread(target=come_and_go)
    coming.start()
    try:
        for _ in range(300):
            part = shared.session.enter()
            wire.Publisher(part, "r/a/frame", "a", watching=lambda: None).put({})
            part.close()
    finally:
        over.set()
        coming.join()
    stays.close()
    assert errors == []


def test_what_was_taken_back_is_not_kept(shared: Shared) -> None:
    part = shared.session.enter()
    kept = wire.Subscription(part, "r/kept")
    for n in range(3 * LOOK_AFTER):
        wire.Subscription(part, f"r/x{n}").close()
    assert len(part._declared) <= LOOK_AFTER + 1  # type: ignore[attr-defined]
    part.put("r/kept", b"{}")
    assert kept.take()
    part.close()


def test_a_part_shows_its_own_names_alone(shared: Shared) -> None:
    one, two = shared.session.enter(), shared.session.enter()
    seen = wire.Presence(two, "r")
    token = wire.alive(one, "r", "a")
    until(lambda: seen.names == {"a"})
    token.undeclare()
    until(lambda: not seen.names)
    one.close()
    two.close()
