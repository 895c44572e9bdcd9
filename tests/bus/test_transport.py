"""Parts of a session that several share: each hears the others, and takes back at its end its own declarations alone."""

import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from lbr.bus import session, wire
from lbr.bus.session import Session
from lbr.bus.transport import SharedSession, ZenohTransport
from tests.support.waiting import HANG_S, until


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


@pytest.fixture
def parts(endpoint: str) -> Iterator[tuple[ZenohTransport, ZenohTransport]]:
    shared = SharedSession()
    one, two = (shared.enter(lambda: session.open_client([endpoint])) for _ in range(2))
    yield one, two
    two.session.close()


def idle() -> None:
    """Wake nobody."""


Parts = tuple[ZenohTransport, ZenohTransport]


def test_what_one_publishes_the_other_hears_at_once_and_others_do_too(parts: Parts, far: Session) -> None:
    one, two = parts
    near, away = two.subscribe("r/a/x", depth=1, wake=idle), wire.Subscription(far, "r/a/x")
    publisher = one.publisher("r/a/x", "a")
    publisher.put({"n": 1})
    assert [message.payload for message in near.take()] == [b'{"n":1}'], "before `put` returned"
    until(lambda: publisher.put({"n": 2}) and away.take())


def test_one_answers_what_the_other_asks(parts: Parts) -> None:
    one, two = parts
    asked = threading.Event()
    server = one.serve("r/a/do", asked.set, source="a")
    question = two.query("r/a/do", b"{}", timeout_s=5.0, source="b", wake=idle)
    assert asked.wait(HANG_S)
    server.take()[0].reply({"done": True}, "a")
    until(lambda: question.done)
    assert [reply.payload for reply in question.replies] == [b'{"done":true}']


def test_who_leaves_is_heard_no_more_and_the_other_goes_on(parts: Parts, far: Session) -> None:
    one, two = parts
    presence, seen = wire.Presence(far, "r"), two.presence("r", lambda _name, _alive: None)
    for part, name in ((one, "a"), (two, "b")):
        part.alive("r", name)
        part.publisher(f"r/{name}/x", name).put({})
    until(lambda: presence.names == seen.names == {"a", "b"})
    one.close()
    until(lambda: presence.names == seen.names == {"b"})
    assert wire.ask(far, "r/a/x", None, source="c", timeout_s=0.3) == []
    assert wire.ask(far, "r/b/x", None, source="c")
    assert not two.session.is_closed()
    two.close()
    until(lambda: not presence.names)
    assert two.session.is_closed()


def test_who_leaves_while_somebody_begins_or_ends_to_hear_it_fails_nowhere(
    endpoint: str, far: Session, monkeypatch: pytest.MonkeyPatch
) -> None:
    errors: list[BaseException] = []
    monkeypatch.setattr(wire, "on_callback_error", errors.append)
    shared = SharedSession()
    stays, over = shared.enter(lambda: session.open_client([endpoint])), threading.Event()

    def come_and_go() -> None:
        while not over.is_set():
            wire.Subscription(far, "r/a/frame").close()

    coming = threading.Thread(target=come_and_go)
    coming.start()
    try:
        for _ in range(300):
            part = shared.enter(lambda: session.open_client([endpoint]))
            part.publisher("r/a/frame", "a", watching=idle).put({})
            part.close()
    finally:
        over.set()
        coming.join()
    assert wire.ask(far, "r/a/frame", None, source="c", timeout_s=0.3) == []
    stays.close()
    assert errors == []


def test_a_feed_that_was_closed_before_is_closed_at_the_end_without_an_error(parts: Parts) -> None:
    one, two = parts
    closed, kept = (one.subscribe(f"r/{name}", depth=1, wake=idle) for name in ("closed", "kept"))
    closed.close()
    two.put("r/kept", {}, source="b")
    assert kept.take()
    one.close()
    two.put("r/kept", {}, source="b")
    assert not kept.take()
